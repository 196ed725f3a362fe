"""Maya: exports hair curves, the bone weights of their roots and collision meshes for pelage.

Load pelage_plugin.py in Maya's plug-in manager for the menu "pelage", or from Python:

    import pelage_export
    pelage_export.show_hair()                              # a window with all options
    pelage_export.export("/assets/hero.tfx", vertices_per_strand=24, surface="head_geo")
    pelage_export.export_collision("/assets/hero.tfxmesh") # the selected meshes, without hair

Not run in Maya yet. The part that reads Maya's scene, in this file, follows the documentation of
maya.cmds and of the Python API 2.0 and is tested against a stand-in of them. Everything after it
(options, resampling, binding, writing: pelage_core) is what the Blender add-on runs.

Needs Maya 2022 or newer with numpy (mayapy -m pip install numpy), and the folder pelage_core of
tools/blender/pelage_export next to this file or where it is in the repository.
"""

import os
import sys

import maya.api.OpenMaya as om
import maya.api.OpenMayaAnim as oma
import numpy as np
from maya import cmds

_HERE = os.path.dirname(os.path.abspath(__file__))
for _folder in (_HERE, os.path.join(_HERE, "..", "blender", "pelage_export")):
    if os.path.isdir(os.path.join(_folder, "pelage_core")):
        sys.path.insert(0, _folder)
        break

from pelage_core import ExportError  # noqa: E402
from pelage_core import export as core_export  # noqa: E402
from pelage_core.hair import HairCurves  # noqa: E402
from pelage_core.options import COLLISION_OPTIONS, OPTIONS, ExportOptions  # noqa: E402
from pelage_core.surface import Surface, polygon_corners  # noqa: E402

_METRES = 0.01  # of Maya's internal unit, whatever the user interface shows
_SAMPLES_PER_SPAN = 8  # of a curve that is not made of straight lines
_BASE_MESH = "pelageBaseMesh"  # key in the file information of a scene


def export(path, surface="", collision_set="", **options):
    """Exports the curves that are selected or below the selection.

    :param path: of the .tfx file. :param surface: mesh that the roots are bound to; empty: the base
        mesh of the scene, else the mesh that is selected with the curves.
    :param collision_set: set or group whose meshes are the collision mesh, with
        collision="COLLECTION". :param options: see pelage_core.options.
    :returns: pelage_core.export.Report. Raises ExportError.
    """
    options.setdefault("up_axis", cmds.upAxis(query=True, axis=True).upper())
    settings = ExportOptions(**options)
    curves = _shapes_below(cmds.ls(selection=True, long=True) or [], "nurbsCurve")
    if not curves:
        raise ExportError("select curves, or a group with curves in it")
    mesh = _surface_mesh(surface)
    meshes = [] if mesh is None else [mesh]
    if settings.collision == "COLLECTION":
        colliders = _set_meshes(collision_set)
    else:
        colliders = meshes if settings.collision == "SURFACE" else []
    with _BindPose(meshes + colliders):
        read = {name: _read_mesh(name) for name in dict.fromkeys(meshes + colliders)}
        hair = _read_curves(curves, read[mesh] if mesh else None)
    return core_export.export(path, [hair], [read[name] for name in colliders], settings, _METRES)


def export_collision(path, collision_set="", **options):
    """Exports collision meshes without hair.

    :param path: of the .tfxmesh file. :param collision_set: set or group with the meshes; empty:
        those that are selected or below the selection. :param options: COLLISION_OPTIONS of
        pelage_core.options. :returns: pelage_core.export.Report. Raises ExportError.
    """
    options.setdefault("up_axis", cmds.upAxis(query=True, axis=True).upper())
    settings = ExportOptions(**options)
    meshes = _set_meshes(collision_set) if collision_set else _shapes_below(
        cmds.ls(selection=True, long=True) or [], "mesh")
    with _BindPose(meshes):
        surfaces = [_read_mesh(name) for name in meshes]
    return core_export.export_collision(path, surfaces, settings, _METRES)


def base_mesh():
    """The mesh that roots are bound to where none is named; it is saved with the scene. Empty: none
    has been set."""
    found = cmds.fileInfo(_BASE_MESH, query=True)
    return found[0] if found else ""


def set_base_mesh():
    """Makes the selected mesh the base mesh. :returns: its name. Raises ExportError."""
    meshes = _shapes_below(cmds.ls(selection=True, long=True) or [], "mesh")
    if len(meshes) != 1:
        raise ExportError("%d meshes are selected; select the one that hair grows on" % len(meshes))
    name = cmds.ls(cmds.listRelatives(meshes[0], parent=True, fullPath=True))[0]
    cmds.fileInfo(_BASE_MESH, name)
    return name


