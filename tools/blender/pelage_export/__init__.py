"""Blender add-on: exports hair, bone weights and collision meshes for pelage, and imports what it has
simulated."""

bl_info = {
    "name": "pelage hair",
    "author": "pelage",
    "version": (0, 1, 0),
    "blender": (3, 3, 0),
    "location": "File > Export > pelage hair (.tfx), pelage collision mesh (.tfxmesh); "
                "File > Import > pelage cache (.pelagecache); 3D view > Sidebar > pelage",
    "description": "Exports hair (.tfx), its bone weights (.tfxbone) and collision meshes "
                   "(.tfxmesh); imports simulated hair (.pelagecache)",
    "doc_url": "",
    "category": "Import-Export",
}

from . import operators, playback  # noqa: E402  Blender reads bl_info above without running the rest


def register():
    operators.register()
    playback.register()


def unregister():
    playback.unregister()
    operators.unregister()
