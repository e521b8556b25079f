"""Closest points of a point and a triangle, and of two segments.

Both are told as signed weights of four corners: the way from the second feature to the first is
``sum(weights[i] * corner[i])``, and its length is their distance.
"""

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
Mask = NDArray[np.bool_]

_TINY = 1e-300


def dot(a: Numbers, b: Numbers) -> Numbers:
    """Products of rows, shape (n,)."""
    return np.asarray(np.einsum("nc,nc->n", a, b))


def cross(a: Numbers, b: Numbers) -> Numbers:
    """Vector products of rows, shape (n, 3)."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[:, 0] = a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]
    out[:, 1] = a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2]
    out[:, 2] = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return out


def point_triangle(places: Numbers) -> Numbers:
    """Signed weights of the closest points of a point and a triangle, shape (n, 4).

    Where the foot of the perpendicular is outside of the triangle, the nearest place of its sides counts.

    Args:
        places: the point, then the corners of the triangle [m], shape (n, 4, 3).
    """
    point, a, b, c = (places[:, corner] for corner in range(4))
    ab, ac, ap = b - a, c - a, point - a
    bb, bc, cc, pb, pc = dot(ab, ab), dot(ab, ac), dot(ac, ac), dot(ap, ab), dot(ap, ac)
    area = bb * cc - bc * bc
    safe = np.where(area > 0, area, 1.0)
    v, w = (cc * pb - bc * pc) / safe, (bb * pc - bc * pb) / safe
    weights = np.stack([np.ones_like(v), v + w - 1.0, -v, -w], axis=1)
    beside = np.flatnonzero((area <= 0) | (v < 0) | (w < 0) | (v + w > 1))
    if not beside.size:
        return weights
    point, corners = point[beside], places[beside, 1:]
    nearest = np.full(len(beside), np.inf)
    for first, second in ((0, 1), (1, 2), (2, 0)):
        start, way = corners[:, first], corners[:, second] - corners[:, first]
        along = np.clip(dot(point - start, way) / np.maximum(dot(way, way), _TINY), 0.0, 1.0)
        apart = point - start - along[:, None] * way
        squared = dot(apart, apart)
        better = squared < nearest
        nearest = np.where(better, squared, nearest)
        rows = beside[better]
        weights[rows, 1:] = 0.0
        weights[rows, 1 + first] = along[better] - 1.0
        weights[rows, 1 + second] = -along[better]
    return weights


def segment_segment(places: Numbers) -> Numbers:
    """Signed weights of the closest points of two segments, shape (n, 4); see [Ericson05], section 5.1.9.

    Args:
        places: ends of the first segment, then those of the second one [m], shape (n, 4, 3).
    """
    p, q, a, b = (places[:, corner] for corner in range(4))
    way, other, apart = q - p, b - a, p - a
    ww, oo, wo = dot(way, way), dot(other, other), dot(way, other)
    wa, oa = dot(way, apart), dot(other, apart)
    determinant = ww * oo - wo * wo
    crossing = determinant > 1e-14 * ww * oo
    s = np.where(crossing, (wo * oa - oo * wa) / np.where(crossing, determinant, 1.0), 0.0)
    s = np.clip(s, 0.0, 1.0)
    t = np.clip((wo * s + oa) / np.maximum(oo, _TINY), 0.0, 1.0)
    s = np.clip((wo * t - wa) / np.maximum(ww, _TINY), 0.0, 1.0)
    return np.stack([1.0 - s, s, t - 1.0, -t], axis=1)


def closest(places: Numbers, edges: Mask) -> Numbers:
    """Signed weights of the closest points of pairs, shape (n, 4).

    Args:
        places: their corners [m], shape (n, 4, 3).
        edges: whether each is two segments, not a point and a triangle, shape (n,).
    """
    weights = np.empty((len(places), 4))
    if edges.any():
        weights[edges] = segment_segment(places[edges])
    if not edges.all():
        weights[~edges] = point_triangle(places[~edges])
    return weights


def between(weights: Numbers, places: Numbers) -> Numbers:
    """The way from the second feature to the first [m], shape (n, 3)."""
    return np.asarray(np.einsum("nk,nkc->nc", weights, places))
