"""From results to judgements: how much of the motion is left, what was tried, what won."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from engines import REFERENCE, Engine
from search import Run, Settings, Trial, cheapest
from sheet import SCENES
from store import Case, Record, Store

REFERENCE_SIZE = 32


@dataclass(frozen=True)
class Reference:
    """Peak speed of the centre of mass of the converged cloth in each scene [m/s]."""

    peak_speeds: dict[str, float]

    def judge(self, record: Record) -> Run:
        """What a record means."""
        measured = record.measured
        peak_speed = 0.0 if measured is None else measured.peak_speed
        gained = 0.0 if measured is None else measured.gained
        return Run(
            worst=None if measured is None else measured.worst,
            motion=peak_speed / self.peak_speeds[record.case.scene],
            cost=record.cost,
            gained=gained,
            complete=record.complete,
            out_of_time=not record.complete and record.error is None,
        )


def reference_of(store: Store) -> Reference | None:
    """The reference, if it has been run. It is taut's plainest filter and does not age with the engine."""
    peak_speeds: dict[str, float] = {}
    for scene in SCENES:
        record = store.newest(REFERENCE.name, scene, REFERENCE_SIZE)
        if record is None or record.measured is None or not record.complete:
            return None
        peak_speeds[scene] = record.measured.peak_speed
    return Reference(peak_speeds)


def trials_of(store: Store, engine: Engine, size: int, reference: Reference) -> list[Trial]:
    """Everything that was tried with an engine at a size, with the costs of the search."""
    tried: dict[str, Settings] = {}
    for record in store.of(engine.name, engine.version, size):
        tried.setdefault(str(sorted(record.case.settings.items())), record.case.settings)
    trials = []
    for settings in tried.values():
        cases = [Case(engine.name, engine.version, settings, scene, size) for scene in SCENES]
        records = [store.run_of(case) for case in cases]
        runs = tuple(reference.judge(record) for record in records if record is not None)
        trials.append(Trial(settings, runs, len(runs) == len(SCENES)))
    return trials


def winners_of(trials: Iterable[Trial], limits: Sequence[float]) -> dict[float, Trial]:
    """The cheapest trial for each limit that was kept at all."""
    listed = list(trials)
    found = {limit: cheapest(listed, limit) for limit in limits}
    return {limit: trial for limit, trial in found.items() if trial is not None}


def timed(store: Store, engine: Engine, size: int, trial: Trial) -> float:
    """CPU time of a frame of a trial [ms], mean over the scenes, by the newest timing."""
    cases = [Case(engine.name, engine.version, trial.settings, scene, size) for scene in SCENES]
    costs = [record.cost for case in cases if (record := store.get(case)) is not None]
    return sum(costs) / len(costs)
