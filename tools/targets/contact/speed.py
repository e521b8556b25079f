"""The row about what contact costs: a frame with it against one without; garments in real time."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
from taut import Simulation
from taut.bench import Spread

from tools.targets.contact.drapes import stage
from tools.targets.contact.garments import worn
from tools.targets.contact.heaps import on_its_edge
from tools.targets.contact.scenes import Stage, kind
from tools.targets.contact.watch import Found, row
from tools.targets.table import Effort, Row

FRAME = 1e3 / 60  # [ms]
COST, WORST, EXPONENT = 3.0, 3.0, 1.1
ACROSS = (33, 65, 129)
"""Vertices along a side of the sheets that show the growth; the last one is compared with itself alone."""
LARGE, LARGE_FRAMES, LARGE_RUNS = 257, 5.0, 2
"""Vertices along a side of one that may take so many frames of real time a frame; how often it is timed."""
FRAMES = 240
THREADS = 2
MORE = {
    "cost": ("x without contact", 1.0),
    "mean": ("mean [ms]", 1.0),
    "uneven": ("worst frame / mean", 1.0),
    "exponent": ("exponent of the growth", 1.0),
}


@dataclass(slots=True)
class Timed:
    """A scene that is timed in several runs."""

    simulation: Simulation
    start: bytes = b""
    means: list[float] = field(default_factory=list)
    """Of the frames of each run [ms]."""
    frames: list[list[float]] = field(default_factory=list)
    """All frames of each run [ms]."""

    @property
    def mean(self) -> float:
        """The median run [ms]."""
        return float(np.median(self.means))

    @property
    def uneven(self) -> float:
        """The slowest frame, each the median of its runs, over the mean [1]."""
        frames = np.median(self.frames, axis=0)
        return float(frames.max() / frames.mean())


def timed(made: Sequence[Stage], effort: Effort, frames: int = FRAMES) -> list[Timed]:
    """Scenes in turn, as often as asked."""
    found = [Timed(one.simulation(THREADS)) for one in made]
    for one in found:
        one.start = one.simulation.snapshot()
    for _ in range(effort.runs):
        for one in found:
            one.simulation.restore(one.start)
            ms = []
            for _ in range(min(frames, effort.frames)):
                begun = perf_counter()
                one.simulation.step(one.simulation.substeps)
                ms.append(1e3 * (perf_counter() - begun))
            one.means.append(float(np.mean(ms)))
            one.frames.append(ms)
    return found


def speed(effort: Effort) -> Row:
    """What it costs."""
    found, costs = [], []
    for mesh in (False, True):
        sizes = [effort.cells(across - 1) + 1 for across in ACROSS]
        *smaller, large, alone = timed(
            [*(stage("ball", across, mesh) for across in sizes), without(sizes[-1], mesh)], effort
        )
        cost = Spread.of(np.divide(large.means, alone.means))
        costs.append(f"{cost.text()} x")
        one = _judged(f"{sizes[-1]}² on a ball, {kind(mesh)}", large)
        one.add("cost", cost.median, COST)
        one.add("uneven", large.uneven, WORST)
        growth = np.log(large.mean / smaller[0].mean) / np.log((sizes[-1] / sizes[0]) ** 2)
        one.add("exponent", float(growth), EXPONENT)
        found.append(one)
    for mesh in (False, True):
        across = effort.cells(64) + 1
        found.append(
            _judged(f"{across}² on its edge, {kind(mesh)}", *timed([on_its_edge(across, mesh)], effort))
        )
    few = replace(effort, runs=min(effort.runs, LARGE_RUNS))
    for mesh in (False, True):
        across = effort.cells(LARGE - 1) + 1
        name = f"{across}² on a ball, {kind(mesh)}"
        found.append(_judged(name, *timed([stage("ball", across, mesh)], few), LARGE_FRAMES * FRAME))
    vertices = effort.garment(16000)
    found.append(_judged(f"skirt of {vertices} on a walker", *timed([worn("skirt", vertices)], effort)))
    target = (
        "129² on a ball, grid and mesh, first 4 s: ≤ 3 x the same sheet that falls from one corner without "
        "contact, ≤ 16.7 ms a frame, no frame over 3 x the mean, growth from 33² with an exponent ≤ 1.1; 65² "
        "heaped and skirt of 16,000 on a walker: ≤ 16.7 ms; 257² on a ball: ≤ 83.3 ms"
    )
    said = row(target, found, MORE, str(THREADS))
    parts = [said.reached, *(f"{one.name} {one.figures['mean']:.1f} ms" for one in found)]
    return Row(target, "; ".join(parts), said.met, said.threads, "; ".join(costs), said.detail)


def without(across: int, mesh: bool) -> Stage:
    """The sheet of the drape, held by one corner, with nothing that it could touch."""
    made = stage("ball", across, mesh)
    document = made.document["cloth"][0]
    # Thickness and friction are what asks for contact.
    fields = {
        name: value for name, value in document.items() if name not in ("thickness", "friction", "name")
    }
    fields |= {"mesh": made.meshes["sheet"]} if mesh else {}
    x, y, z = fields["translate"]
    pins = [{"nearest": [x - 0.5, y - 0.5, z]}]
    return Stage({"fps": 60}).cloth("sheet", **fields, pins=pins)


def _judged(name: str, one: Timed, most: float = FRAME) -> Found:
    found = Found(name)
    found.add("mean", one.mean, most)
    return found
