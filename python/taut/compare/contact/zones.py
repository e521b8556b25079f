"""Zones of impact: what still collides moves on as one rigid body [Provot97, Bridson02].

All vertices of pairs that collide, and of zones that they belong to, make one zone. With its mass M, its
middle c and the velocities v_i of its vertices it gets

    v = sum(m_i v_i) / M,    L = sum(m_i (x_i - c) x (v_i - v)),    I = sum(m_i (|r_i|^2 - r_i r_i^T)),
    omega = I^-1 L,          v_i = v + omega x r_i,                 r_i = x_i - c,

so that momentum and angular momentum are kept. Places go by the rotation itself [Bridson02], or by dt times
the velocity. Both are invertible linear maps of the zone, also on all of the way, so that nothing crosses
within it. Zones grow until nothing collides.

What cannot be moved, corners of bodies or held ones, leads its zone: the rigid motion is that of these
corners alone, with equal weights, as in [Harmon08]. So cloth in a zone with a body sticks to it.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from taut.compare.contact.boxes import Indices
from taut.compare.contact.continuous import first_hits
from taut.compare.contact.distance import Numbers, cross, dot
from taut.compare.contact.world import Nearby, World, components

MOST_ROUNDS = 60
"""Zones are given up if they still grow after so many rounds [1]."""

Advance = Literal["rotate", "linear"]
"""How the places of a zone go on: by the rotation, or by the velocity times the step."""


@dataclass(frozen=True, slots=True)
class Zoned:
    """What became of a step."""

    end: Numbers
    """Where all vertices go [m], shape (n, 3)."""
    rigid: int
    """Vertices of cloth that belong to a zone [1]."""
    rounds: int
    """How often zones were made or grew [1]."""
    clear: bool
    """Whether nothing collides any more."""


def resolve(
    world: World, nearby: Nearby, start: Numbers, end: Numbers, dt: float, advance: Advance = "rotate"
) -> Zoned:
    """Make zones of what collides until nothing does.

    Args:
        world: what touches.
        nearby: finds the pairs that may collide on the way.
        start: where all vertices are [m], shape (n, 3).
        end: where they would go.
        dt: the length of the step [s].
        advance: how the places of a zone go on.
    """
    velocities = (end - start) / dt
    labels = np.arange(len(start))
    out = end.copy()
    changed = np.ones(len(start), np.bool_)
    for rounds in range(MOST_ROUNDS):
        pairs = nearby.pairs(out).with_any(changed)
        corners = pairs.corners
        hits = first_hits(start[corners], out[corners], pairs.edges)
        if not len(hits.rows):
            return Zoned(out, _members(world, labels), rounds, True)
        met = corners[hits.rows]
        joined = _joined(labels, met)
        if (joined == labels).all():  # a zone that is led by what does not move as one
            break
        labels = joined
        grown = np.isin(labels, labels[met])
        changed = grown & (world.light > 0)
        moved = rigid_motion(world.light, labels, start, velocities, dt, advance)
        out[changed] = moved[changed]
    return Zoned(out, _members(world, labels), rounds, False)


def rigid_motion(
    light: Numbers, labels: Indices, start: Numbers, velocities: Numbers, dt: float, advance: Advance
) -> Numbers:
    """Where vertices go if each zone moves as one rigid body [m], shape (n, 3).

    Args:
        light: inverse masses [1/kg]; zones with any that are 0 follow these alone; shape (n,).
        labels: the zone of each vertex, the least vertex in it; shape (n,).
        start: where all vertices are [m], shape (n, 3).
        velocities: with which they would go on [m/s], shape (n, 3).
        dt: the length of the step [s].
        advance: how places go on.
    """
    _, zone = np.unique(labels, return_inverse=True)
    heavy = light == 0
    led = np.bincount(zone, heavy)[zone] > 0
    mass = np.where(led, heavy, 1.0 / np.where(heavy, 1.0, light))
    total = np.bincount(zone, mass)

    def summed(values: Numbers) -> Numbers:
        return np.stack([np.bincount(zone, mass * column) for column in values.T], axis=1)

    middle = summed(start) / total[:, None]
    mean = summed(velocities) / total[:, None]
    r = start - middle[zone]
    momentum = summed(cross(r, velocities - mean[zone]))
    tensors = summed((r[:, :, None] * r[:, None, :]).reshape(-1, 9)).reshape(-1, 3, 3)
    inertia = np.trace(tensors, axis1=1, axis2=2)[:, None, None] * np.eye(3) - tensors
    sizes, axes = np.linalg.eigh(inertia)
    # A single point, or points on a line, do not turn about what they leave open.
    turns = sizes > 1e-9 * sizes[:, -1:]
    part = np.einsum("zij,zi->zj", axes, momentum) * turns / np.where(turns, sizes, 1.0)
    omega = np.einsum("zij,zj->zi", axes, part)[zone]
    place = middle[zone] + dt * mean[zone]
    if advance == "linear":
        return place + r + dt * cross(omega, r)
    speed = np.linalg.norm(omega, axis=1, keepdims=True)
    axis = omega / np.maximum(speed, 1e-300)
    fixed = dot(r, axis)[:, None] * axis
    turned = fixed + np.cos(dt * speed) * (r - fixed) + np.sin(dt * speed) * cross(axis, r)
    return np.asarray(place + turned)


def _joined(labels: Indices, met: Indices) -> Indices:
    """Labels after the corners of each pair that meets have become one zone."""
    links = np.concatenate([met[:, [0, corner]] for corner in (1, 2, 3)])
    return components(len(labels), labels[links])[labels]


def _members(world: World, labels: Indices) -> int:
    """Vertices of cloth that are in a zone with others."""
    return int(np.count_nonzero(np.bincount(labels, minlength=len(labels))[labels[: world.cloth]] > 1))
