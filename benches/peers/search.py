"""The search for an engine's cheapest setting that keeps a limit and still moves.

Pure logic: what a setting does is asked of a function, so that the search can be tested with a fake engine.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

Value = str | int | float
Settings = dict[str, Value]

ROUNDING = 1e-4
"""Stretch over the limit that counts as kept [1]: 32-bit positions of a fine cloth resolve no less."""
MOTION = (0.8, 1.2)
"""Shares of the reference's motion between which a cloth counts [1]: with less it is frozen, with more it
gains energy or slides off. Without contact the motion is the peak speed, with contact the way fallen."""
MOST_GAINED = 0.05
"""Energy that a cloth may gain [1], see :attr:`metric.Measured.gained`."""
REFINEMENTS = 2
"""Times that the gap between a failure and a success is halved; two leave at most 1.25 times the least."""


def words(settings: Settings) -> str:
    """Settings as a list."""
    return ", ".join(
        f"{key} {value:g}" if isinstance(value, float) else f"{key} {value}"
        for key, value in settings.items()
    )


@dataclass(frozen=True)
class Family:
    """Settings that differ in one number, the effort: iterations, substeps, quality."""

    fixed: Settings
    effort: str
    least: int
    most: int
    multiple: int = 1
    """Efforts must be multiples of this; the least one is."""

    def at(self, effort: int) -> Settings:
        """The setting with this effort."""
        return {**self.fixed, self.effort: effort}


@dataclass(frozen=True)
class Run:
    """What a setting did in one scene."""

    worst: float | None
    """Worst stretch [1]; None if it blew up or came to nothing."""
    motion: float
    """Peak speed of the centre of mass over the reference's [1]."""
    cost: float
    """CPU time of a frame [ms]."""
    gained: float = 0.0
    """Energy gained, see :attr:`metric.Measured.gained` [1]."""
    complete: bool = True
    """Whether it reached the last frame."""
    out_of_time: bool = False
    """Whether that was for lack of time; else it blew up or failed."""

    def holds(self, limit: float) -> bool:
        """Whether no edge went over this limit."""
        return self.complete and self.worst is not None and self.worst <= limit + ROUNDING

    def keeps(self, limit: float) -> bool:
        """Whether that is so and it moved as it should: whether it is admissible at this limit."""
        low, high = MOTION
        return self.holds(limit) and low <= self.motion <= high and self.gained <= MOST_GAINED


@dataclass(frozen=True)
class Trial:
    """What a setting did in the scenes in which it was tried."""

    settings: Settings
    runs: tuple[Run, ...]
    all_scenes: bool
    """False if it was given up after the first scenes."""

    @property
    def cost(self) -> float:
        """CPU time of a frame [ms], mean over the scenes."""
        return sum(run.cost for run in self.runs) / len(self.runs)

    @property
    def worst(self) -> float | None:
        """Worst stretch over the scenes [1]; None if it blew up in one."""
        stretches = [run.worst for run in self.runs if run.worst is not None]
        return max(stretches) if len(stretches) == len(self.runs) else None

    @property
    def motions(self) -> tuple[float, float]:
        """Least and most motion over the scenes [1]."""
        motions = [run.motion for run in self.runs]
        return min(motions), max(motions)

    def holds(self, limit: float) -> bool:
        """Whether no edge went over this limit in any scene."""
        return self.all_scenes and all(run.holds(limit) for run in self.runs)

    def keeps(self, limit: float) -> bool:
        """Whether it is admissible at this limit in every scene."""
        return self.all_scenes and all(run.keeps(limit) for run in self.runs)


RunOne = Callable[[Settings, str], Run | None]
"""Runs a setting in a scene; None if no time is left for it."""


