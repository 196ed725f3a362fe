"""Makes the scene of the export test and of docs/authoring.md: a bust on three bones, posed, with
particle hair, hair curves, a Bezier braid, and a collar with two materials to collide with.

    blender -b --factory-startup --python make_scene.py -- FILE.blend
"""

import math
import sys

import bpy
import numpy as np

# Profile of the bust: (height, radius) [m]; the crown and the base are closed by single vertices.
PROFILE = [(0.00, 0.150), (0.05, 0.158), (0.10, 0.135), (0.13, 0.090), (0.15, 0.060), (0.17, 0.052),
           (0.20, 0.050), (0.22, 0.058), (0.24, 0.072), (0.27, 0.086), (0.30, 0.094), (0.33, 0.095),
           (0.36, 0.090), (0.39, 0.078), (0.41, 0.062), (0.43, 0.040), (0.44, 0.018)]
SIDES = 48
JOINTS = {"spine": (0.0, 0.14), "neck": (0.14, 0.22), "head": (0.22, 0.44)}  # from, to [m]
BUST_AT = (0.2, 0.1, 0.0)  # not at the origin, so that a forgotten transform shows
PARTICLE_COUNT = 300
CURVE_COUNT = 240
BRAID_POINTS = 5


def revolve(profile, sides):
    """Vertices, faces and their UV (around, along) of a closed surface of revolution."""
    heights = [profile[0][0]] + [h for h, _ in profile] + [profile[-1][0] + 0.003]
    vertices = [(0.0, 0.0, heights[0])]
    for height, radius in profile:
        for side in range(sides):
            angle = 2 * math.pi * side / sides
            vertices.append((radius * math.sin(angle), -radius * math.cos(angle), height))
    vertices.append((0.0, 0.0, heights[-1]))
    top, rings = len(vertices) - 1, len(profile)
    faces, uv = [], []
    for side in range(sides):
        other, u = (side + 1) % sides, (side / sides, (side + 1) / sides)
        faces.append((0, 1 + other, 1 + side))
        uv.append(((u[0], 0.0), (u[1], 0.02), (u[0], 0.02)))
        for ring in range(rings - 1):
            a, b = 1 + ring * sides, 1 + (ring + 1) * sides
            v = (0.02 + 0.96 * ring / (rings - 1), 0.02 + 0.96 * (ring + 1) / (rings - 1))
            faces.append((a + side, a + other, b + other, b + side))
            uv.append(((u[0], v[0]), (u[1], v[0]), (u[1], v[1]), (u[0], v[1])))
        last = 1 + (rings - 1) * sides
        faces.append((last + side, last + other, top))
        uv.append(((u[0], 0.98), (u[1], 0.98), (u[0], 1.0)))
    return vertices, faces, uv


def add_mesh(name, vertices, faces, uv=None, location=(0, 0, 0)):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    if uv is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", [c for face in uv for corner in face for c in corner])
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    obj = bpy.data.objects.new(name, mesh)
    obj.location = location
    bpy.context.scene.collection.objects.link(obj)
    return obj


def add_material(obj, name, color):
    material = bpy.data.materials.new(name)
    material.diffuse_color = (*color, 1)
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*color, 1)
    obj.data.materials.append(material)


def bone_shares(height):
    """{bone: weight} at a height [m]: one bone alone in its middle, blended over 3 cm at joints."""
    neck = min(max((height - 0.125) / 0.03, 0.0), 1.0)
    head = min(max((height - 0.205) / 0.03, 0.0), 1.0)
    return {"spine": 1 - neck, "neck": neck - head, "head": head}


def bind(obj, armature, height_offset=0.0):
    groups = {name: obj.vertex_groups.new(name=name) for name in JOINTS}
    for vertex in obj.data.vertices:
        for name, share in bone_shares(vertex.co.z + height_offset).items():
            if share > 0:
                groups[name].add([vertex.index], share, "REPLACE")
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature


