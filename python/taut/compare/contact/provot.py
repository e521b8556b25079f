"""Impulses and zones of impact [Provot97].

Pairs that meet on their way collide once, inelastically and with friction: where |V_T| is at most mu |V_N|
the tangential velocity becomes 0, otherwise it loses mu |V_N|. What collides then, or still, becomes rigid
zones, which go on by their velocities, x + dt (v + omega x r). There are no repulsions: cloth has no
thickness.
"""

from taut.compare.contact.bridson import collide
from taut.compare.contact.step import Outcome, Step
from taut.compare.contact.world import Nearby

ROUNDS = 1
"""Of impulses [1]."""


def provot(step: Step) -> Outcome:
    """Make a step admissible."""
    nearby = Nearby(step.world, step.start, step.proposed)
    return collide(step, nearby, step.proposed, ROUNDS, 0.0, "linear")
