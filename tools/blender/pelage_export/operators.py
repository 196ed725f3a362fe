"""The exports as operators, and the panel with their settings."""

import bpy
from bpy_extras.io_utils import ExportHelper

from . import gather
from .pelage_core import ExportError
from .pelage_core import export as core_export
from .pelage_core.options import COLLISION_OPTIONS, OPTIONS, ExportOptions

_CHOICES = {
    "X": ("X", ""), "Y": ("Y", ""), "Z": ("Z", ""),
    "NONE": ("None", "No .tfxmesh file"),
    "SURFACE": ("Surface", "The meshes that the hair grows on"),
    "COLLECTION": ("Collection", "All meshes of a collection"),
    "WHOLE": ("One File", ""),
    "OBJECT": ("By Object", "NAME_object.tfxmesh"),
    "MATERIAL": ("By Material", "NAME_material.tfxmesh"),
}
_DIGITS = {"min_curve_length": 6}  # that are shown


def _property(name, option):
    common = {"name": option.label, "description": option.text}
    if isinstance(option.kind, tuple):
        default = "Z" if name == "up_axis" else option.default  # Blender's z is up
        return bpy.props.EnumProperty(
            items=[(key, *_CHOICES[key]) for key in option.kind], default=default, **common)
    if option.kind is bool:
        return bpy.props.BoolProperty(default=option.default, **common)
    common.update(default=option.default, min=option.low, max=option.high)
    if option.kind is int:
        return bpy.props.IntProperty(**common)
    return bpy.props.FloatProperty(precision=_DIGITS.get(name, 4), **common)


class _Settings:
    """Properties of the operator and of the scene: the shared options, and what only Blender
    has."""

    __annotations__ = {
        **{name: _property(name, option) for name, option in OPTIONS.items()},
        "use_children": bpy.props.BoolProperty(
            name="Children", default=False,
            description="Export the children of particle hair, too, as strands of their own"),
        "surface": bpy.props.StringProperty(
            name="Surface", default="",
            description="Mesh object that the roots are bound to; empty: the emitter, the surface "
                        "of the hair curves, or the parent"),
        "color_attribute": bpy.props.StringProperty(
            name="Color Attribute", default="",
            description="Colours of the hair: an attribute of the hair curves, else of the "
                        "surface at the roots; empty: none"),
        "collision_collection": bpy.props.StringProperty(
            name="Collection", default="",
            description="Collection whose meshes are the collision mesh; for collision meshes "
                        "alone, empty: the selected objects"),
    }


class PelageExportSettings(_Settings, bpy.types.PropertyGroup):
    """Settings of a scene; saved with it."""

    __annotations__ = dict(_Settings.__annotations__)


def _draw(layout, settings):
    layout.use_property_split = True
    for name in ("export_hair", "export_bones", "vertices_per_strand", "min_curve_length",
                 "both_ends_immovable", "use_children"):
        layout.prop(settings, name)
    column = layout.column(align=True)
    column.prop(settings, "randomize_strands")
    row = column.row()
    row.active = settings.randomize_strands
    row.prop(settings, "seed")
    for name in ("scale", "up_axis", "invert_z", "invert_v"):
        layout.prop(settings, name)
    layout.prop_search(settings, "surface", bpy.data, "objects")
    layout.prop(settings, "color_attribute")
    layout.prop(settings, "collision")
    if settings.collision == "COLLECTION":
        layout.prop_search(settings, "collision_collection", bpy.data, "collections")
    if settings.collision != "NONE":
        layout.prop(settings, "collision_split")


def _collection_meshes(name):
    collection = bpy.data.collections.get(name)
    if collection is None:
        raise ExportError("there is no collection '%s' to make the collision mesh of" % name)
    objects = gather.mesh_objects(collection.all_objects)
    if not objects:
        raise ExportError("the collection '%s' has no meshes" % collection.name)
    return objects


def _unit(context):
    settings = context.scene.unit_settings
    return 1.0 if settings.system == "NONE" else settings.scale_length


def export_hair(context, filepath, settings):
    """Exports the hair of the selected objects. :returns: Report. Raises ExportError."""
    options = ExportOptions(**{name: getattr(settings, name) for name in OPTIONS})
    objects = gather.hair_objects(context)
    with gather.rest_pose(context, objects, options.vertices_per_strand) as depsgraph:
        gatherer = gather.Gatherer(depsgraph, settings.surface, settings.color_attribute,
                                   settings.use_children)
        curves = [part for obj in objects for part in gatherer.curves_of(obj)]
        if options.collision == "SURFACE":
            surfaces = [part.surface for part in curves if part.surface is not None]
        elif options.collision == "COLLECTION":
            surfaces = [gatherer.surface(obj)
                        for obj in _collection_meshes(settings.collision_collection)]
        else:
            surfaces = []
    return core_export.export(filepath, curves, surfaces, options, _unit(context))


