"""Impulses between pairs, one after the other, with Coulomb's friction.

With the signed weights s of the places that touch, the relative velocity is u = sum(s_i v_i). An impulse j
on the first feature, and -j on the second one, changes velocities by s_i w_i j, where w_i is an inverse
mass. It changes u by D j with D = sum(s_i^2 w_i). For corners of equal mass that is equation (7) of
[Bridson02] and its like for edges. As the weights add up to zero, momentum is kept. As j acts at one place,
or along the line between the closest places, angular momentum is kept, too.
"""

from collections.abc import Iterator

import numpy as np

from taut.compare.contact.boxes import Indices
from taut.compare.contact.distance import Mask, Numbers, dot
from taut.compare.contact.world import Pairs, World

_SEED = 0x7A17


def batches(corners: Indices, moved: Mask) -> Iterator[Indices]:
    """Rows in batches that share no vertex which moves: as if one row came after the other.

    The order is a fixed shuffle, so that batches are few and none of a mesh's own order is seen.

    Args:
        corners: vertices of each row, shape (n, 4).
        moved: whether each vertex can be moved, shape (vertices,).
    """
    order = np.random.default_rng(_SEED).permutation(len(corners))
    left = np.arange(len(corners))
    first = np.empty(len(moved), np.int64)
    while left.size:
        verts = corners[left]
        turn = order[left]
        first[verts] = len(order)
        np.minimum.at(first, verts.ravel(), np.repeat(turn, 4))
        ready = ((first[verts] == turn[:, None]) | ~moved[verts]).all(axis=1)
        yield left[ready]
        left = left[~ready]


def relative(velocities: Numbers, corners: Indices, weights: Numbers) -> Numbers:
    """Relative velocities of the places that touch [m/s], shape (n, 3)."""
    return np.asarray(np.einsum("nk,nkc->nc", weights, velocities[corners]))


def respond(
    world: World,
    velocities: Numbers,
    pairs: Pairs,
    weights: Numbers,
    normals: Numbers,
    least: Numbers,
    push: Numbers,
) -> None:
    """Stop what approaches, push apart what is too near, and slow down what slides.

    Along the unit normal n, which points to the first feature, a relative velocity below 0 becomes 0. Where
    it is below `least` then, an impulse of at most `push` raises it as far as that. Friction takes at most
    mu times that change from the tangential velocity, equation (8) of [Bridson02].

    Args:
        world: whose inverse masses count.
        velocities: of all vertices [m/s], shape (vertices, 3); changed in place.
        pairs: which touch.
        weights: signed weights of the places that touch, shape (n, 4).
        normals: directions in which the first feature is pushed, shape (n, 3).
        least: relative velocity along the normal that is aimed at [m/s], shape (n,).
        push: largest impulse for that [N s], shape (n,).
    """
    light = world.light
    inverse = (weights**2 * light[pairs.corners]).sum(axis=1)
    able = np.flatnonzero((inverse > 0) & normals.any(axis=1))
    for batch in batches(pairs.corners[able], light > 0):
        rows = able[batch]
        corners, s, n, d = pairs.corners[rows], weights[rows], normals[rows], inverse[rows]
        u = relative(velocities, corners, s)
        along = dot(u, n)
        stopped = np.maximum(along, 0.0)
        after = stopped + np.clip(least[rows] - stopped, 0.0, push[rows] * d)
        change = (after - along)[:, None] * n + friction(
            u - along[:, None] * n, after - along, pairs.friction[rows]
        )
        moved = (s * light[corners])[:, :, None] * (change / d[:, None])[:, None]
        np.add.at(velocities, corners, moved)


def friction(across: Numbers, change: Numbers, coefficient: Numbers) -> Numbers:
    """How friction changes tangential velocities: (max(1 - mu dV / |V|, 0) - 1) V [m/s], shape (n, 3).

    Args:
        across: tangential relative velocities V [m/s], shape (n, 3).
        change: how much the normal ones were changed, dV [m/s], shape (n,).
        coefficient: Coulomb's mu [1], shape (n,).
    """
    speed = np.sqrt(dot(across, across))
    kept = np.maximum(1.0 - coefficient * change / np.maximum(speed, 1e-300), 0.0)
    return (kept - 1.0)[:, None] * across
