"""Rows about time. The load varies as the cloth falls: means over the same window of frames are compared."""

from functools import cache

from taut import bench
from taut.bench import Case, Window
from taut.bench import Row as Measured

from tools.targets.table import Effort, Row

SCENES = ("one-corner", "two-corners", "flag")

measured: list[Measured] = []


@cache
def measure(case: Case, window: Window) -> Measured:
    """Measures once what several rows need."""
    measured.append(bench.measure(case, window))
    return measured[-1]


def growth(effort: Effort) -> Row:
    """Cost per particle of a large and a small sheet."""
    cells = effort.cells(512), effort.cells(64)
    large = measure(Case("one-corner", cells[0], 0.1), Window(effort.frames, 2 * effort.seconds))
    small = measure(Case("one-corner", cells[1], 0.1), _the_same(large))
    frame = large.ns_per_particle_frame / small.ns_per_particle_frame
    step = large.ns_per_particle_step / small.ns_per_particle_step
    reached = (
        f"{frame:.2f} x a frame ({large.steps_per_frame} against {small.steps_per_frame} steps), "
        f"{step:.2f} x a step; {_window(large)}"
    )
    return Row("cost per particle, 512² against 64², same settings: ≤ 1.5 x", reached, frame <= 1.5)


def one_thread(effort: Effort) -> Row:
    """Frame / yardstick at 128²."""
    rows = [measure(Case(scene, effort.cells(128), 0.1, 1), effort.window) for scene in SCENES]
    met = all(row.ratio <= 60 for row in rows)
    return Row("128², λ 10 %, one thread: frame / yardstick ≤ 60", _list(rows), met)


def two_threads(effort: Effort) -> Row:
    """Frame and frame / yardstick at 256²."""
    rows = [measure(Case(scene, effort.cells(256), 0.1, 2), effort.window) for scene in SCENES]
    met = all(row.ratio <= 40 and row.ms_per_frame <= 16 for row in rows)
    return Row(
        "256², λ 10 %, two threads: ≤ 16 ms a frame, ≤ 40 yardsticks (of one thread)", _list(rows), met
    )


def tight(effort: Effort) -> Row:
    """Lambda of 1 % against 10 %."""
    parts, worst = [], 0.0
    for scene in SCENES:
        narrow = measure(Case(scene, effort.cells(128), 0.01), Window(effort.frames, effort.seconds))
        wide = measure(Case(scene, effort.cells(128), 0.1), _the_same(narrow))
        ratio = narrow.ms_per_frame / wide.ms_per_frame
        worst = max(worst, ratio)
        parts.append(f"{scene} {ratio:.2f} x ({_window(narrow)})")
    return Row(
        "λ 1 % against 10 %, same scene: ≤ 3 x the cost",
        _at(effort.cells(128)) + "; ".join(parts),
        worst <= 3,
    )


def mesh(effort: Effort) -> Row:
    """An irregular mesh from a file against a grid."""
    cells = effort.cells(223)
    irregular = measure(Case("mesh", cells, 0.1), Window(effort.frames, 2 * effort.seconds))
    grid = measure(Case("one-corner", cells, 0.1), _the_same(irregular))
    ratio = irregular.ms_per_frame / grid.ms_per_frame
    reached = (
        f"{ratio:.2f} x: {irregular.ms_per_frame:.1f} against {grid.ms_per_frame:.1f} ms, "
        f"{irregular.vertices:,} vertices; {_window(irregular)}"
    )
    return Row(
        "imported 50k-vertex mesh against a grid of as many vertices: ≤ 3 x the cost", reached, ratio <= 3
    )


def _the_same(row: Measured) -> Window:
    """The window of a row, however long it takes."""
    return Window(row.frames, float("inf"))


def _window(row: Measured) -> str:
    return f"first {row.window:.2g} s"


def _at(cells: int) -> str:
    return f"{cells}²: "


def disturbed() -> bool:
    """Whether the processor was busy with something else."""
    return any(row.disturbed for row in measured)


def _list(rows: list[Measured]) -> str:
    parts = [f"{row.scene} {row.ratio:.0f} ({row.ms_per_frame:.2f} ms, {_window(row)})" for row in rows]
    return _at(rows[0].cells) + "; ".join(parts)
