"""Blender add-on: exports hair, bone weights and collision meshes for pelage."""

bl_info = {
    "name": "pelage hair",
    "author": "pelage",
    "version": (0, 1, 0),
    "blender": (3, 3, 0),
    "location": "File > Export > pelage hair (.tfx); 3D view > Sidebar > pelage",
    "description": "Exports hair (.tfx), its bone weights (.tfxbone) and collision meshes "
                   "(.tfxmesh)",
    "doc_url": "",
    "category": "Import-Export",
}

from . import operators  # noqa: E402  Blender reads bl_info above without running the rest


def register():
    operators.register()


def unregister():
    operators.unregister()
