"""Springs between what is nearer than its thickness: penalty forces [MooreWilhelms88, BaraffWitkin98].

A pair at the distance d < h is pushed apart by the force k (h - d) - c u_N, if that is above 0. Friction is
at most mu times that, and no more than stops what slides. All forces act at once, explicitly, at the start
of the step. Nothing looks at the way, so that what is fast, or pressed by more than k h, goes through.

Each k is as large as an explicit step bears. The stiffness matrix is the sum of k_p s_p s_p^T with signed
weights s_p, whose magnitudes add up to 2. So the row of vertex i is at most 2 n_i max k with n_i =
sum_p |s_pi| [Gershgorin31]. Steps are stable while dt^2 w_i times that is below 4.
"""

import numpy as np

from taut.compare.contact.distance import between, closest, dot
from taut.compare.contact.impulses import relative
from taut.compare.contact.step import Outcome, Step

STIFFNESS = 0.5
"""Part of the stiffness that an explicit step bears [1]; the springs of the cloth need the rest."""

DAMPING = 0.1
"""Part of a relative velocity that a pair takes away in a step, if it is the only one of its vertices [1]."""


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
    rows = np.bincount(chosen.corners.ravel(), np.abs(weights).ravel(), minlength=len(start)) * world.light
    most = rows[chosen.corners].max(axis=1)
    k, c = 2.0 * STIFFNESS / (dt**2 * most), DAMPING / (dt * most)
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
