"""Import of simulated hair: a .pelagecache as hair curves that follow the time line."""

import os

import bpy
import numpy as np
from bpy.app.handlers import persistent
from bpy_extras.io_utils import ImportHelper

from .pelage_core import ExportError
from .pelage_core.hair import up_matrix
from .pelage_core.hair_cache import HairCache

_PATH, _AXIS, _SCALE = "pelage_cache", "pelage_cache_up_axis", "pelage_cache_scale"
_caches = {}  # path -> (time of the file, HairCache)


def _cache_of(path):
    path = bpy.path.abspath(path)
    try:
        changed = os.path.getmtime(path)
    except OSError as error:
        raise ExportError("%s: %s" % (path, error.strerror)) from None
    if path not in _caches or _caches[path][0] != changed:
        _caches[path] = (changed, HairCache(path))
    return _caches[path][1]


def _positions(cache, frame, axes):
    """Of a moment between frames, on the line between them: for motion blur."""
    at = min(max(frame - cache.first_frame, 0.0), cache.frame_count - 1.0)
    low = int(at)
    positions = cache.read(low)
    if at > low:
        positions = positions + (cache.read(low + 1) - positions) * np.float32(at - low)
    return positions @ axes.astype(np.float32)


def show_frame(scene, obj):
    """Moves the points of an imported object to where they are in the scene's frame."""
    cache = _cache_of(obj[_PATH])
    if len(obj.data.points) != cache.vertex_count:
        raise ExportError("'%s' has %d points, and its cache %d vertices"
                          % (obj.name, len(obj.data.points), cache.vertex_count))
    axes = up_matrix(obj[_AXIS], False) * obj[_SCALE]
    positions = np.ascontiguousarray(_positions(cache, scene.frame_current_final, axes))
    obj.data.attributes["position"].data.foreach_set("vector", positions.ravel())
    obj.data.update_tag()


@persistent
def _on_frame(scene, _depsgraph=None):
    for obj in scene.objects:
        if obj.type != "CURVES" or _PATH not in obj:
            continue
        try:
            show_frame(scene, obj)
        except ExportError as error:
            print("pelage: %s: %s" % (obj.name, error))


def _make_curves(context, cache, radius):
    """Hair curves; Blender 3.3 and 3.4 make them of splines alone."""
    splines = bpy.data.curves.new(cache.name or "hair", "CURVE")
    splines.dimensions = "3D"
    for count in cache.counts:
        points = splines.splines.new("POLY").points
        points.add(int(count) - 1)
        points.foreach_set("radius", np.full(count, radius, np.float32))
    obj = bpy.data.objects.new(cache.name or "hair", splines)
    context.collection.objects.link(obj)
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    bpy.ops.object.convert(target="CURVES")
    obj = context.view_layer.objects.active
    bpy.data.curves.remove(splines)
    return obj


def import_cache(context, path, up_axis="Z", radius=4e-5, set_range=True):
    """Makes an object of a cache. :returns: the object. Raises ExportError."""
    cache = _cache_of(path)
    if cache.frame_count == 0:
        raise ExportError("%s has no frames" % path)
    unit_settings = context.scene.unit_settings
    scale = 1.0 if unit_settings.system == "NONE" else 1 / unit_settings.scale_length
    obj = _make_curves(context, cache, radius * scale)
    obj[_PATH], obj[_AXIS], obj[_SCALE] = path, up_axis, scale
    if set_range:
        context.scene.frame_start = max(cache.first_frame, 0)
        context.scene.frame_end = max(cache.first_frame + cache.frame_count - 1, 0)
        context.scene.render.fps = max(round(cache.fps), 1)
        context.scene.render.fps_base = context.scene.render.fps / cache.fps
    show_frame(context.scene, obj)
    return obj


class ImportPelageCache(bpy.types.Operator, ImportHelper):
    """Import simulated hair as hair curves that follow the time line"""

    bl_idname = "import_scene.pelage_cache"
    bl_label = "Import pelage Cache"
    bl_options = {"UNDO", "PRESET"}

    __annotations__ = {
        "filter_glob": bpy.props.StringProperty(default="*.pelagecache", options={"HIDDEN"}),
        "up_axis": bpy.props.EnumProperty(
            name="Up Axis", items=[(axis, axis, "") for axis in "XYZ"], default="Z",
            description="Axis of the scene that is up; y is in the file"),
        "radius": bpy.props.FloatProperty(
            name="Radius", default=4e-5, min=0, precision=6, description="Of the fibers [m]"),
        "set_range": bpy.props.BoolProperty(
            name="Set Frame Range", default=True,
            description="Take range and rate of the frames from the file"),
    }
    filename_ext = ".pelagecache"

    def execute(self, context):
        try:
            obj = import_cache(context, self.filepath, self.up_axis, self.radius, self.set_range)
        except ExportError as error:
            self.report({"ERROR"}, "Not imported: %s" % error)
            return {"CANCELLED"}
        self.report({"INFO"}, "%s: %d curves, %d points"
                    % (obj.name, len(obj.data.curves), len(obj.data.points)))
        return {"FINISHED"}


def _menu_entry(self, _context):
    self.layout.operator(ImportPelageCache.bl_idname, text="pelage cache (.pelagecache)")


def register():
    bpy.utils.register_class(ImportPelageCache)
    bpy.types.TOPBAR_MT_file_import.append(_menu_entry)
    bpy.app.handlers.frame_change_pre.append(_on_frame)


def unregister():
    bpy.app.handlers.frame_change_pre.remove(_on_frame)
    bpy.types.TOPBAR_MT_file_import.remove(_menu_entry)
    bpy.utils.unregister_class(ImportPelageCache)
    _caches.clear()