def add_armature():
    armature = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    armature.location = BUST_AT
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for name, (begin, end) in JOINTS.items():
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail, bone.parent = (0, 0, begin), (0, 0, end), parent
        parent = bone
    control = armature.data.edit_bones.new("control")
    control.head, control.tail, control.use_deform = (0, 0, 0), (0, 0.1, 0), False
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def pose(armature):
    """An export that forgot the rest pose would put all hair elsewhere."""
    head = armature.pose.bones["head"]
    head.rotation_mode = "XYZ"
    head.rotation_euler = (0.3, 0.5, 0.0)


def add_scalp_group(bust):
    """Where hair grows: down to the neck behind, and above the forehead."""
    scalp = bust.vertex_groups.new(name="scalp")
    for vertex in bust.data.vertices:
        low = 0.19 if vertex.co.y > 0.02 else 0.29 - vertex.co.y * 1.0
        if vertex.co.z > low:
            scalp.add([vertex.index], 1.0, "REPLACE")


def add_particle_hair(bust, name, count, length, seed):
    bust.modifiers.new(name, "PARTICLE_SYSTEM")
    system = bust.particle_systems[-1]
    system.name = name
    system.seed = seed
    system.vertex_group_density = "scalp"
    settings = system.settings
    settings.type, settings.count, settings.hair_step = "HAIR", count, 6
    settings.use_advanced_hair = True
    settings.hair_length = length
    settings.material = 2
    settings.root_radius, settings.tip_radius, settings.radius_scale = 0.012, 0.004, 0.01
    settings.physics_type = "NEWTON"
    settings.brownian_factor = 0.005
    settings.child_type, settings.child_nbr, settings.rendered_child_count = "INTERPOLATED", 2, 2
    return system


def add_hair_curves(bust, count):
    """Long hair: curves made of a second particle system, then combed back and down."""
    bpy.ops.object.select_all(action="DESELECT")
    bust.select_set(True)
    bpy.context.view_layer.objects.active = bust
    system = add_particle_hair(bust, "roots", count, 0.1, 5)
    system.settings.child_type = "NONE"
    system.settings.display_step = 4
    bust.particle_systems.active_index = len(bust.particle_systems) - 1
    bpy.context.view_layer.update()
    bpy.ops.curves.convert_from_particle_system()
    curves = bpy.context.view_layer.objects.active
    curves.name = "long_hair"
    curves.data.materials.append(bpy.data.materials["hair"])
    bust.modifiers.remove(bust.modifiers["roots"])
    comb(curves)
    follow_surface(curves, bust)
    return curves


def follow_surface(curves, bust):
    """As "Add > Curve > Empty Hair" sets it up: the curves move with the deformed mesh."""
    curves.data.surface = bust
    curves.data.surface_uv_map = "UVMap"
    curves.parent = bust
    curves.matrix_parent_inverse = bust.matrix_world.inverted()
    bust.add_rest_position_attribute = True
    bpy.ops.object.select_all(action="DESELECT")
    curves.select_set(True)
    bpy.context.view_layer.objects.active = curves
    bpy.ops.curves.snap_curves_to_surface(attach_mode="NEAREST")
    nodes = bpy.data.node_groups.new("follow surface", "GeometryNodeTree")
    nodes.inputs.new("NodeSocketGeometry", "Geometry")
    nodes.outputs.new("NodeSocketGeometry", "Geometry")
    begin = nodes.nodes.new("NodeGroupInput")
    deform = nodes.nodes.new("GeometryNodeDeformCurvesOnSurface")
    end = nodes.nodes.new("NodeGroupOutput")
    nodes.links.new(begin.outputs[0], deform.inputs[0])
    nodes.links.new(deform.outputs[0], end.inputs[0])
    curves.modifiers.new("Follow", "NODES").node_group = nodes


