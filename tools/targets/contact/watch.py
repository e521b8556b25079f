"""Simulating while an oracle looks, and what is said about it in a row."""

import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from taut import Simulation, SimulationError

from tools.targets.contact.judge import Oracle
from tools.targets.contact.travel import Travel
from tools.targets.limit import Tally
from tools.targets.table import Effort, Row

STILL = 1e-6  # [m], a frame in which no vertex goes further is one without motion
CUT = 0.01  # part of the steps in contact that may be cut
CLEAN = ("intersecting", "crossing", "inside", "over")
"""Figures that have to be 0, always."""


@dataclass(slots=True)
class Found:
    """What was found of a case."""

    name: str
    figures: dict[str, float] = field(default_factory=dict)
    limits: dict[str, float] = field(default_factory=dict)
    failed: str = ""
    """Why it ended early."""

    def add(self, name: str, figure: float, limit: float = np.inf) -> None:
        """A figure, and what it may be at most."""
        self.figures[name], self.limits[name] = figure, limit

    @property
    def missed(self) -> list[str]:
        """Figures beyond their limit."""
        return [name for name, figure in self.figures.items() if not figure <= self.limits[name]]

    @property
    def met(self) -> bool:
        """Whether it reached its end with all figures within their limits."""
        return not self.missed and not self.failed


class Watch:
    """A simulation at every step of which an oracle looks."""

    def __init__(self, name: str, simulation: Simulation) -> None:
        """Of one that has not begun yet."""
        self.found = Found(name)
        self.simulation = simulation
        self.tally = Tally()
        self.ms: list[float] = []
        self.late = 0.0
        """Furthest that a body was from where it should be [m]."""
        self._travel = Travel(simulation)
        self._oracle = Oracle(simulation)
        self._count = dict.fromkeys(("frames", "intersecting", "crossing", "inside", "still"), 0)
        self._contact_steps = self._cuts = 0
        if not (start := self._oracle.look(simulation)).clean:
            self.found.failed = f"wrong at the start: {start}"

    def run(
        self, frames: int, driven: bool = False, each: Callable[[Simulation], None] | None = None
    ) -> "Watch":
        """Takes frames; `driven`: there is something that pulls or pushes in each. Stops where it fails."""
        for _ in range(frames):
            if self.found.failed:
                break
            before = self.simulation.positions.copy()
            try:
                self._frame()
            except SimulationError as error:
                self.found.failed = str(error)
            self._count["frames"] += 1
            moved = np.linalg.norm(self.simulation.positions - before, axis=1)[~self.simulation.pinned]
            self._count["still"] += bool(driven and not moved.max() > STILL)
            if each:
                each(self.simulation)
        return self

    def _frame(self) -> None:
        simulation, milliseconds = self.simulation, 0.0
        for _ in range(simulation.substeps):
            start = perf_counter()
            report = simulation.step()
            milliseconds += 1e3 * (perf_counter() - start)
            self._contact_steps += report.contacts > 0
            self._cuts += report.contact_cuts > 0
            self.tally.add(simulation)
            seen = self._oracle.look(simulation)
            self._count["intersecting"] += seen.intersects
            self._count["crossing"] += seen.crosses
            self._count["inside"] += bool(seen.inside)
        self.ms.append(milliseconds)
        late = simulation.body_positions - self._travel.at(simulation.time)
        self.late = max(self.late, float(np.linalg.norm(late, axis=1).max(initial=0.0)))

    def done(self, cut: float = CUT, still: float = np.inf) -> Found:
        """What was found; at most a part `cut` of the steps cut and `still` frames without motion."""
        found, count = self.found, self._count
        found.add("frames", count["frames"])
        for name in ("intersecting", "crossing", "inside"):
            found.add(name, count[name], 0)
        found.add("over", self.tally.over, 0)
        found.add("stretch", self.tally.worst)
        found.add("cut", self._cuts / max(1, self._contact_steps), cut)
        found.add("still", count["still"], still)
        found.add("late", self.late)
        found.add("ms", float(np.mean(self.ms)) if self.ms else 0.0)
        found.add("worst ms", float(np.max(self.ms)) if self.ms else 0.0)
        if not np.isfinite(self.simulation.positions).all():
            found.failed = "not finite"
        return found


Case = tuple[str, Callable[[], Found]]
"""Name, and what measures it."""


def measured(cases: Iterable[Case], effort: Effort) -> list[Found]:
    """All cases that are asked for, told one by one: some take minutes.

    Raises:
        ValueError: none has such a name.
    """
    found = []
    for name, measure in cases:
        if effort.case not in name:
            continue
        one = measure()
        found.append(one)
        print(f"  {name}: {said(one)}", file=sys.stderr, flush=True)
    if not found:
        raise ValueError(f"no case with {effort.case!r} in its name")
    return found


COLUMNS = {
    "frames": ("frames", 1.0),
    "intersecting": ("steps with intersections", 1.0),
    "crossing": ("with crossings", 1.0),
    "inside": ("inside bodies", 1.0),
    "over": ("springs over", 1.0),
    "stretch": ("worst over limit", 1.0),
    "cut": ("cut [% of steps in contact]", 100.0),
    "still": ("frames without motion", 1.0),
    "late": ("body late [mm]", 1e3),
    "ms": ("mean [ms]", 1.0),
    "worst ms": ("worst [ms]", 1.0),
}
"""What every case has: its head in the table, and the factor."""


def row(target: str, found: Sequence[Found], more: dict[str, tuple[str, float]], threads: str = "2") -> Row:
    """A row of the table; `more`: further figures, their heads and factors."""
    parts = [f"{sum(one.met for one in found)} of {len(found)} cases meet all of it"]
    if "frames" in found[0].figures:
        total = {name: sum(one.figures[name] for one in found) for name in ("frames", *CLEAN)}
        parts.append(
            f"in {total['frames']:.0f} frames {total['intersecting']:.0f} steps with intersections, "
            f"{total['crossing']:.0f} with crossings, {total['inside']:.0f} inside bodies, "
            f"{total['over']:.0f} springs over"
        )
    parts += [f"{one.name}: {said(one, more)}" for one in found if not one.met]
    met = all(one.met for one in found)
    return Row(target, "; ".join(parts), met, threads, f"{len(found)} cases, worst", _table(found, more))


def said(one: Found, more: dict[str, tuple[str, float]] | None = None) -> str:
    """What a case missed; all of its figures where `more` does not say what they are."""
    if more is None:
        figures = ", ".join(f"{name} {figure:.3g}" for name, figure in one.figures.items())
        return f"{one.failed or ('met' if one.met else 'missed ' + ', '.join(one.missed))} ({figures})"
    columns = COLUMNS | more
    missed = [f"{columns[name][0]} {columns[name][1] * one.figures[name]:.3g}" for name in one.missed]
    return ", ".join([*missed, *([one.failed] if one.failed else [])])


def _table(found: Sequence[Found], more: dict[str, tuple[str, float]]) -> str:
    """All figures of all cases; those that miss their limit in bold."""
    columns = {
        name: column for name, column in (COLUMNS | more).items() if any(name in one.figures for one in found)
    }
    lines = ["| case | " + " | ".join(head for head, _ in columns.values()) + " |"]
    lines.append("|---|" + "---|" * len(columns))
    for one in found:
        cells = []
        for name, (_, factor) in columns.items():
            text = f"{factor * one.figures[name]:.3g}" if name in one.figures else "–"
            cells.append(f"**{text}**" if name in one.missed else text)
        lines.append(f"| {one.name} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"
