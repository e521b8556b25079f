"""The table in docs/peers.md and the plot docs/pictures/peers.png, from the results."""

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from engines import PEERS, TAUT, Engine
from judge import Reference, timed, trials_of, winners_of
from listed import Earlier
from search import MOST_GAINED, MOTION, Trial, words
from store import Record, Store

PAGE, PICTURE = "peers.md", "pictures/peers.png"
BEGIN, END = "<!-- results: begin -->\n", "<!-- results: end -->"
DETAILS = ("engine", "size", "limit", "cheapest setting", "worst stretch", "motion")
PLOTTED_SIZE = 64


def line(record: Record) -> str:
    """One record in words."""
    case = record.case
    head = f"{case.engine} {case.scene} {case.size}, {words(case.settings)}: {record.cost:.2f} ms a frame"
    if record.error is not None:
        return f"{head}; {record.error}"
    if record.measured is None:
        return f"{head}; {len(record.cpu_ms)} frames timed again"
    stretch = "unknown" if record.measured.worst is None else f"{100 * record.measured.worst:.2f} %"
    end = (
        ""
        if record.complete
        else f"; given up after {len(record.cpu_ms)} frames, {record.seconds:.0f} s would not do"
    )
    return (
        f"{head}; stretch {stretch}, peak speed {record.measured.peak_speed:.2f} m/s, "
        f"energy gained {100 * record.measured.gained:.1f} %{end}"
    )


Winner = tuple[Trial, float]
"""The cheapest trial that keeps a limit, and its CPU time of a frame by the newest timing [ms]."""
Board = dict[tuple[str, int], dict[float, Winner]]
"""The winners of each engine and size, by limit; without engines and sizes that were not run."""
Tried = dict[tuple[str, int], float]
"""CPU time of all that was tried with each engine at each size [s]."""


def write(store: Store, reference: Reference, limits: Sequence[float], documents: Path) -> None:
    """Write what is known between the markers of the page, and the plot."""
    board = _board(store, reference, limits)
    page = documents / PAGE
    head, rest = page.read_text().split(BEGIN)
    inside, rest = rest.split(END)
    earlier = Earlier(inside)
    lines = [
        *_table(board, _tried(store), earlier, limits),
        "",
        *_settings(board, earlier),
        "",
        " ".join([_circumstances(store, reference, earlier), *earlier.words()]),
    ]
    page.write_text(head + BEGIN + "\n".join(lines) + "\n" + END + rest)
    print("\n".join(lines))
    _plot(store, reference, documents / PICTURE)


def _board(store: Store, reference: Reference, limits: Sequence[float]) -> Board:
    board: Board = {}
    for engine in [TAUT, *PEERS]:
        for size in store.sizes(engine.name, engine.version):
            winners = winners_of(trials_of(store, engine, size, reference), limits)
            board[engine.name, size] = {
                limit: (trial, timed(store, engine, size, trial)) for limit, trial in winners.items()
            }
    return board


def _tried(store: Store) -> Tried:
    return {
        (engine.name, size): sum(run.cpu_seconds for run in store.of(engine.name, engine.version, size))
        for engine in [TAUT, *PEERS]
        for size in store.sizes(engine.name, engine.version)
    }


def _table(board: Board, tried: Tried, earlier: Earlier, limits: Sequence[float]) -> list[str]:
    sizes = {size for _, size in board} | {
        size for engine in [TAUT, *PEERS] for size in _sizes(earlier, engine)
    }
    columns = [(size, limit) for size in sorted(sizes) for limit in limits]
    titles = [f"{size}², {100 * limit:g} %" for size, limit in columns]
    rows = ["| CPU ms a frame | " + " | ".join(titles) + " |", "|---" * (len(columns) + 1) + "|"]
    for engine in [TAUT, *PEERS]:
        cells = [
            _cell(board, tried, engine, *column) or earlier.cell(engine.title, title) or "not run"
            for column, title in zip(columns, titles, strict=True)
        ]
        rows.append(f"| {engine.title} | " + " | ".join(cells) + " |")
    return rows


