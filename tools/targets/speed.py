"""Rows about time. The load varies as the cloth falls: means over the same window of frames are compared."""

from dataclasses import replace

from taut import bench
from taut.bench import Case
from taut.bench import Row as Measured

from tools.targets.table import Effort, Row

SCENES = ("one-corner", "two-corners", "flag")

measured: list[Measured] = []


def measure(case: Case, effort: Effort) -> Measured:
    """Measures a case on its own."""
    measured.append(bench.measure(case, effort.window))
    return measured[-1]


def compare(cases: tuple[Case, Case], effort: Effort) -> list[Measured]:
    """Measures two cases in turn."""
    rows = bench.measure_in_turn(cases, replace(effort.window, seconds=2 * effort.seconds))
    measured.extend(rows)
    return rows


def growth(effort: Effort) -> Row:
    """Cost per particle of a large and a small sheet."""
    cells = effort.cells(512), effort.cells(64)
    large, small = compare((Case("one-corner", cells[0], 0.1), Case("one-corner", cells[1], 0.1)), effort)
    frame = large.ns_per_particle_frame / small.ns_per_particle_frame
    step = large.ns_per_particle_step / small.ns_per_particle_step
    reached = (
        f"{frame:.2f} x a frame ({large.steps_per_frame} against {small.steps_per_frame} steps), "
        f"{step:.2f} x a step; {_window(large)}"
    )
    return Row("cost per particle, 512² against 64², same settings: ≤ 1.5 x", reached, frame <= 1.5)


def one_thread(effort: Effort) -> Row:
    """Frame / yardstick at 128²."""
    rows = [measure(Case(scene, effort.cells(128), 0.1, 1), effort) for scene in SCENES]
    met = all(row.ratio <= 60 for row in rows)
    return Row("128², λ 10 %, one thread: frame / yardstick ≤ 60", _list(rows), met)


def two_threads(effort: Effort) -> Row:
    """Frame and frame / yardstick at 256²."""
    rows = [measure(Case(scene, effort.cells(256), 0.1, 2), effort) for scene in SCENES]
    met = all(row.ratio <= 40 and row.ms_per_frame <= 16 for row in rows)
    return Row(
        "256², λ 10 %, two threads: ≤ 16 ms a frame, ≤ 40 yardsticks (of one thread)", _list(rows), met
    )


def tight(effort: Effort) -> Row:
    """Lambda of 1 % against 10 %."""
    parts, worst = [], 0.0
    for scene in SCENES:
        cells = effort.cells(128)
        narrow, wide = compare((Case(scene, cells, 0.01), Case(scene, cells, 0.1)), effort)
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
    irregular, grid = compare((Case("mesh", cells, 0.1), Case("one-corner", cells, 0.1)), effort)
    ratio = irregular.ms_per_frame / grid.ms_per_frame
    reached = (
        f"{ratio:.2f} x: {irregular.ms_per_frame:.1f} against {grid.ms_per_frame:.1f} ms, "
        f"{irregular.vertices:,} vertices; {_window(irregular)}"
    )
    return Row(
        "imported 50k-vertex mesh against a grid of as many vertices: ≤ 3 x the cost", reached, ratio <= 3
    )


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
