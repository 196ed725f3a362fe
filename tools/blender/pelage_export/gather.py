"""What the selected objects have in rest pose, as HairCurves and Surfaces."""

import contextlib

import bpy
import numpy as np

from .pelage_core import ExportError
from .pelage_core.hair import HairCurves
from .pelage_core.nurbs import nurbs_points, uniform_knots
from .pelage_core.surface import Surface

_NURBS = 3  # of the attribute curve_type of hair curves
_HAIR_TYPES = {"MESH", "CURVES", "CURVE"}


class Changes:
    """Attributes that are changed for the export and have their values back after it."""

    def __init__(self):
        self._saved = []

    def set(self, owner, name, value):
        old = getattr(owner, name)
        if old != value:
            setattr(owner, name, value)
            self._saved.append((owner, name, old))

    def undo(self):
        while self._saved:
            owner, name, old = self._saved.pop()
            setattr(owner, name, old)


@contextlib.contextmanager
def rest_pose(context, objects, vertices_per_strand):
    """Armatures in rest position, particle hair as fine as the strands will be and all of it
    there; as before when done."""
    changes = Changes()
    try:
        for obj in context.scene.objects:
            if obj.type == "ARMATURE":
                changes.set(obj.data, "pose_position", "REST")
        for obj in objects:
            for modifier, system in _hair_systems(obj):
                settings = system.settings
                changes.set(modifier, "show_viewport", True)
                changes.set(system, "use_hair_dynamics", False)
                changes.set(settings, "display_percentage", 100)
                if settings.display_method == "NONE":
                    changes.set(settings, "display_method", "RENDER")
                # A path of 2^step segments; more of them than vertices, so that bends stay.
                step = max(settings.display_step, settings.render_step,
                           vertices_per_strand.bit_length())
                changes.set(settings, "display_step", min(step, 10))
        context.view_layer.update()
        yield context.evaluated_depsgraph_get()
    finally:
        changes.undo()
        context.view_layer.update()


def mesh_objects(objects):
    """Those that are meshes, by name."""
    return sorted((obj for obj in objects if obj.type == "MESH"), key=lambda obj: obj.name)


def hair_objects(context):
    """The selected objects that may have hair, by name. Error: one is being edited."""
    objects = [obj for obj in context.selected_objects if obj.type in _HAIR_TYPES]
    for obj in objects:
        if obj.mode == "EDIT":
            raise ExportError("%s is in edit mode; leave it first" % obj.name)
    return sorted(objects, key=lambda obj: obj.name)


