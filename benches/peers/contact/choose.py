"""What a run breaks, and which of several is the cheapest that breaks nothing, or the best compromise."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from contact.results import Outcome
from search import MOTION, ROUNDING

LIMIT = 0.05
"""Stretch to be kept [1]."""


@dataclass(frozen=True)
class Verdict:
    """A run and what it breaks."""

    outcome: Outcome
    motion: float
    """How far the centre of mass fell until its last frame over how far the reference's had then [1]."""
    broken: tuple[str, ...]
    """Names of the rules that it breaks: "failed", "intersections", "stretch", "motion"."""

    @property
    def excess(self) -> float:
        """By how much it is off, the least being the best compromise [1].

        The sum of the stretch over the limit, of the share of the frames that intersect, and of what the
        motion lacks or has too much: a tenth of one counts like a tenth of another.
        """
        touch = self.outcome.touch
        if "failed" in self.broken or touch is None:
            return math.inf
        low, high = MOTION
        off = max(low - self.motion, self.motion - high, 0.0)
        return max(touch.worst - LIMIT, 0.0) + touch.wrong / touch.frames + off


def judge(outcome: Outcome, reference: list[float]) -> Verdict:
    """Say what a run breaks.

    Args:
        outcome: what happened.
        reference: how far the reference's centre of mass had fallen, frame by frame [m].

    Returns:
        The verdict.
    """
    touch = outcome.touch
    if touch is None or touch.frames == 0:
        return Verdict(outcome, 0.0, ("failed",))
    last = min(touch.frames, len(reference)) - 1
    motion = touch.falls[last] / reference[last]
    low, high = MOTION
    rules = {
        "failed": outcome.error is not None,
        "intersections": touch.wrong > 0,
        "stretch": touch.worst > LIMIT + ROUNDING,
        "motion": not low <= motion <= high,
    }
    return Verdict(outcome, motion, tuple(name for name, broken in rules.items() if broken))


def best(verdicts: Iterable[Verdict]) -> Verdict | None:
    """The cheapest that breaks nothing; if there is none, the best compromise.

    What does not move like the reference is no compromise as long as something else does.
    """
    listed = list(verdicts)
    clean = [verdict for verdict in listed if not verdict.broken]
    if clean:
        return min(clean, key=lambda verdict: verdict.outcome.cost)
    return min(listed, key=lambda verdict: ("motion" in verdict.broken, verdict.excess), default=None)
