"""Blender's half of scripts/authoring_pictures.sh: makes a scene, exports its hair as a user would,
and renders it.

    blender -b --factory-startup --python authoring_pictures.py -- FOLDER
"""

import os
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
sys.dont_write_bytecode = True
sys.path[:0] = [os.path.join(ROOT, "tests/blender"), os.path.join(ROOT, "tools/blender")]

import bpy  # noqa: E402
import make_scene  # noqa: E402
import mathutils  # noqa: E402
import pelage_export  # noqa: E402

FOLDER = sys.argv[sys.argv.index("--") + 1]
TARGET = mathutils.Vector(make_scene.BUST_AT) + mathutils.Vector((0, 0, 0.23))
VIEW = mathutils.Vector((1, 0.3, 0.25))  # the sample looks from there, too


def export():
    bpy.ops.object.select_all(action="DESELECT")
    for name in ("bust", "long_hair"):
        bpy.data.objects[name].select_set(True)
    bpy.ops.export_scene.pelage_hair(
        filepath=os.path.join(FOLDER, "bust.tfx"), vertices_per_strand=24,
        collision="COLLECTION", collision_collection="colliders")


def render():
    scene = bpy.context.scene
    bpy.data.armatures["rig"].pose_position = "REST"
    bpy.data.objects["braid"].hide_render = True
    # Wider than it is, or it is lost between the few pixels.
    curves = bpy.data.objects["long_hair"].data
    curves.attributes["radius"].data.foreach_set("value", [2.5e-4] * len(curves.points))
    bpy.data.objects["bust"].particle_systems["undercoat"].settings.radius_scale = 0.05
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = TARGET + VIEW.normalized() * 1.25
    camera.rotation_euler = (TARGET - camera.location).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens = 75
    scene.collection.objects.link(camera)
    scene.camera = camera
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 4
    sun.rotation_euler = (0.5, 0.6, 0.9)
    scene.collection.objects.link(sun)
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.2, 0.23, 0.28, 1)
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 96
    scene.cycles.use_denoising = False  # Debian's Blender has no denoiser
    scene.render.resolution_x = scene.render.resolution_y = 320
    scene.render.filepath = os.path.join(FOLDER, "blender.png")
    bpy.ops.render.render(write_still=True)


pelage_export.register()
make_scene.make_scene(particle_count=900, curve_count=900)
export()
render()