class Gatherer:
    """Reads objects from a dependency graph; each mesh once."""

    def __init__(self, depsgraph, surface_name="", color_attribute="", use_children=False):
        self._depsgraph = depsgraph
        self._color_attribute = color_attribute
        self._use_children = use_children
        self._surfaces = {}
        self._chosen = None
        if surface_name:
            self._chosen = bpy.data.objects.get(surface_name)
            if self._chosen is None or self._chosen.type != "MESH":
                raise ExportError("the surface '%s' is no mesh object" % surface_name)

    def curves_of(self, obj):
        """A list of HairCurves; empty for an object without hair."""
        if obj.type == "MESH":
            return [self._particles(obj, modifier.name, system.name)
                    for modifier, system in _hair_systems(obj)]
        if obj.type == "CURVES":
            return [self._hair_curves(obj)]
        return [self._splines(obj)]

    def surface(self, obj):
        if obj.name not in self._surfaces:
            self._surfaces[obj.name] = self._read_mesh(obj)
        return self._surfaces[obj.name]

    def _surface_of(self, obj, own):
        """The mesh that the hair of an object grows on, or None."""
        found = self._chosen or own
        if found is None and obj.parent is not None and obj.parent.type == "MESH":
            found = obj.parent
        return None if found is None else self.surface(found)

    def _particles(self, obj, modifier_name, system_name):
        evaluated = obj.evaluated_get(self._depsgraph)
        system = evaluated.particle_systems[system_name]
        settings = system.settings
        parents, children = len(system.particles), len(system.child_particles)
        if not self._use_children:
            children = 0
        steps = 2**settings.display_step + 1
        if settings.kink == "SPIRAL":
            steps += settings.kink_extra_steps
        counts, points = [], []
        for strand in range(parents + children):
            path = np.array([system.co_hair(evaluated, particle_no=strand, step=step)
                             for step in range(steps)])
            # Beyond the end of a path, which may be cut short, Blender gives exact zeros.
            used = np.nonzero(path.any(axis=1))[0]
            if len(used):
                counts.append(used[-1] + 1)
                points.append(path[:used[-1] + 1])
        if not counts:
            raise ExportError("%s: the particle system '%s' has no hair" % (obj.name, system_name))
        radii = _particle_radii(settings, counts)
        return HairCurves("%s/%s" % (obj.name, system_name), counts, np.concatenate(points), radii,
                          surface=self._surface_of(obj, obj))

    def _hair_curves(self, obj):
        evaluated = obj.evaluated_get(self._depsgraph)
        data = evaluated.data
        counts = np.zeros(len(data.curves), dtype=np.int32)
        data.curves.foreach_get("points_length", counts)
        points = _read(data.attributes["position"].data, "vector", 3)
        radius, colors = data.attributes.get("radius"), self._curve_colors(data, counts)
        columns = [_transform(points, evaluated.matrix_world)]
        if radius is not None:
            columns.append(_read(radius.data, "value", 1))
        if colors is not None:
            columns.append(colors)
        counts, table = _nurbs_as_points(data, counts, np.concatenate(columns, axis=1))
        return HairCurves(obj.name, counts, table[:, :3],
                          None if radius is None else table[:, 3],
                          None if colors is None else table[:, -4:],
                          self._surface_of(obj, obj.data.surface))

    def _curve_colors(self, data, counts):
        attribute = data.attributes.get(self._color_attribute) if self._color_attribute else None
        if attribute is None:
            return None
        if attribute.data_type in {"FLOAT_COLOR", "BYTE_COLOR"}:
            values = _read(attribute.data, "color", 4)
        elif attribute.data_type == "FLOAT_VECTOR":
            values = _read(attribute.data, "vector", 3)
            values = np.concatenate((values, np.ones((len(values), 1))), axis=1)
        else:
            raise ExportError("the attribute '%s' is no colour" % self._color_attribute)
        return np.repeat(values, counts, axis=0) if attribute.domain == "CURVE" else values

    def _splines(self, obj):
        evaluated = obj.evaluated_get(self._depsgraph)
        data = evaluated.to_curve(self._depsgraph, apply_modifiers=True)
        try:
            counts, points, radii = [], [], []
            for spline in data.splines:
                part = _bezier(spline) if spline.type == "BEZIER" else _poly_or_nurbs(spline)
                counts.append(len(part))
                points.append(part[:, :3])
                radii.append(part[:, 3])
            if not counts:
                raise ExportError("%s has no curves" % obj.name)
            depth = data.bevel_depth
        finally:
            evaluated.to_curve_clear()
        return HairCurves(obj.name, counts,
                          _transform(np.concatenate(points), evaluated.matrix_world),
                          np.concatenate(radii) * depth if depth > 0 else None,
                          surface=self._surface_of(obj, None))

    def _read_mesh(self, obj):
        if obj.mode == "EDIT":
            raise ExportError("%s is in edit mode; leave it first" % obj.name)
        evaluated = obj.evaluated_get(self._depsgraph)
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=self._depsgraph)
        try:
            mesh.calc_loop_triangles()
            loops = _read(mesh.loop_triangles, "loops", 3, np.int32)
            triangles = _read(mesh.loop_triangles, "vertices", 3, np.int32)
            materials = _read(mesh.loop_triangles, "material_index", 1, np.int32)[:, 0]
            uv = None
            if mesh.uv_layers.active is not None:
                uv = _read(mesh.uv_layers.active.data, "uv", 2)[loops]
            matrix = np.array(evaluated.matrix_world)[:3, :3]
            mirrored = np.linalg.det(matrix) < 0
            normals = _read(mesh.vertices, "normal", 3) @ np.linalg.pinv(matrix)
            colors = self._mesh_colors(mesh, loops, triangles)
            if mirrored:
                triangles = triangles[:, ::-1]
                uv = None if uv is None else uv[:, ::-1]
                colors = None if colors is None else colors[:, ::-1]
            bones, vertex_bones, weights, fallback = _bone_weights(obj, mesh)
            return Surface(
                obj.name, _transform(_read(mesh.vertices, "co", 3), evaluated.matrix_world),
                normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30),
                triangles, bones, vertex_bones, weights, fallback, uv, colors, materials,
                [slot.material.name if slot.material else "material_%d" % index
                 for index, slot in enumerate(obj.material_slots)])
        finally:
            evaluated.to_mesh_clear()

    def _mesh_colors(self, mesh, loops, triangles):
        attribute = None
        if self._color_attribute:
            attribute = mesh.color_attributes.get(self._color_attribute)
        if attribute is None:
            return None
        values = _read(attribute.data, "color", 4)
        return values[loops if attribute.domain == "CORNER" else triangles]


def _hair_systems(obj):
    """Pairs of modifier and particle system of the hair of an object."""
    return [(modifier, modifier.particle_system) for modifier in obj.modifiers
            if modifier.type == "PARTICLE_SYSTEM" and modifier.particle_system is not None
            and modifier.particle_system.settings.type == "HAIR"]


