"""One method on a scene, into a cache; and the search for the settings with which it keeps the limit."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from taut.compare.methods import Dial
from taut.errors import SceneError, SimulationError
from taut.run import Progress, record
from taut.scene import Scene
from taut.simulation import Simulation

Watch = Callable[[str, int, int, str], object]
"""Told what is being made, how many frames of it are done, how many there are, and a note. May raise
:class:`KeyboardInterrupt` to stop."""

MOST_TURNS = 4096
"""No dial is turned further than so many times its usual setting [1]."""

_REFINED = 2
"""After the first success, so many trials halve the ratio between it and the last failure."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """What is the same for all methods."""

    frames: int | None = None
    """Frames in a run, the initial state included [1]; those of the scene when left out."""
    threads: int | None = None
    """Worker threads [1]; all cores when left out."""
    watch: Watch = lambda what, done, total, note: None
    """Told of the progress."""


def simulate(scene: Scene, out: Path, conditions: Conditions) -> str | None:
    """Simulate a scene into a new cache.

    Returns:
        Why the run ended before its time; nothing if it did not.

    Raises:
        SceneError: the scene cannot be simulated.
    """
    simulation = Simulation(scene, conditions.threads)

    def tell(now: Progress) -> None:
        note = f"worst stretch {100 * now.worst_stretch:.4g} %"
        conditions.watch(scene.title, now.frame + 1, now.frames, note)

    try:
        record(simulation, out, conditions.frames, on_frame=tell)
    except SimulationError as error:
        return str(error)
    return None


@dataclass(frozen=True, slots=True)
class Trial:
    """One setting that was tried."""

    factor: float
    """How far the dial was turned [1]."""
    worst_stretch: float
    """In the frames that were simulated [1]."""
    ended: float | None
    """When the trial was given up [s]; nothing if it went to its end."""


@dataclass(frozen=True, slots=True)
class Search:
    """How a method was brought to the target."""

    dial: Dial
    """What was turned."""
    trials: tuple[Trial, ...]
    """What was tried, in order; none where the usual settings were enough."""
    factor: float | None
    """The least setting found that keeps the target [1]; nothing where none was."""
    settings: tuple[str, ...] = ()
    """The settings of the scene that it stands for."""
    why_not: str = ""
    """Why the search ended without one."""


class _OutOfTime(Exception):
    """The budget is spent."""


@dataclass(slots=True)
class Searcher:
    """Turns the dial of one method until its worst stretch is at most the target."""

    scene: Scene
    """The method with its usual settings."""
    steps: int
    """Steps a frame with those [1]."""
    dial: Dial
    target: float
    """The worst stretch to be kept [1]."""
    limit: float
    """The strain limit [1]."""
    budget: float
    """No trial goes on after this wall-clock time [s]."""
    conditions: Conditions

    def search(self) -> Search:
        """Double the dial until the target is kept, then narrow down."""
        deadline = time.monotonic() + self.budget
        trials: list[Trial] = []
        low = high = 1.0
        why_not = ""
        try:
            while not trials or trials[-1].ended is not None:
                low, high = high, 2 * high
                if high > MOST_TURNS:
                    why_not = "no further setting is tried"
                    break
                trials.append(self._try(high, deadline))
            for _ in range(0 if why_not else _REFINED):
                middle = (low * high) ** 0.5
                trials.append(self._try(middle, deadline))
                low, high = (low, middle) if trials[-1].ended is None else (middle, high)
        except _OutOfTime:
            why_not = f"the {self.budget:g} s for the search were over"
        except SceneError as error:
            why_not = str(error)
        best = min((trial.factor for trial in trials if trial.ended is None), default=None)
        settings = tuple(self._settings(best)) if best else ()
        return Search(self.dial, tuple(trials), best, settings, "" if best else why_not)

    def _settings(self, factor: float) -> list[str]:
        """Of the dial, and the title that says so."""
        title = f"{self.scene.title}, {factor:.3g} x {self.dial.name}"
        return [*self.dial.settings(self.scene, self.steps, factor, self.limit), f'title="{title}"']

    def _try(self, factor: float, deadline: float) -> Trial:
        """Simulate with a setting, up to the first frame beyond the target."""
        simulation = Simulation(self.scene.with_settings(self._settings(factor)), self.conditions.threads)
        frames = self.conditions.frames or self.scene.frames
        worst = 0.0
        for frame in range(1, frames):
            try:
                worst = max(worst, simulation.step(simulation.substeps).worst_stretch)
            except SimulationError:
                return Trial(factor, worst, simulation.time)
            note = f"worst stretch {100 * worst:.4g} %"
            self.conditions.watch(simulation.scene.title, frame + 1, frames, note)
            if worst > self.target:
                return Trial(factor, worst, simulation.time)
            if time.monotonic() > deadline:
                raise _OutOfTime
        return Trial(factor, worst, None)
