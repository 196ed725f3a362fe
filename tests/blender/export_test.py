"""Exports the scene of make_scene.py by the operator, as a user's script would; export_test.cpp
judges the files. What only Blender knows is checked here.

    blender -b --factory-startup --python-exit-code 1 --python export_test.py -- FOLDER
"""

import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path[:0] = [HERE, os.path.join(HERE, "../../tools/blender")]

import bpy  # noqa: E402
import make_scene  # noqa: E402
import numpy as np  # noqa: E402
import pelage_export  # noqa: E402
from pelage_export import gather  # noqa: E402

FOLDER = sys.argv[sys.argv.index("--") + 1]


def select(*names):
    bpy.ops.object.select_all(action="DESELECT")
    for name in names:
        bpy.data.objects[name].select_set(True)


def export(name, **options):
    result = bpy.ops.export_scene.pelage_hair(filepath=os.path.join(FOLDER, name + ".tfx"),
                                              **options)
    check(result == {"FINISHED"}, "%s: %s" % (name, result))


def export_collision(name, **options):
    result = bpy.ops.export_scene.pelage_collision(
        filepath=os.path.join(FOLDER, name + ".tfxmesh"), **options)
    check(result == {"FINISHED"}, "%s: %s" % (name, result))


def read(name):
    with open(os.path.join(FOLDER, name), "rb") as file:
        return file.read()


def check(condition, what):
    if not condition:
        raise AssertionError(what)


def expect_error(text, operator="pelage_hair", **options):
    """An operator fails with this text, and leaves no file."""
    before = sorted(os.listdir(FOLDER))
    try:
        getattr(bpy.ops.export_scene, operator)(
            **{"filepath": os.path.join(FOLDER, "error.tfx"), **options})
    except RuntimeError as error:
        check(text in str(error), "'%s' is not in '%s'" % (text, error))
    else:
        raise AssertionError("no error with '%s'" % text)
    check(sorted(os.listdir(FOLDER)) == before, "an error left files: %s" % text)


def scene_state():
    """What an export changes for a while."""
    bust = bpy.data.objects["bust"]
    system = bust.particle_systems["undercoat"]
    settings = system.settings
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = bust.evaluated_get(depsgraph).data
    highest = np.array([tuple(vertex.co) for vertex in mesh.vertices]).max(axis=0)
    return (bpy.data.armatures["rig"].pose_position, settings.display_step,
            settings.display_percentage, settings.display_method, system.use_hair_dynamics,
            [modifier.show_viewport for modifier in bust.modifiers], tuple(highest))


def export_all():
    select("bust", "long_hair", "braid", "rig")
    export("default")
    select("bust")
    export("particles", vertices_per_strand=8)
    # However coarse the viewport shows hair, the strands are the same.
    settings = bpy.data.objects["bust"].particle_systems["undercoat"].settings
    settings.display_step = 3
    export("finer", vertices_per_strand=8)
    settings.display_step = 2
    check(read("finer.tfx") == read("particles.tfx"), "strands depend on the viewport's steps")
    export("children", vertices_per_strand=8, use_children=True)
    export("up_y", vertices_per_strand=8, up_axis="Y", collision="NONE")
    for name, seed in (("shuffled", 7), ("again", 7), ("other", 8)):
        export(name, vertices_per_strand=8, collision="NONE", randomize_strands=True, seed=seed)
    select("long_hair")
    export("curves", vertices_per_strand=24, collision="COLLECTION",
           collision_collection="colliders")
    export("options", vertices_per_strand=24, both_ends_immovable=True, invert_z=True,
           invert_v=True, scale=2.0, color_attribute="tint", collision="COLLECTION",
           collision_collection="colliders", collision_split="OBJECT")
    export("materials", vertices_per_strand=24, collision="COLLECTION",
           collision_collection="colliders", collision_split="MATERIAL")
    select("bust", "long_hair")
    export("long_only", min_curve_length=0.06)
    # The unit of a scene counts: these are centimetres.
    bpy.context.scene.unit_settings.scale_length = 0.01
    select("braid")
    export("centimetres", collision="NONE")
    bpy.context.scene.unit_settings.scale_length = 1.0
    export("braid", collision="NONE", surface="collar")


def export_meshes_alone():
    """They are those of an export with hair, in rest pose; a choice leaves files out."""
    select("rig")
    export_collision("alone", collision_collection="colliders")
    check(read("alone.tfxmesh") == read("curves.tfxmesh"), "meshes depend on the hair")
    select("bust", "collar", "braid")
    export_collision("alone_split", collision_split="OBJECT", scale=2.0, invert_z=True)
    for part in ("_bust", "_collar"):
        check(read("alone_split%s.tfxmesh" % part) == read("options%s.tfxmesh" % part), part)
    select("long_hair")
    export("bones_only", vertices_per_strand=24, collision="NONE", export_hair=False)
    check(read("bones_only.tfxbone") == read("curves.tfxbone"), "bones depend on the choice")
    check(not os.path.exists(os.path.join(FOLDER, "bones_only.tfx")), "hair was not chosen")


def distance_to_line(points, line):
    """Largest distance of points from a line of segments."""
    a, edge = line[:-1], line[1:] - line[:-1]
    length2 = np.maximum((edge**2).sum(axis=1), 1e-30)
    t = np.clip(((points[:, None] - a) * edge).sum(axis=2) / length2, 0, 1)
    return np.linalg.norm(points[:, None] - a - t[:, :, None] * edge, axis=2).min(axis=1).max()