def comb(curves):
    data = curves.data
    counts = np.zeros(len(data.curves), dtype=np.int32)
    data.curves.foreach_get("points_length", counts)
    points = np.zeros(len(data.points) * 3, dtype=np.float32)
    data.attributes["position"].data.foreach_get("vector", points)
    points = points.reshape(-1, 3)
    radii, colors, first = [], [], 0
    for curve, count in enumerate(counts):
        root = points[first].astype(np.float64)
        step = (0.20 + 0.05 * math.sin(curve * 1.7)) / (count - 1)
        outwards = root - (0, 0, 0.33)
        outwards /= np.linalg.norm(outwards)
        point = root
        for k in range(count):
            points[first + k] = point
            t = k / (count - 1)
            wave = 0.25 * math.sin(14 * t + curve)
            direction = 0.8 * (1 - t)**8 * outwards + (0.15 + t) * np.array(
                (0.15 * outwards[0] + 0.5 * wave, 0.15 * outwards[1] + 0.2 * (1 - t), -1.2))
            point = point + step * direction / np.linalg.norm(direction)
            push = point - (0, 0, 0.33)  # the head is about a ball of 9.5 cm
            distance = np.linalg.norm(push)
            if distance < 0.104:
                point = np.array((0, 0, 0.33)) + push * (0.104 / distance)
        radii += [4e-5 * (1 + 0.3 * math.sin(curve))] * count
        colors += [0.2 + 0.6 * curve / len(counts), 0.1, 0.05, 1.0]
        first += count
    # A new attribute moves the others, so each is looked up when it is set.
    if "radius" not in data.attributes:
        data.attributes.new("radius", "FLOAT", "POINT")
    data.attributes.new("tint", "FLOAT_COLOR", "CURVE").data.foreach_set("color", colors)
    data.attributes["radius"].data.foreach_set("value", radii)
    data.attributes["position"].data.foreach_set("vector", points.reshape(-1))


def add_braid(bust):
    """A Bezier curve from the back of the head to the neck: both ends may be fixed."""
    data = bpy.data.curves.new("braid", "CURVE")
    data.dimensions, data.bevel_depth, data.resolution_u = "3D", 0.002, 8
    spline = data.splines.new("BEZIER")
    spline.bezier_points.add(BRAID_POINTS - 1)
    for k, point in enumerate(spline.bezier_points):
        point.co = (0.0, 0.096 + 0.02 * math.sin(k), 0.33 - 0.035 * k)
        point.handle_left_type = point.handle_right_type = "AUTO"
    braid = bpy.data.objects.new("braid", data)
    bpy.context.scene.collection.objects.link(braid)
    braid.parent = bust
    data.materials.append(bpy.data.materials["hair"])
    return braid


def add_collar(armature):
    """A closed ring around the neck; its upper half has another material."""
    rings, sides, vertices, faces = 32, 12, [], []
    for ring in range(rings):
        around = 2 * math.pi * ring / rings
        for side in range(sides):
            along = 2 * math.pi * side / sides
            radius = 0.085 + 0.02 * math.cos(along)
            vertices.append((radius * math.cos(around), radius * math.sin(around),
                             0.155 + 0.015 * math.sin(along)))
            a, b = ring * sides, (ring + 1) % rings * sides
            other = (side + 1) % sides
            faces.append((a + side, b + side, b + other, a + other))
    collar = add_mesh("collar", vertices, faces, location=BUST_AT)
    add_material(collar, "felt", (0.10, 0.12, 0.30))
    add_material(collar, "trim", (0.60, 0.45, 0.10))
    for index, polygon in enumerate(collar.data.polygons):
        polygon.material_index = 1 if index % sides < sides // 2 else 0
    bind(collar, armature)
    return collar


def collect(name, objects):
    collection = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(collection)
    for obj in objects:
        collection.objects.link(obj)


def make_scene(particle_count=PARTICLE_COUNT, curve_count=CURVE_COUNT):
    """Empties the scene and fills it with bust, long_hair, braid, collar and rig."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    armature = add_armature()
    vertices, faces, uv = revolve(PROFILE, SIDES)
    bust = add_mesh("bust", vertices, faces, uv, BUST_AT)
    add_material(bust, "skin", (0.60, 0.42, 0.32))
    add_material(bust, "hair", (0.10, 0.03, 0.012))
    bind(bust, armature)
    add_scalp_group(bust)
    add_hair_curves(bust, curve_count)
    add_particle_hair(bust, "undercoat", particle_count, 0.03, 1)
    add_braid(bust)
    collect("colliders", [bust, add_collar(armature)])
    pose(armature)
    bpy.context.view_layer.update()


if __name__ == "__main__":
    make_scene()
    if "--" in sys.argv:
        bpy.ops.wm.save_as_mainfile(filepath=sys.argv[sys.argv.index("--") + 1])
