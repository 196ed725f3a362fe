"""Points of NURBS curves."""

import numpy as np

_POINTS_PER_SPAN = 8


def uniform_knots(point_count, order, ends_at_points, is_bezier):
    """Knots as Blender makes them of a curve's options (Endpoint, Bezier).

    :param order: degree + 1, at most point_count. :returns: [point_count + order], increasing.
    """
    repeats = order - 1 if is_bezier else 1
    left = order if ends_at_points else min(2, repeats) if is_bezier else 1
    knots, value = [], 0.0
    for _ in range(point_count + (0 if ends_at_points else order)):
        knots.append(value)
        left -= 1
        if left == 0:
            value, left = value + 1, repeats
    return np.array(knots + [value] * (point_count + order - len(knots)))


def nurbs_points(points, weights, order, knots):
    """Points of a curve at equal parameters, eight a span, its ends included.

    :param points: [n, k] control points; the columns after the third, a radius say, are
        interpolated as they are. :param weights: [n] > 0. :param knots: [n + order], increasing.
    :returns: [m, k].
    """
    points, weights = np.asarray(points, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    first, last = knots[order - 1], knots[len(points)]
    spans = len(np.unique(knots[order - 1:len(points) + 1])) - 1
    at = np.linspace(first, last, max(spans, 1) * _POINTS_PER_SPAN + 1)
    basis = _basis(at, order, knots) * weights
    return basis @ points / basis.sum(axis=1, keepdims=True)


def _basis(at, order, knots):
    """[parameter, point] basis functions by the recursion of Cox and de Boor. The last parameter
    belongs to the last span that is not empty."""
    inside = np.clip(np.searchsorted(knots, at, side="right") - 1, order - 1,
                     np.searchsorted(knots, knots[-order], side="left") - 1)
    basis = (np.arange(len(knots) - 1) == inside[:, None]).astype(np.float64)
    for degree in range(1, order):
        rise, fall = knots[degree:-1] - knots[:-degree - 1], knots[degree + 1:] - knots[1:-degree]
        left = (at[:, None] - knots[:-degree - 1]) / np.where(rise > 0, rise, 1)
        right = (knots[degree + 1:] - at[:, None]) / np.where(fall > 0, fall, 1)
        basis = left * (rise > 0) * basis[:, :-1] + right * (fall > 0) * basis[:, 1:]
    return basis