def attempt(settings: Settings, scenes: Sequence[str], hopeless: float, run: RunOne) -> Trial | None:
    """Try a setting in one scene after the other.

    Args:
        settings: what to try.
        scenes: where.
        hopeless: stretch [1] over which the other scenes are not tried any more.
        run: runs it.

    Returns:
        What it did, or None if the time ran out before anything was known.
    """
    runs: list[Run] = []
    for scene in scenes:
        result = run(settings, scene)
        if result is None:
            break
        runs.append(result)
        if not result.complete or result.worst is None or result.worst > hopeless:
            break
    return Trial(settings, tuple(runs), len(runs) == len(scenes)) if runs else None


def cheapest(trials: Iterable[Trial], limit: float) -> Trial | None:
    """The cheapest trial that keeps a limit."""
    return min((trial for trial in trials if trial.keeps(limit)), key=lambda trial: trial.cost, default=None)


def search(
    families: Iterable[Family], limits: Sequence[float], attempt: Callable[[Settings], Trial | None]
) -> list[Trial]:
    """Climb every family, doubling the effort; then bisect twice between the last failure and the success.

    A family is left when its setting keeps the tightest limit, does not finish in time, or costs more than
    what already keeps every limit: more effort would only cost more; when two doublings did not lower the
    stretch; and when more effort takes away motion that is missing already. One that blew up is climbed on.

    Args:
        families: the most promising first.
        limits: stretch to be kept [1].
        attempt: tries a setting; None ends the search, for lack of time.

    Returns:
        Everything that was tried.
    """
    trials: list[Trial] = []
    for family in families:
        climbed: dict[int, Trial] = {}
        effort = family.least
        while effort <= family.most:
            if not _try(family, effort, climbed, trials, attempt):
                return trials
            climb = list(climbed.values())
            if _exhausted(climb[-1], trials, limits) or _stalled(climb) or _freezes(climb):
                break
            effort *= 2
        for _ in range(REFINEMENTS):
            for middle in _middles(family, climbed, limits, trials):
                if not _try(family, middle, climbed, trials, attempt):
                    return trials
    return trials


def _try(
    family: Family,
    effort: int,
    climbed: dict[int, Trial],
    trials: list[Trial],
    attempt: Callable[[Settings], Trial | None],
) -> bool:
    trial = attempt(family.at(effort))
    if trial is not None:
        climbed[effort] = trial
        trials.append(trial)
    return trial is not None


def _exhausted(trial: Trial, trials: Sequence[Trial], limits: Sequence[float]) -> bool:
    if trial.keeps(min(limits)) or any(run.out_of_time for run in trial.runs):
        return True
    best = [cheapest(trials, limit) for limit in limits]
    return all(winner is not None and winner.cost < trial.cost for winner in best)


def _stalled(climb: Sequence[Trial]) -> bool:
    """Whether the last two steps of a climb lowered the stretch by less than a tenth."""
    *before, last, now = [math.inf] * 2 + [
        math.inf if trial.worst is None else trial.worst for trial in climb
    ]
    return min(last, now) > 0.9 * min(before, default=math.inf)


def _freezes(climb: Sequence[Trial]) -> bool:
    """Whether the last step of a climb lost motion and has too little of it."""
    return len(climb) > 1 and climb[-1].motions[0] < min(MOTION[0], climb[-2].motions[0])


def _middles(
    family: Family, climbed: Mapping[int, Trial], limits: Sequence[float], trials: Sequence[Trial]
) -> list[int]:
    """Efforts between the first success and the failure below it, where their cost could win a limit.

    A success either keeps a limit, or holds its stretch but has lost its motion: there may be a window
    between too soft and frozen, or between too soft and what gains energy.
    """
    middles: set[int] = set()
    for limit in limits:
        best = cheapest(trials, limit)
        for succeeds in (Trial.keeps, Trial.holds):
            success = min(
                (effort for effort, trial in climbed.items() if succeeds(trial, limit)), default=None
            )
            if success is None:
                continue
            failure = max((effort for effort in climbed if effort < success), default=success)
            middle = (failure + success) // 2 // family.multiple * family.multiple
            cost = climbed[success].cost * middle / success
            if failure < middle < success and (best is None or cost < best.cost):
                middles.add(middle)
    return sorted(middles)