def gather_nurbs():
    """The exporter's points of NURBS splines are on the curves that Blender draws."""
    shapes = [(4, 3, True, False), (6, 4, True, False), (6, 4, False, False), (7, 4, False, True),
              (7, 3, True, True), (3, 5, True, False)]
    for count, order, ends, bezier in shapes:
        data = bpy.data.curves.new("nurbs", "CURVE")
        data.dimensions, data.resolution_u = "3D", 1024
        spline = data.splines.new("NURBS")
        spline.points.add(count - 1)
        for k, point in enumerate(spline.points):
            point.co = (math.cos(k), math.sin(2 * k), 0.3 * k, 1 + 0.5 * (k % 2))
        spline.order_u, spline.use_endpoint_u, spline.use_bezier_u = order, ends, bezier
        obj = bpy.data.objects.new("nurbs", data)
        bpy.context.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        curves = gather.Gatherer(depsgraph).curves_of(obj)[0]
        mesh = obj.evaluated_get(depsgraph).to_mesh()
        drawn = np.array([tuple(vertex.co) for vertex in mesh.vertices])
        shape = "%d points, order %d, endpoint %s, bezier %s" % (count, order, ends, bezier)
        check(distance_to_line(curves.points, drawn) < 1e-3, shape)
        check(np.linalg.norm(curves.points[[0, -1]] - drawn[[0, -1]], axis=1).max() < 1e-5, shape)
        # As hair curves they are the same.
        select()
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.convert(target="CURVES")
        depsgraph = bpy.context.evaluated_depsgraph_get()
        converted = gather.Gatherer(depsgraph).curves_of(bpy.context.view_layer.objects.active)[0]
        check(np.abs(converted.points - curves.points).max() < 1e-6, "hair curves: " + shape)
        bpy.data.objects.remove(bpy.context.view_layer.objects.active)


def export_without_armature():
    """A mesh that no armature moves is one bone."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6, location=(3, 0, 0))
    plain = bpy.context.object
    plain.name = "plain"
    plain.scale = (-1, 1, 1)  # mirrored: its faces must not turn inside out
    make_scene.add_particle_hair(plain, "fuzz", 10, 0.2, 1).vertex_group_density = ""
    select("plain")
    export("plain", vertices_per_strand=4)


def export_wrongly():
    select("rig")
    expect_error("no hair")
    select("collar")
    expect_error("no hair")
    select("bust")
    expect_error("none of the 300 curves", min_curve_length=10.0)
    expect_error("no collection 'x'", collision="COLLECTION", collision_collection="x")
    expect_error("'x' is no mesh", surface="x")
    expect_error("cannot write", filepath=os.path.join(FOLDER, "no_folder", "error.tfx"))
    bpy.context.view_layer.objects.active = bpy.data.objects["bust"]
    bpy.ops.object.mode_set(mode="EDIT")
    expect_error("edit mode")
    expect_error("edit mode", operator="pelage_collision")
    bpy.ops.object.mode_set(mode="OBJECT")
    select("rig")
    expect_error("no mesh", operator="pelage_collision")
    expect_error("no collection 'x'", operator="pelage_collision", collision_collection="x")


class Layout:
    """Stands in for a layout, of which there is none without a window: a panel that shows a
    property that is not there fails only when it is drawn."""

    def row(self, **_):
        return self

    column = row

    def prop(self, settings, name):
        check(name in settings.bl_rna.properties, "the panel shows '%s'" % name)
        SHOWN.add(name)

    def prop_search(self, settings, name, owner, collection):
        self.prop(settings, name)
        getattr(owner, collection)

    def operator(self, name, **_):
        OPERATORS.append(name)


SHOWN, OPERATORS = set(), []


def draw_panel():
    """The panel shows all options."""
    settings = bpy.context.scene.pelage_export
    settings.collision = "COLLECTION"
    panel = bpy.types.VIEW3D_PT_pelage_export
    panel.draw(type("Panel", (), {"layout": Layout()}), bpy.context)
    missing = set(settings.bl_rna.properties.keys()) - SHOWN - {"rna_type", "name"}
    check(not missing, "the panel lacks %s" % missing)
    check(OPERATORS == ["export_scene.pelage_hair", "export_scene.pelage_collision"], OPERATORS)


def main():
    pelage_export.register()
    make_scene.make_scene()
    bust = bpy.data.objects["bust"]
    settings = bust.particle_systems["undercoat"].settings
    # Settings for a fast viewport, which must not make the exported hair any coarser or fewer.
    settings.display_step, settings.display_percentage = 2, 10
    settings.display_method = "NONE"
    bust.modifiers["undercoat"].show_viewport = False
    before = scene_state()
    export_all()
    export_meshes_alone()
    gather_nurbs()
    export_without_armature()
    check(scene_state() == before, "the scene is not as it was: %s" % (scene_state(),))
    draw_panel()
    export_wrongly()
    check(scene_state() == before, "an error left the scene changed: %s" % (scene_state(),))
    pelage_export.unregister()
    check(not hasattr(bpy.types.Scene, "pelage_export"), "unregister() left its settings")


main()
