"""Rows about time. The load varies as the cloth falls: means over the same window of frames are compared.

Every case runs several times, cases that are compared in turn; a ratio is taken of each pair.
"""

from collections.abc import Sequence
from dataclasses import replace

from taut import bench
from taut.bench import Case, Runs, Spread, Timeable, Window
from taut.bench import Row as Measured

from tools.targets.table import Effort, Row

SCENES = ("one-corner", "two-corners", "flag")

measured: list[Measured] = []


def timed(cases: Sequence[Timeable], window: Window) -> list[Runs]:
    """Times cases in turn and remembers whether something disturbed that."""
    runs = bench.runs_in_turn(cases, window)
    measured.extend(one.row for one in runs)
    return runs


def growth(effort: Effort) -> Row:
    """Cost per particle of a large and a small sheet."""
    cases = (Case("one-corner", effort.cells(512), 0.1), Case("one-corner", effort.cells(64), 0.1))
    runs = timed(cases, replace(effort.window, seconds=2 * effort.seconds))
    large, small = (one.row for one in runs)
    frame = Spread.of(runs[0].ms / runs[1].ms * small.vertices / large.vertices)
    step = frame.median * small.steps_per_frame / large.steps_per_frame
    reached = (
        f"{frame.median:.2f} x a frame ({large.steps_per_frame} against {small.steps_per_frame} steps), "
        f"{step:.2f} x a step; {_window(large)}"
    )
    target = "cost per particle, 512² against 64², same settings: ≤ 1.5 x"
    return Row(target, reached, frame.median <= 1.5, spread=f"{frame.text()} x")


def one_thread(effort: Effort) -> Row:
    """Frame / yardstick at 128²."""
    runs = [timed((Case(scene, effort.cells(128), 0.1, 1),), effort.window)[0] for scene in SCENES]
    met = all(one.row.ratio <= 60 for one in runs)
    return Row("128², λ 10 %, one thread: frame / yardstick ≤ 60", _list(runs), met, "1", _spreads(runs))


def two_threads(effort: Effort) -> Row:
    """Frame and frame / yardstick at 256²."""
    runs = [timed((Case(scene, effort.cells(256), 0.1, 2),), effort.window)[0] for scene in SCENES]
    met = all(one.row.ratio <= 40 and one.row.ms_per_frame <= 16 for one in runs)
    target = "256², λ 10 %, two threads: ≤ 16 ms a frame, ≤ 40 yardsticks (of one thread)"
    return Row(target, _list(runs), met, "2", _spreads(runs))


def tight(effort: Effort) -> Row:
    """Lambda of 1 % against 10 %."""
    parts, spreads, cells = [], [], effort.cells(128)
    for scene in SCENES:
        cases = (Case(scene, cells, 0.01), Case(scene, cells, 0.1))
        narrow, wide = timed(cases, replace(effort.window, seconds=2 * effort.seconds))
        spreads.append(Spread.of(narrow.ms / wide.ms))
        parts.append(f"{scene} {spreads[-1].median:.2f} x ({_window(narrow.row)})")
    met = all(spread.median <= 3 for spread in spreads)
    spread = "; ".join(f"{one.text()} x" for one in spreads)
    target = "λ 1 % against 10 %, same scene: ≤ 3 x the cost"
    return Row(target, _at(cells) + "; ".join(parts), met, spread=spread)


def _window(row: Measured) -> str:
    return f"first {row.window:.2g} s"


def _at(cells: int) -> str:
    return f"{cells}²: "


def disturbed() -> bool:
    """Whether the processor was busy with something else since this was last asked."""
    busy = any(row.disturbed for row in measured)
    measured.clear()
    return busy


def _list(runs: list[Runs]) -> str:
    rows = [one.row for one in runs]
    parts = [f"{row.scene} {row.ratio:.0f} ({row.ms_per_frame:.2f} ms, {_window(row)})" for row in rows]
    return _at(rows[0].cells) + "; ".join(parts)


def _spreads(runs: list[Runs]) -> str:
    return "; ".join(f"{Spread.of(one.ms).text()} ms" for one in runs)
