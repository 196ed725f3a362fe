"""Imports caches by the operator, as a user's script would, and compares the points of the hair
curves with what the library reads from the same files (write_cache.cpp).

    blender -b --factory-startup --python-exit-code 1 --python import_test.py -- FOLDER
"""

import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path[:0] = [os.path.join(HERE, "../../tools/blender")]

import bpy  # noqa: E402
import numpy as np  # noqa: E402
import pelage_export  # noqa: E402

FOLDER = sys.argv[sys.argv.index("--") + 1]
FIRST, FRAMES = 101, 9


def check(condition, what):
    if not condition:
        raise AssertionError(what)


def points_of(obj):
    values = np.empty(3 * len(obj.data.points), np.float32)
    obj.data.attributes["position"].data.foreach_get("vector", values)
    return values.reshape(-1, 3)


def expected(name):
    """[frame, vertex, 3] in Blender's axes: z is up."""
    floats = np.fromfile(os.path.join(FOLDER, name + ".pelagecache.f32"), "<f4")
    x, y, z = np.moveaxis(floats.reshape(FRAMES, -1, 3), 2, 0)
    return np.stack((x, -z, y), axis=2)


def go_to(frame):
    whole = int(np.floor(frame))
    bpy.context.scene.frame_set(whole, subframe=frame - whole)


def test_import(name):
    path = os.path.join(FOLDER, name + ".pelagecache")
    check(bpy.ops.import_scene.pelage_cache(filepath=path) == {"FINISHED"}, name)
    scene, obj = bpy.context.scene, bpy.context.view_layer.objects.active
    check(obj.type == "CURVES" and obj.name == name, "%s is %s %s" % (name, obj.type, obj.name))
    check((scene.frame_start, scene.frame_end) == (FIRST, FIRST + FRAMES - 1), "frame range")
    check(abs(scene.render.fps / scene.render.fps_base - 24) < 1e-3, "frames per second")
    want = expected(name)
    # In order, back, and beyond both ends.
    for frame in [*range(FRAMES), 7, 2, 3, 50, -50]:
        go_to(FIRST + frame)
        clamped = min(max(frame, 0), FRAMES - 1)
        check(np.array_equal(points_of(obj), want[clamped]), "%s: frame %d" % (name, frame))
    go_to(FIRST + 2.25)
    between = 0.75 * want[2] + 0.25 * want[3]
    check(np.abs(points_of(obj) - between).max() < 1e-6, name + ": between two frames")
    # The evaluated object is drawn and rendered.
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    check(np.array_equal(points_of(evaluated), points_of(obj)), name + ": evaluated")
    return obj


def test_reload():
    """A saved scene plays on: the handler is persistent, and the object knows its file."""
    path = os.path.join(FOLDER, "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    go_to(FIRST + 4)
    check(np.array_equal(points_of(bpy.data.objects["odd"]), expected("odd")[4]), "reloaded")


def expect_error(text, path):
    try:
        bpy.ops.import_scene.pelage_cache(filepath=path)
    except RuntimeError as error:
        check(text in str(error), "'%s' is not in '%s'" % (text, error))
    else:
        raise AssertionError("no error with '%s'" % text)


def test_broken_files():
    expect_error("No such file", os.path.join(FOLDER, "missing.pelagecache"))
    with open(os.path.join(FOLDER, "odd.pelagecache"), "rb") as file:
        good = file.read()
    path = os.path.join(FOLDER, "broken.pelagecache")
    for length, text in ((0, "incomplete"), (40, "incomplete"), (len(good) - 1, "closed"),
                         (len(good) // 2, "closed")):
        with open(path, "wb") as file:
            file.write(good[:length])
        expect_error(text, path)
    with open(path, "wb") as file:
        file.write(b"x" + good[1:])
    expect_error("no .pelagecache", path)


pelage_export.register()
counts = [len(curve.points) for curve in test_import("odd").data.curves]
check(counts == [2 + s * 7 % 13 for s in range(90)], "points of the curves")
test_import("even")
test_import("exact")
test_broken_files()
test_reload()
pelage_export.unregister()
print("3 caches play as they were written")
