"""Springs between what is nearer than its thickness: penalty forces [MooreWilhelms88, BaraffWitkin98].

A pair at the distance d < h is pushed apart by the force k (h - d) - c u_N, if that is above 0; friction is at
most mu times that, and no more than stops what slides. All forces act at once, explicitly, at the start of the
step. Nothing looks at the way, so that what is fast, or pressed by more than k h, goes through.
"""

import numpy as np

from taut.compare.contact.distance import between, closest, dot
from taut.compare.contact.impulses import relative
from taut.compare.contact.step import Outcome, Step

STIFFNESS = 0.2
"""k of each pair, times dt^2 over the median mass of a vertex [1]. A vertex is in some ten pairs; with ten times
this an explicit step is at half of what it bears."""

DAMPING = 0.1
"""c of each pair over 2 sqrt(k m) [1]."""


def penalty(step: Step) -> Outcome:
    """Push apart what is too near at the start of a step."""
    world, dt, start = step.world, step.dt, step.start
    pairs = world.pairs(0.0, start)
    places = start[pairs.corners]
    weights = closest(places, pairs.edges)
    apart = between(weights, places)
    distance = np.sqrt(dot(apart, apart))
    near = np.flatnonzero((distance < pairs.thickness) & (distance > 0))
    if not near.size:
        return Outcome(step.proposed)
    chosen, weights, distance = pairs.of(near), weights[near], distance[near]
    normals = apart[near] / distance[:, None]
    mass = float(np.median(1.0 / world.light[world.light > 0]))
    k = STIFFNESS * mass / dt**2
    c = 2.0 * DAMPING * np.sqrt(k * mass)
    velocities = (step.proposed - start) / dt
    u = relative(velocities, chosen.corners, weights)
    along = dot(u, normals)
    pushed = dt * np.maximum(k * (chosen.thickness - distance) - c * along, 0.0)
    across = u - along[:, None] * normals
    speed = np.sqrt(dot(across, across))
    inverse = (weights**2 * world.light[chosen.corners]).sum(axis=1)
    held = np.minimum(chosen.friction * pushed, speed / inverse)
    impulse = pushed[:, None] * normals - (held / np.maximum(speed, 1e-300))[:, None] * across
    moved = (weights * world.light[chosen.corners])[:, :, None] * impulse[:, None]
    np.add.at(velocities, chosen.corners, moved)
    return Outcome(np.where(world.light[:, None] > 0, start + dt * velocities, step.proposed))
