"""Exports the scene of make_scene.py by the operator, as a user's script would; export_test.cpp
judges the files. What only Blender knows is checked here.

    blender -b --factory-startup --python-exit-code 1 --python export_test.py -- FOLDER
"""

import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path[:0] = [HERE, os.path.join(HERE, "../../tools/blender")]

import bpy  # noqa: E402
import make_scene  # noqa: E402
import numpy as np  # noqa: E402
import pelage_export  # noqa: E402

FOLDER = sys.argv[sys.argv.index("--") + 1]


def select(*names):
    bpy.ops.object.select_all(action="DESELECT")
    for name in names:
        bpy.data.objects[name].select_set(True)


def export(name, **options):
    result = bpy.ops.export_scene.pelage_hair(filepath=os.path.join(FOLDER, name + ".tfx"),
                                              **options)
    check(result == {"FINISHED"}, "%s: %s" % (name, result))


def read(name):
    with open(os.path.join(FOLDER, name), "rb") as file:
        return file.read()


def check(condition, what):
    if not condition:
        raise AssertionError(what)


def expect_error(text, **options):
    """The operator fails with this text, and leaves no file."""
    before = sorted(os.listdir(FOLDER))
    try:
        bpy.ops.export_scene.pelage_hair(
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
    bpy.ops.object.mode_set(mode="OBJECT")
    select("braid")
    spline = bpy.data.objects["braid"].data.splines[0]
    spline.type = "NURBS"
    expect_error("NURBS")


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
        check(name == "export_scene.pelage_hair", name)


SHOWN = set()


def draw_panel():
    """The panel shows all options."""
    settings = bpy.context.scene.pelage_export
    settings.collision = "COLLECTION"
    panel = bpy.types.VIEW3D_PT_pelage_export
    panel.draw(type("Panel", (), {"layout": Layout()}), bpy.context)
    missing = set(settings.bl_rna.properties.keys()) - SHOWN - {"rna_type", "name"}
    check(not missing, "the panel lacks %s" % missing)


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
    export_without_armature()
    check(scene_state() == before, "the scene is not as it was: %s" % (scene_state(),))
    draw_panel()
    export_wrongly()
    check(scene_state() == before, "an error left the scene changed: %s" % (scene_state(),))
    pelage_export.unregister()
    check(not hasattr(bpy.types.Scene, "pelage_export"), "unregister() left its settings")


main()
