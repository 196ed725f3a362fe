"""Stands in for Maya: the parts of maya.cmds, maya.mel and the Python API 2.0 that the exporter
calls, with their arguments and results as Maya's documentation has them, over a small scene.
Arguments that Maya does not have are TypeErrors.

install() puts it in place of the modules; SCENE is the scene, UI what is shown.
"""

import sys
import types

import numpy as np


class Node:
    def __init__(self, path, kind, **data):
        self.path, self.kind = path, kind
        self.__dict__.update({"intermediate": False, "cluster": None, "shaders": ([], []), **data})


class Scene:
    """nodes by path; selection, and sets: paths. A mesh with a cluster is moved by `pose` unless
    the cluster's envelope is 0."""

    def __init__(self):
        self.nodes, self.selection, self.sets = {}, [], {}
        self.attributes, self.locked, self.file_info = {}, set(), {}
        self.clusters = {}  # name -> (joints, weights [vertex][joint])
        self.pose = np.zeros(3)

    def add(self, path, kind, **data):
        self.nodes[path] = Node(path, kind, **data)

    def find(self, name):
        """Paths of a full path or a short name."""
        if name in self.nodes:
            return [name]
        return [path for path in self.nodes if path.split("|")[-1] == name]

    def short(self, path):
        """The shortest name that is unique."""
        parts = path.split("|")[1:]
        for count in range(1, len(parts) + 1):
            name = "|".join(parts[-count:])
            if sum(other.endswith("|" + name) for other in self.nodes) == 1:
                return name
        return path


class Ui:
    """controls by name: their kind, flags and, in `value`, what a user has set."""

    def __init__(self):
        self.controls, self.messages = {}, []
        self.file_name, self.open_menu, self.batch = None, None, False

    def add(self, kind, name=None, **flags):
        name = name or "%s%d" % (kind, len(self.controls) + 1)
        self.controls[name] = types.SimpleNamespace(kind=kind, flags=flags, items=[])
        return name

    def labelled(self, kind, label):
        """The newest control of a kind with a label."""
        return [c for c in self.controls.values()
                if c.kind == kind and c.flags.get("label") == label][-1]


SCENE, UI = Scene(), Ui()


def reset():
    SCENE.__init__()
    UI.__init__()


def _ls(*names, selection=False, long=False, type=None, noIntermediate=False):  # noqa: A002
    flat = [n for name in names for n in (name if isinstance(name, (list, tuple)) else [name])]
    if selection:
        flat = SCENE.selection
    found = [path for name in flat for path in SCENE.find(name)]
    found += [name for name in flat if name in SCENE.clusters]
    if not names and not selection:
        found = list(SCENE.nodes)
    kinds = {name: "skinCluster" for name in SCENE.clusters}
    found = [path for path in found if path in kinds or not (
        noIntermediate and SCENE.nodes[path].intermediate)]
    if type is not None:
        found = [p for p in found if kinds.get(p) == type
                 or (p in SCENE.nodes and SCENE.nodes[p].kind == type)]
    return [path if long or path in kinds else SCENE.short(path) for path in found]


def _list_relatives(nodes, allDescendents=False, parent=False, type=None,  # noqa: A002
                    fullPath=False, noIntermediate=False):
    found = []
    for name in [nodes] if isinstance(nodes, str) else nodes:
        for path in SCENE.find(name):
            if parent:
                found.append(path.rsplit("|", 1)[0])
            elif allDescendents:
                found += [p for p in SCENE.nodes if p.startswith(path + "|")]
    if type is not None:
        found = [p for p in found if SCENE.nodes[p].kind == type]
    if noIntermediate:
        found = [p for p in found if not SCENE.nodes[p].intermediate]
    return [p if fullPath else SCENE.short(p) for p in found] or None


def _get_attr(name, settable=False):
    return name not in SCENE.locked if settable else SCENE.attributes[name]