class _BindPose:
    """Switches the skin clusters of meshes off for a while: then meshes have the shape that they
    were bound in, whatever the pose."""

    def __init__(self, meshes):
        self._clusters = [cluster for cluster in map(_skin_cluster, meshes) if cluster]
        self._saved = []

    def __enter__(self):
        try:
            for cluster in self._clusters:
                attribute = cluster + ".envelope"
                if not cmds.getAttr(attribute, settable=True):
                    raise ExportError("%s is locked or animated; free it, or the mesh cannot be "
                                      "read in its bind pose" % attribute)
                self._saved.append((attribute, cmds.getAttr(attribute)))
                cmds.setAttr(attribute, 0)
        except BaseException:
            self.__exit__()
            raise

    def __exit__(self, *_):
        while self._saved:
            cmds.setAttr(*self._saved.pop())


def _shapes_below(nodes, kind):
    """Shapes of a type among nodes and all that is below them, in Maya's order."""
    shapes = cmds.ls(nodes, type=kind, long=True, noIntermediate=True) or []
    if nodes:
        shapes += cmds.listRelatives(nodes, allDescendents=True, type=kind, fullPath=True,
                                     noIntermediate=True) or []
    return list(dict.fromkeys(shapes))


def _surface_mesh(name):
    name = name or base_mesh()
    if name:
        found = _shapes_below(cmds.ls(name, long=True) or [], "mesh")
        if not found:
            raise ExportError("the surface '%s' is no mesh" % name)
        return found[0]
    found = _shapes_below(cmds.ls(selection=True, long=True) or [], "mesh")
    if len(found) > 1:
        raise ExportError("%d meshes are selected with the curves; name the surface" % len(found))
    return found[0] if found else None


def _set_meshes(name):
    if not name or not cmds.objExists(name):
        raise ExportError("there is no set or group '%s' to make the collision mesh of" % name)
    nodes = [name]
    if cmds.nodeType(name) == "objectSet":
        nodes = cmds.ls(cmds.sets(name, query=True) or [], long=True)
    meshes = _shapes_below(nodes, "mesh")
    if not meshes:
        raise ExportError("'%s' has no meshes" % name)
    return meshes


def _dag_path(name):
    return om.MSelectionList().add(name).getDagPath(0)


def _read_curves(names, surface):
    """Polylines of NURBS curves: the vertices of those of degree 1, points at equal parameters of
    the others. Their shape counts as it is at the current time."""
    counts, points = [], []
    for name in names:
        curve = om.MFnNurbsCurve(_dag_path(name))
        if curve.degree == 1:
            part = [(p.x, p.y, p.z) for p in curve.cvPositions(om.MSpace.kWorld)]
        else:
            first, last = curve.knotDomain
            steps = np.linspace(first, last, curve.numSpans * _SAMPLES_PER_SPAN + 1)
            part = [curve.getPointAtParam(min(float(step), last), om.MSpace.kWorld)
                    for step in steps]
            part = [(p.x, p.y, p.z) for p in part]
        counts.append(len(part))
        points += part
    return HairCurves("curves", counts, points, surface=surface)


def _read_mesh(name):
    path = _dag_path(name)
    mesh = om.MFnMesh(path)
    positions = [(p.x, p.y, p.z) for p in mesh.getPoints(om.MSpace.kWorld)]
    normals = [(n.x, n.y, n.z) for n in mesh.getVertexNormals(False, om.MSpace.kWorld)]
    triangle_counts, triangle_vertices = mesh.getTriangles()
    triangles = np.array(triangle_vertices, dtype=np.int64).reshape(-1, 3)
    polygon_counts, polygon_vertices = mesh.getVertices()
    polygons = np.repeat(np.arange(len(triangle_counts)), triangle_counts)
    uv = None
    uv_counts, uv_ids = mesh.getAssignedUVs()
    if list(uv_counts) == list(polygon_counts):  # every polygon has UV
        us, vs = mesh.getUVs()
        corners = polygon_corners(polygon_counts, polygon_vertices, polygons, triangles)
        uv = np.stack((us, vs), axis=1)[np.array(uv_ids)[corners]]
    shaders, of_polygon = mesh.getConnectedShaders(path.instanceNumber())
    names = [om.MFnDependencyNode(shader).name() for shader in shaders]
    materials = np.array(of_polygon, dtype=np.int64)[polygons] if names else None
    short = name.split("|")[-1]
    bones, vertex_bones, weights = _bone_weights(name, path, len(positions), short)
    return Surface(short, positions, normals, triangles, bones, vertex_bones, weights, 0, uv, None,
                   materials, names)


