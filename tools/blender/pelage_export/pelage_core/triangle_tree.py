"""Closest points on many triangles, for many points at once."""

import numpy as np

_LEAF = 8  # triangles of a leaf
_CHUNK = 4096  # points that are looked up together, which bounds the memory


class TriangleTree:
    """A binary tree of boxes over triangles in the order of Morton (1966): node i of a level has
    the nodes 2i and 2i + 1 of the level below. Corners a, b, c: [triangle, 3]; they may be
    degenerate."""

    def __init__(self, a, b, c):
        order = _near_order((a + b + c) / 3)
        order = np.concatenate((order, np.repeat(order[-1:], -len(order) % _LEAF)))
        self._corners = (a, b, c)
        self._triangles = order.reshape(-1, _LEAF)
        low = np.minimum(np.minimum(a, b), c)[self._triangles].min(axis=1)
        high = np.maximum(np.maximum(a, b), c)[self._triangles].max(axis=1)
        self._levels = []
        while True:
            if len(low) > 1 and len(low) % 2:  # an empty box is near nothing
                low = np.concatenate((low, np.full((1, 3), np.inf)))
                high = np.concatenate((high, np.full((1, 3), -np.inf)))
            self._levels.append((low, high))
            if len(low) == 1:
                break
            low, high = np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])

    def closest(self, points):
        """:returns: triangles [point], barycentric [point, 3], distances [point]. Of triangles
        that are equally near, the first one."""
        found = [self._closest_of(points[begin:begin + _CHUNK])
                 for begin in range(0, max(len(points), 1), _CHUNK)]
        return tuple(np.concatenate(part) for part in zip(*found))

    def _closest_of(self, points):
        rows = np.arange(len(points))
        # Down to the leaf that seems nearest: no farther is the closest point.
        node = np.zeros(len(points), dtype=np.int64)
        for level in reversed(self._levels[:-1]):
            left = _box_distances(level, points, 2 * node)[1]
            right = _box_distances(level, points, 2 * node + 1)[1]
            node = 2 * node + (right < left)
        limit = np.full(len(points), np.inf)
        np.minimum.at(limit, *self._leaves(points, rows, node)[:2])
        limit = limit * (1 + 1e-9) + 1e-30  # slack for rounding
        # All nodes that are not beyond that, nor beyond all of another node.
        node = np.zeros(len(points), dtype=np.int64)
        for level in reversed(self._levels[:-1]):
            rows = np.repeat(rows, 2)
            node = np.repeat(2 * node, 2)
            node[1::2] += 1
            near, far = _box_distances(level, points[rows], node)
            np.minimum.at(limit, rows, far * (1 + 1e-9))
            kept = near <= limit[rows]
            rows, node = rows[kept], node[kept]
        rows, squared, triangles, weights = self._leaves(points, rows, node)
        order = np.lexsort((triangles, squared, rows))
        first = order[np.searchsorted(rows[order], np.arange(len(points)))]
        return triangles[first], weights[first], np.sqrt(squared[first])

    def _leaves(self, points, rows, leaves):
        """For pairs of a point (row) and a leaf, all pairs of point and triangle: rows, squared
        distances, triangles, barycentric coordinates."""
        triangles = self._triangles[leaves].reshape(-1)
        rows = np.repeat(rows, _LEAF)
        a, b, c = (corner[triangles] for corner in self._corners)
        weights, squared = closest_on_triangle(points[rows], a, b, c)
        return rows, squared, triangles, weights


def closest_on_triangle(p, a, b, c):
    """Closest points of the triangles abc to p, all [n, 3]: the projection onto the plane, when it
    is inside; else the nearest point of the three edges.

    :returns: barycentric coordinates [n, 3], squared distances [n].
    """
    best = np.full(len(p), np.inf)
    weights = np.zeros((len(p), 3))
    for first, (start, end) in enumerate(((a, b), (b, c), (c, a))):
        edge, offset = end - start, p - start
        length2 = _dot(edge, edge)
        t = np.clip(_dot(offset, edge) / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)
        gap = offset - t[:, None] * edge
        squared = _dot(gap, gap)
        better = squared < best
        best = np.where(better, squared, best)
        on_edge = np.zeros((len(p), 3))
        on_edge[:, first], on_edge[:, (first + 1) % 3] = 1 - t, t
        weights[better] = on_edge[better]
    u, v, offset = b - a, c - a, p - a
    normal = np.cross(u, v)
    area2 = _dot(normal, normal)
    good = area2 > 0
    area2 = np.where(good, area2, 1.0)
    of_b = _dot(np.cross(offset, v), normal) / area2
    of_c = _dot(np.cross(u, offset), normal) / area2
    height2 = _dot(offset, normal) ** 2 / area2
    inside = good & (of_b >= 0) & (of_c >= 0) & (of_b + of_c <= 1)
    inside &= height2 <= best  # on slivers rounding may say otherwise
    on_plane = np.stack((1 - of_b - of_c, of_b, of_c), axis=1)
    return np.where(inside[:, None], on_plane, weights), np.where(inside, height2, best)


def _dot(a, b):
    return np.einsum("ij,ij->i", a, b)


def _box_distances(level, points, nodes):
    """Squared distances of points from the nearest and from the farthest points of boxes."""
    low, high = level[0][nodes], level[1][nodes]
    gap = np.maximum(np.maximum(low - points, points - high), 0.0)
    reach = np.maximum(np.abs(points - low), np.abs(high - points))
    return _dot(gap, gap), _dot(reach, reach)


def _near_order(points):
    """An order in which neighbours are near each other: 10 bits an axis, interleaved."""
    low, size = points.min(axis=0), np.ptp(points, axis=0).max()
    cell = np.clip((points - low) / (size if size > 0 else 1.0) * 1023, 0, 1023).astype(np.int64)
    code = np.zeros(len(points), dtype=np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= (cell[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")
