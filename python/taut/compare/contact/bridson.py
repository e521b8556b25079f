"""Repulsions, collision impulses and rigid impact zones [Bridson02].

1. Pairs that are nearer than their thickness h at the start of the step are stopped (an inelastic collision)
and pushed apart by a spring, with the mean velocities of the proposed step. They go apart by no more than a
tenth of the overlap d in a step: I = min(dt k d, m (0.1 d / dt - v_N)), equations (4) to (8). Friction goes
with both.
2. Pairs that meet on their way get impulses of the same kind, up to a number of rounds.
3. What still collides becomes rigid zones, see :mod:`taut.compare.contact.zones`.
"""

import numpy as np

from taut.compare.contact.continuous import first_hits
from taut.compare.contact.distance import Numbers, between, closest, dot
from taut.compare.contact.impulses import relative, respond
from taut.compare.contact.step import Outcome, Step
from taut.compare.contact.world import Nearby, Pairs
from taut.compare.contact.zones import Advance, resolve

SHARE = 0.1
"""Part of the overlap that repulsions take away in a step [1]."""

ROUNDS = 10
"""Rounds of impulses before zones [1]; the paper leaves the number open."""


def bridson(step: Step) -> Outcome:
    """Make a step admissible."""
    nearby = Nearby(step.world, step.start, step.proposed)
    velocities = (step.proposed - step.start) / step.dt
    repel(step, nearby.pairs(step.proposed), velocities)
    moved = step.world.light[:, None] > 0
    end = np.where(moved, step.start + step.dt * velocities, step.proposed)
    return collide(step, nearby, end, ROUNDS, SHARE, "rotate")


def repel(step: Step, pairs: Pairs, velocities: Numbers) -> None:
    """Repulsions between what is too near at the start; changes velocities [m/s], shape (n, 3), in place."""
    places = step.start[pairs.corners]
    weights = closest(places, pairs.edges)
    apart = between(weights, places)
    distance = np.sqrt(dot(apart, apart))
    near = np.flatnonzero((distance < pairs.thickness) & (distance > 0))
    chosen, distance = pairs.of(near), distance[near]
    overlap = chosen.thickness - distance
    respond(
        step.world,
        velocities,
        chosen,
        weights[near],
        apart[near] / distance[:, None],
        SHARE * overlap / step.dt,
        step.dt * step.stiffness * overlap,
    )


def collide(step: Step, nearby: Nearby, end: Numbers, rounds: int, share: float, advance: Advance) -> Outcome:
    """Impulses where pairs meet on their way, then zones.

    Args:
        step: what is made admissible.
        nearby: finds the pairs.
        end: where all vertices would go [m], shape (n, 3).
        rounds: of impulses.
        share: part of the overlap at the start that impulses take away in a step [1].
        advance: how zones go on.
    """
    world, start, dt = step.world, step.start, step.dt
    velocities = (end - start) / dt
    changed = np.ones(len(start), np.bool_)
    for done in range(rounds):
        pairs = nearby.pairs(end).with_any(changed)
        hits = first_hits(start[pairs.corners], end[pairs.corners], pairs.edges)
        if not len(hits.rows):
            return Outcome(end, done + 1)
        met = pairs.of(hits.rows)
        approach = dot(relative(velocities, met.corners, hits.weights), hits.normal)
        normals = np.where(approach > 0, -1.0, 1.0)[:, None] * hits.normal
        places = start[met.corners]
        apart = between(closest(places, met.edges), places)
        overlap = np.maximum(met.thickness - np.sqrt(dot(apart, apart)), 0.0)
        before = velocities.copy()
        push = np.where(overlap > 0, dt * step.stiffness, 0.0) * np.where(overlap > 0, overlap, 1.0)
        respond(world, velocities, met, hits.weights, normals, share * overlap / dt, push)
        changed = (velocities != before).any(axis=1)
        end = np.where(changed[:, None], start + dt * velocities, end)
    zoned = resolve(world, nearby, start, end, dt, advance)
    return Outcome(zoned.end, rounds + zoned.rounds + 1, zoned.rigid, zoned.clear)
