"""Rows about irregular meshes: their cost beside grids, how even it is, on two threads, how it grows."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray
from taut.bench import Runs, Spread, Window
from taut.bench.trials import Trial

from tools.targets.speed import timed
from tools.targets.table import Effort, Row

SCENES = (
    ("one-corner", 0.1),
    ("one-corner", 0.01),
    ("two-corners", 0.1),
    ("two-corners", 0.01),
    ("flag", 0.05),
    ("storm", 0.03),
    ("skirt", 0.05),
    ("cape", 0.05),
)
ACROSS = (65, 129, 225)
FRAMES = 300
FACTOR, EVENNESS, SPEEDUP, GROWTH = 2.0, 3.0, 1.6, 1.5
"""Cost beside a grid; cycles of the 95th percentile beside the median; two threads; a large mesh's vertex."""


@dataclass(slots=True)
class Pairs:
    """A scene at a size: a mesh and a grid with as many vertices, in turn, with a new mesh for every pair."""

    scene: str
    strain_limit: float
    vertices: int
    ratios: list[float] = field(default_factory=list)
    mesh: list[Runs] = field(default_factory=list)
    grid: list[Runs] = field(default_factory=list)

    @property
    def name(self) -> str:
        """For the tables."""
        return f"{self.scene} {100 * self.strain_limit:g} %, {round(np.sqrt(self.vertices))}²"

    @property
    def uneven(self) -> float:
        """Largest 95th percentile of the cycles over their median, of any of its runs [1]."""
        return max(evenness(runs.cycles) for runs in self.mesh + self.grid)


def evenness(cycles: NDArray[np.float64]) -> float:
    """95th percentile over the median [1]."""
    return float(np.percentile(cycles, 95) / max(float(np.median(cycles)), 1.0))


def pairs(effort: Effort) -> Iterator[Pairs]:
    """All scenes at all sizes, measured."""
    for across in sorted({effort.vertices(across) for across in effort.sizes or ACROSS}):
        for scene, limit in SCENES:
            yield _pairs(scene, limit, across, effort)


@cache
def _pairs(scene: str, limit: float, vertices: int, effort: Effort) -> Pairs:
    found = Pairs(scene, limit, vertices)
    window = Window(effort.frames, np.inf)
    for seed in range(1, effort.runs + 1):
        cases = [Trial(scene, vertices, limit, "mesh", seed), Trial(scene, vertices, limit, "grid")]
        mesh, grid = timed(cases, window)
        found.ratios.append(float(mesh.ms[0] / grid.ms[0]))
        found.mesh.append(mesh)
        found.grid.append(grid)
    return found


def beside_a_grid(effort: Effort) -> Row:
    """Mean frame of a mesh over that of a grid with as many vertices."""
    found = list(pairs(effort))
    worst = max(found, key=lambda pair: np.median(pair.ratios))
    spread = Spread.of(worst.ratios)
    ms = [np.median([runs.ms[0] for runs in side]) for side in (worst.mesh, worst.grid)]
    held = sum(float(np.median(pair.ratios)) <= FACTOR for pair in found)
    reached = (
        f"worst {spread.median:.2f} x ({worst.name}: {ms[0]:.2f} against {ms[1]:.2f} ms); "
        f"{held} of {len(found)} cases hold it"
    )
    target = (
        "irregular meshes against grids of as many vertices, mean frame of the first 5 s, drops at 10 and "
        "1 %, flag, storm, skirt, cape at 65², 129² and 225² vertices: ≤ 2 x the cost in each"
    )
    lines = [
        "| scene | mesh / grid | mesh [ms] | grid [ms] | cycles a step, mesh: median, 95 %, most | grid |"
    ]
    lines.append("|---|---|---|---|---|---|")
    lines += [_line(pair) for pair in found]
    detail = "\n".join(lines) + "\n"
    return Row(target, reached, spread.median <= FACTOR, "1", f"{spread.text()} x, a new mesh each", detail)


def _line(pair: Pairs) -> str:
    times = [np.median([runs.ms[0] for runs in side]) for side in (pair.mesh, pair.grid)]
    cycles = [np.concatenate([runs.cycles for runs in side]) for side in (pair.mesh, pair.grid)]
    said = [f"{np.median(c):.3g}, {np.percentile(c, 95):.3g}, {c.max():.3g}" for c in cycles]
    ratio = Spread.of(pair.ratios)
    text = ratio.text() if ratio.median <= FACTOR else f"**{ratio.text()}**"
    return f"| {pair.name} | {text} | {times[0]:.2f} | {times[1]:.2f} | {said[0]} | {said[1]} |"


def cycles(effort: Effort) -> Row:
    """How many more cycles hard frames need than others."""
    found = list(pairs(effort))
    worst = max(found, key=lambda pair: pair.uneven)
    most = max(worst.mesh + worst.grid, key=lambda runs: evenness(runs.cycles)).cycles
    uneven = [pair.uneven for pair in found]
    held = sum(x <= EVENNESS for x in uneven)
    reached = (
        f"worst {worst.uneven:.1f} x ({worst.name}: median {np.median(most):.0f}, 95 % "
        f"{np.percentile(most, 95):.0f}, most {most.max():.0f}); {held} of {len(uneven)} cases hold it"
    )
    target = "cycles of the filter for a step, in each of these scenes: 95th percentile ≤ 3 x the median"
    return Row(
        target, reached, worst.uneven <= EVENNESS, "1", f"{Spread.of(uneven).text(1)} x over the cases"
    )


def threads(effort: Effort) -> Row:
    """Two threads against one."""
    parts, spreads = [], []
    for scene, limit, across in (
        ("one-corner", 0.1, 129),
        ("two-corners", 0.01, 129),
        ("storm", 0.03, 129),
        ("skirt", 0.05, 129),
        ("one-corner", 0.1, 225),
        ("cape", 0.05, 225),
    ):
        vertices = effort.vertices(across)
        cases = [Trial(scene, vertices, limit, threads=count) for count in (1, 2)]
        one, two = timed(cases, Window(max(1, effort.frames // 4), np.inf, effort.runs))
        spreads.append(Spread.of(one.ms / two.ms))
        parts.append(f"{scene} {100 * limit:g} %, {across}² {spreads[-1].text()} x")
    slowest = min(spreads, key=lambda spread: spread.median)
    return Row(
        "irregular meshes from 129² vertices on, first 1.25 s: two threads ≥ 1.6 x as fast as one",
        "; ".join(parts),
        slowest.median >= SPEEDUP,
        "1 and 2",
        f"{slowest.text()} x",
    )


def growth(effort: Effort) -> Row:
    """Cost of a vertex in a large and in a small mesh."""
    large, small = effort.vertices(513), effort.vertices(65)
    cases = [Trial("one-corner", vertices, 0.1) for vertices in (large, small)]
    found = timed(cases, Window(min(effort.frames, 120), np.inf, effort.runs))
    ratio = Spread.of(found[0].ms / found[1].ms * small / large)
    rows = [runs.row for runs in found]
    reached = (
        f"{ratio.median:.2f} x a frame ({rows[0].steps_per_frame} against {rows[1].steps_per_frame} steps): "
        f"{rows[0].ns_per_particle_frame:.0f} against {rows[1].ns_per_particle_frame:.0f} ns"
    )
    target = "cost of a vertex, irregular meshes, first 2 s, 513² against 65² vertices: ≤ 1.5 x"
    return Row(target, reached, ratio.median <= GROWTH, "1", f"{ratio.text()} x")