def _set_attr(name, value):
    if name in SCENE.locked:
        raise RuntimeError("setAttr: The attribute '%s' is locked." % name)
    SCENE.attributes[name] = value


def _list_history(name, pruneDagObjects=False):
    node = SCENE.nodes[name]
    return [node.cluster] if node.cluster else None


def _node_type(name):
    return "objectSet" if name in SCENE.sets else SCENE.nodes[SCENE.find(name)[0]].kind


def _file_info(key, value=None, query=False):
    if query:
        return [SCENE.file_info[key]] if key in SCENE.file_info else []
    SCENE.file_info[key] = value
    return None


def _up_axis(query, axis):
    return "y"


def _menu(name, exists=False, label="", parent="", tearOff=False):
    if exists:
        return name in UI.controls
    if parent != "MayaWindow":
        raise RuntimeError("menu: Object's name '%s' is not found." % parent)
    return UI.add("menu", name, label=label)


def _menu_item(label, parent="", command=None):
    menu = UI.controls[parent or UI.open_menu]
    menu.items.append((label, command))


def _delete_ui(name, menu=False):
    del UI.controls[name]


def _window(title, widthHeight):
    return UI.add("window", title=title)


def _field(kind, value_flag):
    """A control that has its value in a flag, as checkBoxGrp has in value1."""
    def make(name=None, query=False, edit=False, label="", annotation="", buttonLabel="",
             buttonCommand=None, precision=3, **value):
        if set(value) - {value_flag}:
            raise TypeError("%s: Invalid flag '%s'" % (kind, sorted(value)))
        if query:
            return UI.controls[name].value
        if edit:
            UI.controls[name].value = value[value_flag]
            return name
        name = UI.add(kind, label=label, annotation=annotation, buttonCommand=buttonCommand)
        UI.controls[name].value = value.get(value_flag, "" if value_flag == "text" else None)
        if kind == "optionMenuGrp":
            UI.open_menu = name
        return name
    return make


def _button(label, command):
    return UI.add("button", label=label, command=command)


def _file_dialog(fileMode, fileFilter):
    UI.file_filter = fileFilter
    return [UI.file_name] if UI.file_name else None


def _eval(text):
    if "$gMainWindow" not in text:
        raise RuntimeError("unknown MEL: " + text)
    return "MayaWindow"


class _Point:
    def __init__(self, values):
        self.x, self.y, self.z = (float(v) for v in values)


class MDagPath:
    def __init__(self, path):
        self.node = SCENE.nodes[path]

    def instanceNumber(self):
        return 0

    def partialPathName(self):
        return SCENE.short(self.node.path)


class MSelectionList:
    def add(self, name):
        self.name = name
        return self

    def getDagPath(self, index):
        return MDagPath(SCENE.find(self.name)[index])

    def getDependNode(self, index):
        return self.name


class MFnMesh:
    def __init__(self, path):
        self.node = path.node

    def getPoints(self, space):
        offset = SCENE.pose * SCENE.attributes.get("%s.envelope" % self.node.cluster, 0)
        return [_Point(p + offset) for p in np.asarray(self.node.points, dtype=float)]

    def getVertexNormals(self, angleWeighted, space):
        return [_Point(n) for n in self.node.normals]

    def getTriangles(self):
        """Polygons as fans."""
        counts, vertices = [], []
        for polygon in self.node.polygons:
            counts.append(len(polygon) - 2)
            for k in range(1, len(polygon) - 1):
                vertices += [polygon[0], polygon[k], polygon[k + 1]]
        return counts, vertices

    def getVertices(self):
        return [len(p) for p in self.node.polygons], [v for p in self.node.polygons for v in p]

    def getAssignedUVs(self):
        return [len(p) for p in self.node.uv], [i for p in self.node.uv for i in p]

    def getUVs(self):
        return [u for u, _ in self.node.uvs], [v for _, v in self.node.uvs]

    def getConnectedShaders(self, instance):
        return self.node.shaders


