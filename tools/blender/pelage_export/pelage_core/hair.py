"""Curves of hair, and the strands that are made of them."""

import numpy as np

from . import ExportError
from .random_pcg import Random

# Shorter curves have no direction [m]; kMinSegmentLength of pelage/hair_asset.h.
MIN_LENGTH = 1e-12
# Fiber radius for a strand thickness of 1 [m]; kUnitFiberRadius of pelage/authoring/hair_curves.h.
UNIT_FIBER_RADIUS = 4e-5


class HairCurves:
    """Curves as the modelling program has them, root first, in the units and axes of its scene.

    counts [curve] >= 2; points [vertex, 3], the vertices of curve 0, then of curve 1, and so on;
    radii [vertex] and colors [vertex, 4] or None; surface: the Surface that the roots are on, or
    None; name: for messages.
    """

    def __init__(self, name, counts, points, radii=None, colors=None, surface=None):
        self.name = name
        self.counts = np.asarray(counts, dtype=np.int64).reshape(-1)
        self.points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        self.radii = None if radii is None else np.asarray(radii, dtype=np.float64).reshape(-1)
        self.colors = (None if colors is None else
                       np.asarray(colors, dtype=np.float64).reshape(-1, 4))
        self.surface = surface
        vertex_count = int(self.counts.sum())
        if self.points.shape[0] != vertex_count:
            raise ExportError("%s: %d points for %d vertices"
                              % (name, self.points.shape[0], vertex_count))
        for what, values in (("radii", self.radii), ("colours", self.colors)):
            if values is not None and values.shape[0] != vertex_count:
                raise ExportError("%s: %d %s for %d vertices"
                                  % (name, values.shape[0], what, vertex_count))
        for what, values in (("a position", self.points), ("a radius", self.radii),
                             ("a colour", self.colors)):
            if values is not None and not np.isfinite(values).all():
                bad = int(np.argmin(np.isfinite(values.reshape(vertex_count, -1)).all(axis=1)))
                curve = int(np.searchsorted(np.cumsum(self.counts), bad, side="right"))
                raise ExportError("%s: %s of curve %d is not a finite number" % (name, what, curve))

    @property
    def curve_count(self):
        return self.counts.shape[0]


class Strands:
    """Strands of equally many vertices: positions [strand, vertex, 3], colors [strand, vertex, 4]
    or None. Of the curves they were made of: lengths [strand], mean radii [strand] or None."""

    def __init__(self, positions, colors, lengths, radii):
        self.positions, self.colors, self.lengths, self.radii = positions, colors, lengths, radii

    @property
    def roots(self):
        return self.positions[:, 0]


def up_matrix(up_axis, invert_z):
    """The 3x3 matrix from the scene's axes to those of the files (y up): a rotation, and then the
    mirroring of z."""
    matrix = {
        "X": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
        "Y": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "Z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    }[up_axis]
    matrix = np.array(matrix, dtype=np.float64)
    if invert_z:
        matrix[2] = -matrix[2]
    return matrix


def resample(curves, vertices_per_strand, min_length):
    """Strands with vertices at equal distances along the curves, both ends included.

    Curves shorter than `min_length`, without length, or with less than two vertices are left out.
    """
    counts = curves.counts
    firsts = np.concatenate(([0], np.cumsum(counts)[:-1])).astype(np.int64)
    positions, colors, lengths, radii = [], [], [], []
    limit = max(min_length, MIN_LENGTH)
    steps = np.linspace(0.0, 1.0, vertices_per_strand)
    for curve in range(curves.curve_count):
        if counts[curve] < 2:
            continue
        span = slice(firsts[curve], firsts[curve] + counts[curve])
        points = curves.points[span]
        segments = np.sqrt(((points[1:] - points[:-1]) ** 2).sum(axis=1))
        along = np.concatenate(([0.0], np.cumsum(segments)))
        if not along[-1] >= limit:
            continue
        at = steps * along[-1]
        positions.append(_along(at, along, points))
        if curves.radii is not None:
            values = np.maximum(curves.radii[span], 0.0)
            radii.append(((values[1:] + values[:-1]) / 2 * segments).sum() / along[-1])
        if curves.colors is not None:
            colors.append(_along(at, along, curves.colors[span]))
        lengths.append(along[-1])
    shape = (len(lengths), vertices_per_strand)
    return Strands(np.array(positions).reshape(shape + (3,)),
                   None if curves.colors is None else np.array(colors).reshape(shape + (4,)),
                   np.array(lengths), None if curves.radii is None else np.array(radii))


def _along(at, along, values):
    return np.stack([np.interp(at, along, values[:, k]) for k in range(values.shape[1])], axis=1)


def inverse_masses(strand_count, vertices_per_strand, both_ends_immovable):
    """[strand, vertex] 0 for vertices that follow the bones, 1 for those that are simulated."""
    masses = np.ones((strand_count, vertices_per_strand))
    masses[:, :2] = 0
    if both_ends_immovable:
        masses[:, -2:] = 0
    return masses


def thickness_factors(radii, lengths):
    """[strand] a strand's mean radius [m] relative to UNIT_FIBER_RADIUS.

    :returns: the factors, None when all are 0; and the mean radius of all hair, each strand counted
        by its length.
    """
    mean = float((radii * lengths).sum() / lengths.sum())
    return (radii / UNIT_FIBER_RADIUS if mean > 0 else None), mean


def random_order(strand_count, seed):
    return np.array(Random(seed).permutation(strand_count), dtype=np.int64)