def _particle_radii(settings, counts):
    """Root and tip are diameters in Blender; in between it interpolates linearly."""
    root = settings.root_radius * settings.radius_scale / 2
    tip = settings.tip_radius * settings.radius_scale / 2
    return np.concatenate([np.linspace(root, tip, count) for count in counts])


def _bezier(spline):
    """[vertex, 4] points and radii of a Bezier spline at its resolution; a closed one is opened."""
    points = spline.bezier_points
    t = np.linspace(0.0, 1.0, max(spline.resolution_u, 1) + 1)[:, None]
    parts = [np.array([[*points[0].co, points[0].radius]])]
    for a, b in zip(points[:-1], points[1:]):
        co = ((1 - t)**3 * np.array(a.co) + 3 * t * (1 - t)**2 * np.array(a.handle_right)
              + 3 * t**2 * (1 - t) * np.array(b.handle_left) + t**3 * np.array(b.co))
        radius = a.radius + (b.radius - a.radius) * t
        parts.append(np.concatenate((co, radius), axis=1)[1:])
    return np.concatenate(parts)


def _poly_or_nurbs(spline):
    """[vertex, 4] points and radii, as _bezier()."""
    points = np.array([tuple(p.co)[:3] + (p.radius,) for p in spline.points])
    order = min(spline.order_u, len(points))
    if spline.type != "NURBS" or order < 2:
        return points
    knots = uniform_knots(len(points), order, spline.use_endpoint_u, spline.use_bezier_u)
    return nurbs_points(points, [p.co[3] for p in spline.points], order, knots)


def _nurbs_as_points(data, counts, table):
    """Counts and a table [vertex, n] of hair curves, with points in place of NURBS curves."""
    kinds = data.attributes.get("curve_type")
    if kinds is None or not (_read(kinds.data, "value", 1, np.int8) == _NURBS).any():
        return counts, table

    def read(name, default, size):
        found = data.attributes.get(name)
        return np.full(size, default) if found is None else _read(
            found.data, "value", 1, np.float32 if name == "nurbs_weight" else np.int8)[:, 0]

    kinds, orders, modes = (read("curve_type", 0, len(counts)), read("nurbs_order", 4, len(counts)),
                            read("knots_mode", 0, len(counts)))
    weights = read("nurbs_weight", 1.0, len(table))
    parts, first = [], 0
    for kind, order, mode, count in zip(kinds, orders, modes, counts):
        part = table[first:first + count]
        order = min(order, count)
        if kind == _NURBS and order > 1:
            # Modes: 1 and 3 begin and end at points, 2 and 3 are Bezier's.
            knots = uniform_knots(count, order, mode in (1, 3), mode in (2, 3))
            part = nurbs_points(part, weights[first:first + count], order, knots)
        parts.append(part)
        first += count
    return np.array([len(part) for part in parts]), np.concatenate(parts)


def _bone_weights(obj, mesh):
    """Bones, [vertex, n] bones and weights, and the bone of what has none.

    Bones are those that deform, of all armatures that move the object, in their order; an object
    on a bone follows that bone; one without any armature is a bone of its own.
    """
    vertex_count = len(mesh.vertices)
    rigid = np.zeros((vertex_count, 1), dtype=np.int64), np.ones((vertex_count, 1))
    armatures = [modifier.object for modifier in obj.modifiers
                 if modifier.type == "ARMATURE" and modifier.object is not None]
    parent = obj.parent
    if not armatures and parent is not None and parent.type == "ARMATURE":
        if obj.parent_type == "BONE":
            return [obj.parent_bone], *rigid, 0
        armatures = [parent]
    bones = list(dict.fromkeys(bone.name for armature in armatures
                               for bone in armature.data.bones if bone.use_deform))
    if not bones:
        return [obj.name], *rigid, 0
    index_of = {name: index for index, name in enumerate(bones)}
    of_group = [index_of.get(group.name, -1) for group in obj.vertex_groups]
    rows = [[(of_group[g.group], g.weight) for g in vertex.groups
             if g.group < len(of_group) and of_group[g.group] >= 0] for vertex in mesh.vertices]
    width = max(1, max(len(row) for row in rows) if rows else 1)
    vertex_bones = np.zeros((vertex_count, width), dtype=np.int64)
    weights = np.zeros((vertex_count, width))
    for vertex, row in enumerate(rows):
        for place, (bone, weight) in enumerate(row):
            vertex_bones[vertex, place], weights[vertex, place] = bone, weight
    roots = {bone.name for armature in armatures for bone in armature.data.bones
             if bone.parent is None}
    fallback = next((index for index, name in enumerate(bones) if name in roots), 0)
    return bones, vertex_bones, weights, fallback


def _read(collection, name, width, dtype=np.float32):
    values = np.zeros(len(collection) * width, dtype=dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width)


def _transform(points, matrix):
    matrix = np.array(matrix)
    return points @ matrix[:3, :3].T + matrix[:3, 3]
