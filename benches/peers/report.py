"""The table in docs/peers.md and the plot docs/pictures/peers.png, from the results."""

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from engines import PEERS, TAUT, Engine
from judge import Reference, timed, trials_of, winners_of
from search import LEAST_MOTION, Settings, Trial
from store import Record, Store

PAGE, PICTURE = "peers.md", "pictures/peers.png"
BEGIN, END = "<!-- results: begin -->\n", "<!-- results: end -->"
PLOTTED_SIZE = 64


def line(record: Record) -> str:
    """One record in words."""
    case = record.case
    head = f"{case.engine} {case.scene} {case.size}, {_words(case.settings)}: {record.cost:.2f} ms a frame"
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
    return f"{head}; stretch {stretch}, peak speed {record.measured.peak_speed:.2f} m/s{end}"


def write(
    store: Store, reference: Reference, sizes: Sequence[int], limits: Sequence[float], documents: Path
) -> None:
    """Write the table between the markers of the page, and the plot."""
    lines = [*_table(store, reference, sizes, limits), "", *_settings(store, reference, sizes, limits), ""]
    lines += [_circumstances(store, reference)]
    page = documents / PAGE
    head, rest = page.read_text().split(BEGIN)
    page.write_text(head + BEGIN + "\n".join(lines) + "\n" + END + rest.split(END)[1])
    print("\n".join(lines))
    _plot(store, reference, documents / PICTURE)


def _winners(
    store: Store, engine: Engine, size: int, reference: Reference, limits: Sequence[float]
) -> dict[float, tuple[Trial, float]]:
    """The winner for each limit, and its cost by the newest timing [ms]."""
    found = winners_of(trials_of(store, engine, size, reference), limits)
    return {limit: (trial, timed(store, engine, size, trial)) for limit, trial in found.items()}


def _table(store: Store, reference: Reference, sizes: Sequence[int], limits: Sequence[float]) -> list[str]:
    columns = [(size, limit) for size in sizes for limit in limits]
    titles = [f"{size}², {100 * limit:g} %" for size, limit in columns]
    rows = ["| CPU ms a frame | " + " | ".join(titles) + " |", "|---" * (len(columns) + 1) + "|"]
    ours = {size: _winners(store, TAUT, size, reference, limits) for size in sizes}
    for engine in [TAUT, *PEERS]:
        cells = []
        for size in sizes:
            winners = _winners(store, engine, size, reference, limits)
            tried = any(True for _ in store.of(engine.name, engine.version, size))
            cells += [_cell(limit, winners, ours[size], tried) for limit in limits]
        rows.append(f"| {engine.title} | " + " | ".join(cells) + " |")
    return rows


def _cell(
    limit: float,
    winners: dict[float, tuple[Trial, float]],
    ours: dict[float, tuple[Trial, float]],
    tried: bool,
) -> str:
    if limit not in winners:
        return "none found" if tried else "not run"
    cost = winners[limit][1]
    if winners is ours or limit not in ours:
        return _figures(cost)
    ratio = cost / ours[limit][1]
    return _figures(cost) if winners == ours else f"{_figures(cost)} ({_figures(ratio)} ×)"


def _settings(store: Store, reference: Reference, sizes: Sequence[int], limits: Sequence[float]) -> list[str]:
    rows = [
        "| engine | size | limit | cheapest setting | worst stretch | motion |",
        "|---|---|---|---|---|---|",
    ]
    for engine in [TAUT, *PEERS]:
        for size in sizes:
            for limit, (trial, _) in _winners(store, engine, size, reference, limits).items():
                stretch = "" if trial.worst is None else f"{100 * trial.worst:.2f} %"
                words = f"{_words(trial.settings)} | {stretch} | {100 * trial.motion:.0f} %"
                rows.append(f"| {engine.title} | {size}² | {100 * limit:g} % | {words} |")
    return rows


def _circumstances(store: Store, reference: Reference) -> str:
    versions = [
        f"{engine.title}: {', '.join(engine.packages)}"
        for engine in PEERS
        if any(True for size in (32, 64, 128) for _ in store.of(engine.name, engine.version, size))
    ]
    speeds = ", ".join(f"{scene} {speed:.2f} m/s" for scene, speed in reference.peak_speeds.items())
    return (
        f"Measured on {store.machine}. {'; '.join(versions)}. Peak speed of the reference's centre of mass: "
        f"{speeds}; a setting counts from {100 * LEAST_MOTION:.0f} % of it in both scenes."
    )


def _words(settings: Settings) -> str:
    return ", ".join(
        f"{key} {value:g}" if isinstance(value, float) else f"{key} {value}"
        for key, value in settings.items()
    )


def _figures(value: float) -> str:
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
