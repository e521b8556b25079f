"""Time a scene, frame by frame, and the yardstick in between: machines do not keep their speed."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from taut.simulation import Simulation

YARDSTICK_SECONDS = 0.05
"""How long passes of the yardstick are repeated before and after a scene [s]."""
YARDSTICK_EVERY = 30
"""Frames of a scene between other passes of it [1] .."""
YARDSTICK_PASSES = 10
""".. and how many those are."""


class Timeable(Protocol):
    """What can be timed: a `Case` or a `Trial`."""

    @property
    def scene(self) -> str:
        """Which scene."""

    @property
    def cells(self) -> int:
        """Cells along the shorter side [1]."""

    @property
    def strain_limit(self) -> float:
        """Lambda [1]."""

    def simulation(self) -> Simulation:
        """Return the scene at its start."""


@dataclass(frozen=True, slots=True)
class Window:
    """Which part of a scene is timed: its first frames."""

    frames: int = 60
    """Most frames [1]."""
    seconds: float = 5.0
    """No further frame or repeat is begun that would not end within this time, nearly [s]."""
    repeats: int = 1
    """How often the frames are simulated at most [1]; of each the median time counts."""


@dataclass(frozen=True, slots=True)
class Row:
    """What was measured of a case; the columns of the history."""

    scene: str
    """Which scene."""
    cells: int
    """Cells along the shorter side [1]."""
    strain_limit: float
    """Lambda [1]."""
    threads: int
    """Worker threads [1]."""
    vertices: int
    """Particles [1]."""
    frames: int
    """Frames timed, from the start [1]."""
    window: float
    """Time simulated in them [s]."""
    repeats: int
    """How often [1]."""
    steps_per_frame: int
    """Steps a frame [1]."""
    cycles_per_frame: float
    """Cycles or sweeps of the filter, mean of the frames [1]."""
    ms_per_frame: float
    """Mean of the frames [ms]; the load varies, so this is what counts."""
    ms_median: float
    """Median of the frames [ms]."""
    ms_worst: float
    """Slowest frame [ms]."""
    cpu_ms_per_frame: float
    """Mean time on processors, that of all threads together [ms]."""
    ns_per_particle_frame: float
    """Mean time of a frame over the particles [ns]."""
    ns_per_particle_step: float
    """The same over the steps [ns]."""
    worst_stretch: float
    """After any step [1]."""
    cuts: int
    """Steps that the certificate had to shorten, in the window [1]."""
    yardstick_ms: float
    """One plain spring-force pass over the same cloth, one thread, median [ms]."""
    ratio: float
    """ms_per_frame / yardstick_ms [1]."""

    @property
    def disturbed(self) -> bool:
        """Whether something else kept the processor busy: one thread, and much of the time it did not run."""
        return self.threads == 1 and self.ms_per_frame > 1.1 * self.cpu_ms_per_frame + 0.05


@dataclass(frozen=True, slots=True)
class Runs:
    """A case that was timed several times."""

    row: Row
    """All of them summed up."""
    ms: NDArray[np.float64]
    """Mean of the frames of each run [ms], shape (runs,)."""
    cycles: NDArray[np.float64]
    """Cycles or sweeps of the filter for a step, in each frame; the same in all runs. Shape (frames,)."""


COLUMNS = tuple(column.name for column in fields(Row))
"""Names of the columns, in their order."""


def measure(case: Timeable, window: Window) -> Row:
    """Simulate the first frames of a case and time them.

    Args:
        case: what.
        window: how much of it.

    Raises:
        SceneError: the case cannot be simulated.
        SimulationError: a vertex became non-finite.
        ValueError: the window has no frames, repeats or time.
    """
    return measure_in_turn([case], window)[0]


def measure_in_turn(cases: Sequence[Timeable], window: Window) -> list[Row]:
    """As `measure`, for cases that are compared: one after the other, and all of them again.

    A machine that changes its speed meanwhile changes it for all of them.

    Args:
        cases: what. All simulate the frames for which the first one has time.
        window: how much of it; its time is that of all cases together.

    Raises:
        SceneError: a case cannot be simulated.
        SimulationError: a vertex became non-finite.
        ValueError: there is no case, or the window has no frames, repeats or time.
    """
    return [runs.row for runs in runs_in_turn(cases, window)]


def runs_in_turn(cases: Sequence[Timeable], window: Window) -> list[Runs]:
    """As `measure_in_turn`, and what each run found: the runs with the same number are pairs.

    Args:
        cases: as there.
        window: as there.

    Raises:
        SceneError: a case cannot be simulated.
        SimulationError: a vertex became non-finite.
        ValueError: there is no case, or the window has no frames, repeats or time.
    """
    if not cases:
        raise ValueError("no case to measure: give at least one")
    if window.frames < 1 or window.repeats < 1 or not window.seconds > 0:
        raise ValueError(f"{window}: frames and repeats must be 1 or more, seconds more than 0")
    runs = [_Run(case) for case in cases]
    runs[0].simulate(window.frames, window.seconds)
    frames = len(runs[0].timings[0].ms)
    for run in runs[1:]:
        run.simulate(frames)
    seconds = sum(sum(run.timings[0].ms) for run in runs) / 1e3
    for repeat in range(2, window.repeats + 1):
        if seconds * repeat > window.seconds:
            break
        for run in runs:
            run.simulate(frames)
    return [run.summed_up() for run in runs]


class _Run:
    """What was measured of a case so far."""

    def __init__(self, case: Timeable) -> None:
        self.case = case
        self.simulation = case.simulation()
        self.start = self.simulation.snapshot()
        self.passes: list[NDArray[np.float64]] = []
        self.timings: list[_Timing] = []

    def simulate(self, frames: int, seconds: float = np.inf) -> None:
        """From the start."""
        self.simulation.restore(self.start)
        self.passes.append(_yardstick(self.simulation))
        self.timings.append(_Timing.of(self.simulation, self.passes, frames, seconds))

    def summed_up(self) -> Runs:
        """All of it."""
        means = np.array([np.mean(timing.ms) for timing in self.timings])
        cycles = np.array(self.timings[0].cycles) / self.simulation.substeps
        return Runs(self._row(), means, cycles)

    def _row(self) -> Row:
        self.passes.append(_yardstick(self.simulation))
        yardstick = 1e3 * float(np.median(np.concatenate(self.passes)))
        ms = np.median([timing.ms for timing in self.timings], axis=0)
        mean, frames, particles = float(ms.mean()), len(ms), len(self.simulation.mass)
        return Row(
            scene=self.case.scene,
            cells=self.case.cells,
            strain_limit=self.case.strain_limit,
            threads=self.simulation.threads,
            vertices=particles,
            frames=frames,
            window=frames / self.simulation.scene.fps,
            repeats=len(self.timings),
            steps_per_frame=self.simulation.substeps,
            cycles_per_frame=sum(self.timings[0].cycles) / frames,
            ms_per_frame=mean,
            ms_median=float(np.median(ms)),
            ms_worst=float(ms.max()),
            cpu_ms_per_frame=float(np.median([timing.cpu for timing in self.timings])) / frames,
            ns_per_particle_frame=1e6 * mean / particles,
            ns_per_particle_step=1e6 * mean / particles / self.simulation.substeps,
            worst_stretch=self.timings[0].worst_stretch,
            cuts=self.timings[0].cuts,
            yardstick_ms=yardstick,
            ratio=mean / yardstick,
        )


@dataclass(slots=True)
class _Timing:
    """One pass over the frames."""

    ms: list[float] = field(default_factory=list)
    cycles: list[int] = field(default_factory=list)
    cpu: float = 0.0
    cuts: int = 0
    worst_stretch: float = -1.0

    @classmethod
    def of(
        cls, simulation: Simulation, passes: list[NDArray[np.float64]], frames: int, seconds: float
    ) -> "_Timing":
        timing = cls()
        while len(timing.ms) < frames and sum(timing.ms) < 1e3 * seconds:
            cpu, start = time.process_time(), time.perf_counter()
            report = simulation.step(simulation.substeps)
            timing.ms.append(1e3 * (time.perf_counter() - start))
            timing.cpu += 1e3 * (time.process_time() - cpu)
            timing.cycles.append(report.sweeps)
            timing.cuts += report.cuts
            timing.worst_stretch = max(timing.worst_stretch, report.worst_stretch_in_steps)
            if len(timing.ms) % YARDSTICK_EVERY == 0:
                passes.append(simulation.yardstick(YARDSTICK_PASSES)[0])
        return timing


def _yardstick(simulation: Simulation) -> NDArray[np.float64]:
    first, _ = simulation.yardstick(3)
    seconds, _ = simulation.yardstick(max(10, min(1000, int(YARDSTICK_SECONDS / first.min()))))
    return seconds
