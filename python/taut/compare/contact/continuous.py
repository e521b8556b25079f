"""Continuous collision detection: when four corners that move in straight lines come into one plane.

A point meets a triangle, and an edge meets an edge, only where their four corners lie in one plane. With
places that are linear in time the triple product that says so is a cubic in time [Provot97, Bridson02]:

    ((x1 - x0) x (x2 - x0)) . (x3 - x0) = 0,    x_i(t) = x_i + t (y_i - x_i),    0 <= t <= 1.

At each of its roots the closest points tell whether the features touch there.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.compare.contact.distance import Mask, Numbers, between, closest, cross, dot

TOUCH = 1e-9
"""Features touch if they are nearer than this part of their longest side [1]: rounding, no thickness."""

_HALVINGS = 60
_FLAT = 1e-13  # a cubic is zero at an extremum below this part of its largest coefficient


@dataclass(frozen=True, slots=True)
class Hits:
    """Pairs that meet on their way."""

    rows: NDArray[np.int64]
    """Which pairs, shape (hits,)."""
    time: Numbers
    """When they meet first, as a part of the way [1], shape (hits,)."""
    weights: Numbers
    """Signed weights of the places that meet, shape (hits, 4)."""
    normal: Numbers
    """Normal of the triangle, or across both edges, when they meet; shape (hits, 3), either sign."""


def first_hits(start: Numbers, end: Numbers, edges: Mask) -> Hits:
    """Which pairs meet, and where they do so first.

    Args:
        start: corners of the pairs [m], shape (n, 4, 3): a point and a triangle, or two segments.
        end: where they are at the end of their way.
        edges: whether each is two segments, shape (n,).
    """
    rows = np.flatnonzero(_boxes_meet(start, end, edges))
    coefficients = bernstein(start[rows], end[rows])
    turned = (coefficients.min(axis=1) <= 0) & (coefficients.max(axis=1) >= 0)
    rows, coefficients = rows[turned], coefficients[turned]
    times = roots(coefficients)
    found_time = np.full(len(rows), np.inf)
    found_weights = np.zeros((len(rows), 4))
    for time in np.sort(times, axis=1).T:
        open_ = np.flatnonzero(np.isfinite(time) & np.isinf(found_time))
        if not open_.size:
            continue
        chosen = rows[open_]
        places = start[chosen] + time[open_, None, None] * (end[chosen] - start[chosen])
        weights = closest(places, edges[chosen])
        apart = between(weights, places)
        reach = np.linalg.norm(np.ptp(places, axis=1), axis=1)
        meets = dot(apart, apart) <= (TOUCH * reach) ** 2
        found_time[open_[meets]] = time[open_[meets]]
        found_weights[open_[meets]] = weights[meets]
    meets = np.isfinite(found_time)
    rows, time, weights = rows[meets], found_time[meets], found_weights[meets]
    places = start[rows] + time[:, None, None] * (end[rows] - start[rows])
    return Hits(rows, time, weights, _normals(places, edges[rows]))


def bernstein(start: Numbers, end: Numbers) -> Numbers:
    """Coefficients of the cubic on [0, 1], shape (n, 4): where all have one sign, it has no root [1]."""
    at = [places[:, 1:] - places[:, :1] for places in (start, end)]

    def triple(i: int, j: int, k: int) -> Numbers:
        return dot(cross(at[i][:, 0], at[j][:, 1]), at[k][:, 2])

    return np.stack(
        [
            triple(0, 0, 0),
            (triple(1, 0, 0) + triple(0, 1, 0) + triple(0, 0, 1)) / 3,
            (triple(1, 1, 0) + triple(1, 0, 1) + triple(0, 1, 1)) / 3,
            triple(1, 1, 1),
        ],
        axis=1,
    )


def roots(coefficients: Numbers) -> Numbers:
    """Roots of cubics on [0, 1] from Bernstein coefficients, shape (n, 7); infinite where there is none.

    Between its extrema a cubic is monotone, so that bisection finds its roots. An extremum at which it is
    zero but for rounding is a root, too.
    """
    b0, b1, b2, b3 = coefficients.T
    # The derivative is 3 (a t^2 + 2 b t + c).
    a, b, c = b3 - 3 * b2 + 3 * b1 - b0, b2 - 2 * b1 + b0, b1 - b0
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    q = -(b + np.where(b < 0, -root, root))
    with np.errstate(divide="ignore", invalid="ignore"):
        extrema = np.stack([q / a, c / q], axis=1)
    extrema = np.sort(np.clip(np.where(np.isfinite(extrema), extrema, 0.0), 0.0, 1.0), axis=1)
    extrema[b * b < a * c] = 0.0
    ends = np.column_stack([np.zeros(len(a)), extrema, np.ones(len(a))])
    values = _value(coefficients, ends)
    low, high = ends[:, :-1].copy(), ends[:, 1:].copy()
    signs = np.sign(values)
    crossed = signs[:, :-1] * signs[:, 1:] < 0
    row, part = np.nonzero(crossed)
    left, right, sign = low[row, part], high[row, part], signs[row, part]
    for _ in range(_HALVINGS):
        middle = 0.5 * (left + right)
        same = np.sign(_value(coefficients[row], middle[:, None])[:, 0]) == sign
        left, right = np.where(same, middle, left), np.where(same, right, middle)
    found = np.full((len(a), 7), np.inf)
    found[row, part] = 0.5 * (left + right)
    scale = np.abs(coefficients).max(axis=1, keepdims=True)
    zero = np.abs(values) <= _FLAT * scale
    found[:, 3:][zero] = ends[zero]
    return found


def _value(coefficients: Numbers, t: Numbers) -> Numbers:
    """Cubics at times, shape (n, times)."""
    b0, b1, b2, b3 = (coefficients[:, k, None] for k in range(4))
    s = 1.0 - t
    return np.asarray(s * s * (s * b0 + 3 * t * b1) + t * t * (3 * s * b2 + t * b3))


def _boxes_meet(start: Numbers, end: Numbers, edges: Mask) -> Mask:
    """Whether the boxes around the ways of the two features overlap."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    reach = TOUCH * (high.max(axis=1) - low.min(axis=1)).max(axis=1)
    # The second corner belongs to the first feature where that is an edge.
    meet = np.ones(len(start), np.bool_)
    for axis in range(3):
        lows, highs = low[:, :, axis], high[:, :, axis]
        first_low = np.where(edges, np.minimum(lows[:, 0], lows[:, 1]), lows[:, 0])
        first_high = np.where(edges, np.maximum(highs[:, 0], highs[:, 1]), highs[:, 0])
        low_pair, high_pair = np.minimum(lows[:, 2], lows[:, 3]), np.maximum(highs[:, 2], highs[:, 3])
        second_low = np.where(edges, low_pair, np.minimum(low_pair, lows[:, 1]))
        second_high = np.where(edges, high_pair, np.maximum(high_pair, highs[:, 1]))
        meet &= (first_low <= second_high + reach) & (second_low <= first_high + reach)
    return meet


def _normals(places: Numbers, edges: Mask) -> Numbers:
    """Of the triangle, or across both edges; unit vectors, shape (n, 3)."""
    first = np.where(edges[:, None], places[:, 1] - places[:, 0], places[:, 2] - places[:, 1])
    second = places[:, 3] - np.where(edges[:, None], places[:, 2], places[:, 1])
    across = cross(first, second)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    # Parallel edges, and triangles without an area, have no normal: such a pair changes nothing.
    flat = length <= 1e-12 * np.linalg.norm(first, axis=1, keepdims=True) * np.linalg.norm(
        second, axis=1, keepdims=True
    )
    return np.asarray(np.where(flat, 0.0, across / np.maximum(length, 1e-300)))