def _skin_cluster(mesh):
    history = cmds.listHistory(mesh, pruneDagObjects=True) or []
    clusters = cmds.ls(history, type="skinCluster") or []
    if len(clusters) > 1:
        raise ExportError("%s has %d skin clusters; one is all that can be exported"
                          % (mesh, len(clusters)))
    return clusters[0] if clusters else None


def _bone_weights(mesh, path, vertex_count, short):
    """Joint names, and [vertex, joint] indices and weights; a mesh without skin is one bone."""
    cluster = _skin_cluster(mesh)
    if cluster is None:
        return [short], np.zeros((vertex_count, 1), dtype=np.int64), np.ones((vertex_count, 1))
    skin = oma.MFnSkinCluster(om.MSelectionList().add(cluster).getDependNode(0))
    bones = [influence.partialPathName().split("|")[-1] for influence in skin.influenceObjects()]
    if len(set(bones)) != len(bones):
        raise ExportError("%s: two joints have the same name; rename one" % cluster)
    component = om.MFnSingleIndexedComponent()
    vertices = component.create(om.MFn.kMeshVertComponent)
    component.setCompleteData(vertex_count)
    weights, bone_count = skin.getWeights(path, vertices)
    weights = np.array(weights).reshape(vertex_count, bone_count)
    return bones, np.tile(np.arange(bone_count), (vertex_count, 1)), weights


def show_hair():
    """A window with the options and a button that asks for a file."""
    readers = _window("pelage: export hair", OPTIONS)
    surface = cmds.textFieldButtonGrp(
        label="Base Mesh", annotation="The roots are bound to it", text=base_mesh(),
        buttonLabel="Set", buttonCommand=lambda *_: _set_base_mesh(surface))
    readers["surface"] = lambda: cmds.textFieldButtonGrp(surface, query=True, text=True)
    _add_set(readers, "Set or group for the collision mesh COLLECTION")
    _finish(readers, export, "tfx")


def show_collision():
    """The window of export_collision()."""
    readers = _window("pelage: export collision mesh",
                      {name: OPTIONS[name] for name in COLLISION_OPTIONS})
    _add_set(readers, "Set or group with the meshes; empty: the selected ones")
    _finish(readers, export_collision, "tfxmesh")


def choose_base_mesh():
    """set_base_mesh() for the menu: an error is a message."""
    _set_base_mesh(None)


def _set_base_mesh(field):
    try:
        name = set_base_mesh()
    except ExportError as error:
        om.MGlobal.displayError("pelage: %s" % error)
        return
    if field is not None:
        cmds.textFieldButtonGrp(field, edit=True, text=name)
    om.MGlobal.displayInfo("pelage: hair is bound to %s" % name)


def _window(title, options):
    """Begins a window; returns functions that give the values of its controls."""
    cmds.window(title=title, widthHeight=(420, 480))
    cmds.columnLayout(adjustableColumn=True, rowSpacing=4)
    return {name: _control(name, option) for name, option in options.items()}


def _add_set(readers, text):
    field = cmds.textFieldGrp(label="Collision Set", annotation=text)
    readers["collision_set"] = lambda: cmds.textFieldGrp(field, query=True, text=True)


def _finish(readers, write, extension):
    cmds.button(label="Export ...", command=lambda *_: _export_from(readers, write, extension))
    cmds.showWindow()


def _control(name, option):
    """Makes the control of an option; returns a function that gives its value."""
    label, text = option.label, option.text
    if isinstance(option.kind, tuple):
        menu = cmds.optionMenuGrp(label=label, annotation=text)
        for value in option.kind:
            cmds.menuItem(label=value)
        default = option.default
        if name == "up_axis":
            default = cmds.upAxis(query=True, axis=True).upper()
        cmds.optionMenuGrp(menu, edit=True, value=default)
        return lambda: cmds.optionMenuGrp(menu, query=True, value=True)
    if option.kind is bool:
        box = cmds.checkBoxGrp(label=label, annotation=text, value1=option.default)
        return lambda: cmds.checkBoxGrp(box, query=True, value1=True)
    group = cmds.intFieldGrp if option.kind is int else cmds.floatFieldGrp
    extra = {} if option.kind is int else {"precision": 6}
    field = group(label=label, annotation=text, value1=option.default, **extra)
    return lambda: group(field, query=True, value1=True)


def _export_from(readers, write, extension):
    chosen = cmds.fileDialog2(fileMode=0, fileFilter="pelage (*.%s)" % extension)
    if not chosen:
        return
    try:
        report = write(chosen[0], **{name: read() for name, read in readers.items()})
    except ExportError as error:
        om.MGlobal.displayError("pelage: not exported: %s" % error)
        return
    for text in report.warnings:
        om.MGlobal.displayWarning("pelage: " + text)
    om.MGlobal.displayInfo("pelage: " + "; ".join(report.lines))