def _sizes(earlier: Earlier, engine: Engine) -> list[int]:
    return [int(row["size"].rstrip("²")) for row in earlier.details(DETAILS, engine.title)]


def _cell(board: Board, tried: Tried, engine: Engine, size: int, limit: float) -> str:
    """The cost, and for a peer how many times taut's cost that is; empty if it was not run."""
    if (engine.name, size) not in board:
        return ""
    if limit not in board[engine.name, size]:
        return f"none found in {tried[engine.name, size]:.0f} s"
    _, cost = board[engine.name, size][limit]
    ours = board.get((TAUT.name, size), {}).get(limit)
    return (
        figures(cost) if engine is TAUT or ours is None else f"{figures(cost)} ({figures(cost / ours[1])} ×)"
    )


def _settings(board: Board, earlier: Earlier) -> list[str]:
    rows = ["| " + " | ".join(DETAILS) + " |", "|---" * len(DETAILS) + "|"]
    for engine in [TAUT, *PEERS]:
        found: list[tuple[int, list[str]]] = []
        for (name, size), winners in board.items():
            for limit, (trial, _) in winners.items() if name == engine.name else ():
                cells = [engine.title, f"{size}²", f"{100 * limit:g} %", words(trial.settings)]
                cells += [f"{100 * (trial.worst or 0):.2f} %", _range(*trial.motions)]
                found.append((size, cells))
        for size, row in zip(_sizes(earlier, engine), earlier.details(DETAILS, engine.title), strict=True):
            if (engine.name, size) not in board:
                found.append((size, list(row.values())))
        rows += ["| " + " | ".join(cells) + " |" for _, cells in sorted(found, key=lambda one: one[0])]
    return rows


def _circumstances(store: Store, reference: Reference, earlier: Earlier) -> str:
    packages = [
        f"{engine.title}: {', '.join(engine.packages)}"
        for engine in PEERS
        if store.sizes(engine.name, engine.version) or earlier.details(DETAILS, engine.title)
    ]
    speeds = ", ".join(f"{scene} {speed:.2f} m/s" for scene, speed in reference.peak_speeds.items())
    return (
        f"Measured on {store.machine}. {'; '.join(packages)}. Peak speed of the reference's centre of mass: "
        f"{speeds}; a setting counts within {100 * MOTION[0]:.0f} to {100 * MOTION[1]:.0f} % of it in both "
        f"scenes, and if it gains at most {100 * MOST_GAINED:.0f} % of energy."
    )


def _range(low: float, high: float) -> str:
    least, most = f"{100 * low:.0f}", f"{100 * high:.0f}"
    return f"{least} %" if least == most else f"{least} to {most} %"


def figures(value: float) -> str:
    """Two significant figures, no exponent."""
    digits = max(0, 1 - math.floor(math.log10(value))) if value > 0 else 0
    return f"{value:.{digits}f}"


def _plot(store: Store, reference: Reference, path: Path) -> None:
    figure, axes = plt.subplots(figsize=(8, 5), layout="constrained")
    for engine in [TAUT, *PEERS]:
        trials = trials_of(store, engine, PLOTTED_SIZE, reference)
        points = [
            (trial.worst, timed(store, engine, PLOTTED_SIZE, trial))
            for trial in trials
            if trial.all_scenes and trial.worst is not None and trial.keeps(1.0)
        ]
        if points:
            _series(axes, engine.title, points)
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="worst stretch in both scenes",
        ylabel="CPU ms a frame, one thread",
        title=f"{PLOTTED_SIZE} × {PLOTTED_SIZE} particles, 5 s: cost against stretch",
    )
    axes.xaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axes.grid(True, which="both", alpha=0.25)
    axes.legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def _series(axes: Axes, title: str, points: list[tuple[float, float]]) -> None:
    """All settings as faint dots, the line through those that no other one beats in both figures."""
    best: list[tuple[float, float]] = []
    for point in sorted(points):
        if not best or point[1] < best[-1][1]:
            best.append(point)
    [drawn] = axes.plot(*zip(*best, strict=True), marker="o", label=title)
    axes.plot(*zip(*points, strict=True), linestyle="", marker=".", alpha=0.4, color=drawn.get_color())