def export_collision(context, filepath, settings):
    """Exports the selected meshes, or those of a collection. :returns: Report. Raises
    ExportError."""
    options = ExportOptions(**{name: getattr(settings, name) for name in COLLISION_OPTIONS})
    name = settings.collision_collection
    objects = _collection_meshes(name) if name else gather.mesh_objects(context.selected_objects)
    with gather.rest_pose(context, [], options.vertices_per_strand) as depsgraph:
        surfaces = [gather.Gatherer(depsgraph).surface(obj) for obj in objects]
    return core_export.export_collision(filepath, surfaces, options, _unit(context))


class _Export(ExportHelper):
    """An operator whose properties begin as those of the scene's settings of the same name."""

    def invoke(self, context, event):
        for name in self.shared():
            setattr(self, name, getattr(context.scene.pelage_export, name))
        return super().invoke(context, event)

    def shared(self):
        return [name for name in _Settings.__annotations__ if name in self.__annotations__]

    def execute(self, context):
        try:
            report = self.write(context, bpy.path.abspath(self.filepath))
        except ExportError as error:
            self.report({"ERROR"}, "Not exported: %s" % error)
            return {"CANCELLED"}
        for text in report.warnings:
            self.report({"WARNING"}, text)
        self.report({"INFO"}, "; ".join(report.lines))
        if self.options.is_invoke:
            for name in self.shared():
                setattr(context.scene.pelage_export, name, getattr(self, name))
        return {"FINISHED"}


class ExportPelageHair(_Settings, bpy.types.Operator, _Export):
    """Export hair, bone weights and collision meshes of the selected objects for pelage"""

    bl_idname = "export_scene.pelage_hair"
    bl_label = "Export pelage Hair"
    bl_options = {"PRESET"}

    __annotations__ = {
        **_Settings.__annotations__,
        "filter_glob": bpy.props.StringProperty(default="*.tfx", options={"HIDDEN"}),
    }
    filename_ext = ".tfx"

    @classmethod
    def poll(cls, context):
        return bool(context.selected_objects)

    def write(self, context, path):
        return export_hair(context, path, self)

    def draw(self, context):
        _draw(self.layout, self)


class ExportPelageCollision(bpy.types.Operator, _Export):
    """Export the selected meshes, or those of a collection, as collision meshes for pelage"""

    bl_idname = "export_scene.pelage_collision"
    bl_label = "Export pelage Collision Mesh"
    bl_options = {"PRESET"}

    __annotations__ = {
        **{name: _Settings.__annotations__[name]
           for name in (*COLLISION_OPTIONS, "collision_collection")},
        "filter_glob": bpy.props.StringProperty(default="*.tfxmesh", options={"HIDDEN"}),
    }
    filename_ext = ".tfxmesh"

    def write(self, context, path):
        return export_collision(context, path, self)

    def draw(self, context):
        self.layout.use_property_split = True
        for name in COLLISION_OPTIONS:
            self.layout.prop(self, name)
        self.layout.prop_search(self, "collision_collection", bpy.data, "collections")


class VIEW3D_PT_pelage_export(bpy.types.Panel):
    bl_label = "pelage Hair"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "pelage"

    def draw(self, context):
        _draw(self.layout, context.scene.pelage_export)
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator(ExportPelageHair.bl_idname, text="Export Hair ...", icon="EXPORT")
        self.layout.operator(ExportPelageCollision.bl_idname, text="Export Collision Mesh ...",
                             icon="EXPORT")


def _menu_entry(self, context):
    self.layout.operator(ExportPelageHair.bl_idname, text="pelage hair (.tfx)")
    self.layout.operator(ExportPelageCollision.bl_idname, text="pelage collision mesh (.tfxmesh)")


_CLASSES = (PelageExportSettings, ExportPelageHair, ExportPelageCollision,
            VIEW3D_PT_pelage_export)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.pelage_export = bpy.props.PointerProperty(type=PelageExportSettings)
    bpy.types.TOPBAR_MT_file_export.append(_menu_entry)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(_menu_entry)
    del bpy.types.Scene.pelage_export
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
