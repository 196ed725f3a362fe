"""Skinned meshes: closest points, and what the mesh has there."""

import numpy as np

from . import ExportError
from .triangle_tree import TriangleTree

MAX_INFLUENCES = 4


class Surface:
    """A skinned triangle mesh in rest pose, in the units and axes of its scene.

    positions, normals [vertex, 3]; triangles [triangle, 3], counter-clockwise seen from outside;
    uv [triangle, corner, 2] and colors [triangle, corner, 4] or None; materials [triangle], an
    index into material_names, or None; bones: names; vertex_bones and vertex_weights [vertex, n]
    say how much of which bone moves a vertex, with weight 0 where there is none; fallback_bone:
    the one that moves what has no weights.
    """

    def __init__(self, name, positions, normals, triangles, bones, vertex_bones, vertex_weights,
                 fallback_bone=0, uv=None, colors=None, materials=None, material_names=()):
        self.name = name
        self.positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
        self.normals = np.asarray(normals, dtype=np.float64).reshape(-1, 3)
        self.triangles = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
        self.bones = list(bones)
        count = self.positions.shape[0]
        self.vertex_bones = np.asarray(vertex_bones, dtype=np.int64).reshape(count, -1)
        self.vertex_weights = np.asarray(vertex_weights, dtype=np.float64).reshape(count, -1)
        self.fallback_bone = fallback_bone
        self.uv = None if uv is None else np.asarray(uv, dtype=np.float64).reshape(-1, 3, 2)
        self.colors = (None if colors is None else
                       np.asarray(colors, dtype=np.float64).reshape(-1, 3, 4))
        self.materials = None if materials is None else np.asarray(materials, dtype=np.int64)
        self.material_names = list(material_names)
        self._tree = None  # made by the first look-up
        if not self.bones:
            raise ExportError("%s: a mesh needs at least one bone" % name)
        if self.triangles.size == 0:
            raise ExportError("%s has no faces" % name)
        if not np.isfinite(self.positions).all():
            raise ExportError("%s: the position of a vertex is not finite" % name)

    def closest(self, points):
        """The nearest point of the mesh to each point.

        :returns: triangles [point], barycentric [point, 3], distances [point].
        """
        if self._tree is None:
            self._tree = TriangleTree(*(self.positions[self.triangles[:, k]] for k in range(3)))
        return self._tree.closest(np.asarray(points, dtype=np.float64).reshape(-1, 3))

    def uv_at(self, triangles, barycentric):
        return (self.uv[triangles] * barycentric[:, :, None]).sum(axis=1)

    def colors_at(self, triangles, barycentric):
        return (self.colors[triangles] * barycentric[:, :, None]).sum(axis=1)

    def influences_at(self, triangles, barycentric):
        """As strongest(): the weights of the three corners, blended."""
        corners = self.triangles[triangles]
        shape = (len(corners), 3 * self.vertex_bones.shape[1])
        bones = self.vertex_bones[corners].reshape(shape)
        weights = (self.vertex_weights[corners] * barycentric[:, :, None]).reshape(shape)
        return strongest(bones, weights, len(self.bones), self.fallback_bone)

    def influences(self):
        """As strongest(), for each vertex."""
        return strongest(self.vertex_bones, self.vertex_weights, len(self.bones),
                         self.fallback_bone)


def polygon_corners(polygon_counts, polygon_vertices, polygons, triangles):
    """Which corners of the polygons the corners of their triangles are.

    :param polygon_counts: corners of each polygon. :param polygon_vertices: the vertex at each
    corner, polygon after polygon. :param polygons: the polygon of each triangle.
    :param triangles: [triangle, 3] vertices. :returns: [triangle, 3] indices into polygon_vertices.
    """
    firsts = np.concatenate(([0], np.cumsum(polygon_counts)))
    corner_of = [{polygon_vertices[corner]: corner for corner in range(begin, end)}
                 for begin, end in zip(firsts[:-1], firsts[1:])]
    return np.array([[corner_of[polygon][vertex] for vertex in triangle]
                     for polygon, triangle in zip(polygons, triangles)], dtype=np.int64)


def strongest(bones, weights, bone_count, fallback):
    """The four largest weights of each row, the largest first, with the sum 1.

    A bone may be in a row several times; its weights add up. Equal weights: the lower index first.
    A row without a weight follows `fallback`.
    :returns: bones [row, 4], weights [row, 4], and how many rows had no weight.
    """
    rows = bones.shape[0]
    out_bones = np.full((rows, MAX_INFLUENCES), fallback, dtype=np.int64)
    out_weights = np.zeros((rows, MAX_INFLUENCES))
    weights = np.where(np.isfinite(weights) & (weights > 0), weights, 0.0)
    row = np.repeat(np.arange(rows), bones.shape[1])
    keys, inverse = np.unique(row * bone_count + bones.reshape(-1), return_inverse=True)
    sums = np.bincount(inverse.reshape(-1), weights=weights.reshape(-1), minlength=len(keys))
    key_rows, key_bones = keys // bone_count, keys % bone_count
    order = np.lexsort((key_bones, -sums, key_rows))
    key_rows, key_bones, sums = key_rows[order], key_bones[order], sums[order]
    starts = np.searchsorted(key_rows, np.arange(rows))
    rank = np.arange(len(key_rows)) - starts[key_rows]
    kept = (rank < MAX_INFLUENCES) & (sums > 0)
    out_bones[key_rows[kept], rank[kept]] = key_bones[kept]
    out_weights[key_rows[kept], rank[kept]] = sums[kept]
    total = out_weights.sum(axis=1)
    empty = total < 1e-6
    out_bones[empty] = fallback
    out_weights[empty] = (1, 0, 0, 0)
    out_weights[~empty] /= total[~empty, None]
    # Places without a weight repeat the heaviest bone, so that an engine needs no other.
    out_bones = np.where(out_weights > 0, out_bones, out_bones[:, :1])
    return out_bones, out_weights, int(empty.sum())
