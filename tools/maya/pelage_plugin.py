"""Maya plug-in: a menu "pelage" with the exporters of pelage_export.py.

Add this folder to MAYA_PLUG_IN_PATH, and load pelage_plugin.py in Windows > Settings/Preferences >
Plug-in Manager.
"""

import sys

import maya.api.OpenMaya as om
from maya import cmds, mel

_MENU = "pelageMenu"


def maya_useNewAPI():  # noqa: N802  Maya looks for this name
    """Says that the plug-in uses the Python API 2.0."""


def initializePlugin(plugin):  # noqa: N802
    folder = om.MFnPlugin(plugin, "pelage", "0.1.0", "Any").loadPath()
    if folder not in sys.path:  # Maya gives a plug-in no __file__ to find its modules by
        sys.path.append(folder)
    import pelage_export
    if cmds.about(batch=True):
        return
    cmds.menu(_MENU, label="pelage", parent=mel.eval("$window = $gMainWindow"), tearOff=True)
    for label, command in (("Export Hair ...", pelage_export.show_hair),
                           ("Export Collision Mesh ...", pelage_export.show_collision),
                           ("Set Base Mesh", pelage_export.choose_base_mesh)):
        cmds.menuItem(label=label, parent=_MENU, command=lambda *_, run=command: run())


def uninitializePlugin(_plugin):  # noqa: N802
    if cmds.menu(_MENU, exists=True):
        cmds.deleteUI(_MENU, menu=True)