class MFnNurbsCurve:
    """Of degree 1, or one span of Bezier's cubic."""

    def __init__(self, path):
        self.node = path.node
        self.degree, self.knotDomain, self.numSpans = self.node.degree, (0.0, 2.0), 1

    def cvPositions(self, space):
        return [_Point(p) for p in self.node.points]

    def getPointAtParam(self, parameter, space):
        if not 0 <= parameter <= 2:
            raise RuntimeError("(kInvalidParameter): Object is incompatible with this method")
        t = parameter / 2
        weights = ((1 - t)**3, 3 * t * (1 - t)**2, 3 * t * t * (1 - t), t**3)
        return _Point(np.array(weights) @ np.asarray(self.node.points, dtype=float))


class MFnDependencyNode:
    def __init__(self, name):
        self._name = name

    def name(self):
        return self._name


class MFnSingleIndexedComponent:
    def create(self, kind):
        return self

    def setCompleteData(self, count):
        self.count = count


class MFnSkinCluster:
    def __init__(self, name):
        self.joints, self.weights = SCENE.clusters[name]

    def influenceObjects(self):
        return [MDagPath(joint) for joint in self.joints]

    def getWeights(self, path, components):
        return [w for row in self.weights[:components.count] for w in row], len(self.joints)


class MFnPlugin:
    def __init__(self, plugin, vendor, version, apiVersion):
        self._path = plugin

    def loadPath(self):
        return self._path


class MGlobal:
    @staticmethod
    def displayError(text):
        UI.messages.append(("error", text))

    @staticmethod
    def displayWarning(text):
        UI.messages.append(("warning", text))

    @staticmethod
    def displayInfo(text):
        UI.messages.append(("info", text))


def install():
    cmds = types.ModuleType("maya.cmds")
    cmds.__dict__.update(
        ls=_ls, listRelatives=_list_relatives, getAttr=_get_attr, setAttr=_set_attr,
        listHistory=_list_history, nodeType=_node_type, fileInfo=_file_info, upAxis=_up_axis,
        objExists=lambda name: name in SCENE.sets or bool(SCENE.find(name)),
        sets=lambda name, query: SCENE.sets[name], about=lambda batch: UI.batch,
        menu=_menu, menuItem=_menu_item, deleteUI=_delete_ui, window=_window,
        columnLayout=lambda adjustableColumn, rowSpacing: None, showWindow=lambda: None,
        button=_button, fileDialog2=_file_dialog,
        checkBoxGrp=_field("checkBoxGrp", "value1"), intFieldGrp=_field("intFieldGrp", "value1"),
        floatFieldGrp=_field("floatFieldGrp", "value1"),
        textFieldGrp=_field("textFieldGrp", "text"),
        optionMenuGrp=_field("optionMenuGrp", "value"),
        textFieldButtonGrp=_field("textFieldButtonGrp", "text"))
    mel = types.ModuleType("maya.mel")
    mel.eval = _eval
    om = types.ModuleType("maya.api.OpenMaya")
    om.__dict__.update(
        {cls.__name__: cls for cls in (MSelectionList, MFnMesh, MFnNurbsCurve, MFnDependencyNode,
                                       MFnSingleIndexedComponent, MFnPlugin, MGlobal)},
        MSpace=types.SimpleNamespace(kWorld=4), MFn=types.SimpleNamespace(kMeshVertComponent=550))
    oma = types.ModuleType("maya.api.OpenMayaAnim")
    oma.MFnSkinCluster = MFnSkinCluster
    maya, api = types.ModuleType("maya"), types.ModuleType("maya.api")
    maya.cmds, maya.mel, maya.api, api.OpenMaya, api.OpenMayaAnim = cmds, mel, api, om, oma
    for module in (maya, cmds, mel, api, om, oma):
        sys.modules[module.__name__] = module
