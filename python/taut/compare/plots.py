"""The plots of a comparison: one colour a filter, one style of lines and marks an integrator."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogFormatter

from taut.cache import Cache
from taut.compare.comparison import Comparison, Run
from taut.compare.measure import fall, type_one
from taut.compare.methods import known

_COLORS = ("#8a8f98", "#b8860b", "#2a9d8f", "#1d5c9c", "#d1495b", "#7d4f9e", "#e07a1f", "#5aa02c", "#c2529b")
_STYLES = ("-", "--", ":", "-.", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (1, 3)))
_MARKS = "os^DvPX"
_INK, _FAINT = "#1f2933", "#c9d1d8"
_LIMIT: dict[str, Any] = {"color": _INK, "linewidth": 1.0, "linestyle": (0, (5, 3))}
_FLOOR = 1e-3
_LEGEND_ROWS, _MOST_NAMES = 16, 20
_PERCENT = FuncFormatter(lambda value, _: f"{100 * value:g} %")


def draw_plots(found: Comparison, folder: Path) -> list[tuple[str, str]]:
    """Draw every plot into a folder.

    Returns:
        File name and caption of each, in the order in which they are read.
    """
    caches = {run.cache: Cache.open(folder / run.cache) for run in found.runs}
    plots: list[tuple[str, str, Callable[[], Figure]]] = [
        (
            "cost.png",
            "Cost and worst stretch: hollow, as its author uses it; filled, where it keeps the limit",
            lambda: _cost(found),
        ),
        ("stretch.png", "Worst stretch of any spring over time", lambda: _stretch(found, caches)),
        ("distribution.png", "Share of springs beyond a stretch", lambda: _distribution(found, caches)),
        ("motion.png", "Fall, kinetic energy and what is left of all energy", lambda: _motion(found, caches)),
    ]
    if found.passes:
        caption = (
            "What one pass does: stretch of each spring as the step is proposed and as the filter leaves it"
        )
        plots.append(("passes.png", caption, lambda: _passes(found)))
    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        for name, _, draw in plots:
            figure = draw()
            FigureCanvasAgg(figure)
            figure.savefig(folder / name, dpi=130)
    return [(name, caption) for name, caption, _ in plots]


LOOK = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": _FAINT,
    "axes.labelcolor": _INK,
    "axes.grid": True,
    "grid.color": "#e9edf0",
    "xtick.color": _INK,
    "ytick.color": _INK,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
}
"""Of all plots."""


def style(run: Run) -> dict[str, Any]:
    """Colour, line and weight of a run."""
    filters, integrators = known("FilterKind"), known("IntegratorKind")
    return {
        "color": _COLORS[filters.index(run.method.filter) % len(_COLORS)],
        "linestyle": _STYLES[integrators.index(run.method.integrator) % len(_STYLES)],
        "linewidth": 2.4 if run.method.filter == "coarse_to_fine" else 1.4,
        "label": run.label,
    }


def _cost(found: Comparison) -> Figure:
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.subplots()
    timed = [run for run in found.runs if run.figures.ms_per_frame]
    for run in timed:
        point = _point(run)
        color = style(run)["color"]
        usual = run.settings == "usual"
        mark = {"color": color, "markerfacecolor": "white" if usual else color, "markersize": 8, "zorder": 6}
        shape = _MARKS[known("IntegratorKind").index(run.method.integrator) % len(_MARKS)]
        axes.plot(*point, shape, label=run.label if usual else None, **mark)
        for other in () if usual else timed:
            if other.settings == "usual" and other.method == run.method:
                line = {"arrowstyle": "-", "color": color, "linestyle": ":", "shrinkA": 5, "shrinkB": 5}
                axes.annotate("", point, _point(other), arrowprops=line)
    axes.set(xscale="log", yscale="log", xlabel="median time of a frame [ms]", ylabel="worst stretch")
    _write_numbers(axes.xaxis, "{:g}")
    _write_percents(axes.yaxis)
    _show_limit(axes, found)
    axes.margins(0.16, 0.12)
    if len(timed) <= _MOST_NAMES:
        _label_points(axes, timed)
    else:
        _legend(figure, axes)
    return figure


def _point(run: Run) -> tuple[float, float]:
    return run.figures.ms_per_frame or _FLOOR, max(_FLOOR, run.figures.worst_stretch)


def _label_points(axes: Axes, timed: Sequence[Run]) -> None:
    """Names beside the points, moved up where they would overlap."""
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    figure.draw_without_rendering()  # so that places on the page are known
    places: list[tuple[float, float]] = []
    for run in sorted(timed, key=lambda run: run.figures.worst_stretch):
        value = _point(run)
        x, y = axes.transData.transform(value) * 72 / figure.dpi
        while any(abs(x - px) < 90 and abs(y - py) < 9 for px, py in places):
            y += 1.0
        places.append((x, y))
        offset = 7, y - 3 - axes.transData.transform(value)[1] * 72 / figure.dpi
        # The colour names the method.
        text = run.label if run.settings == "usual" else run.label.rpartition(", ")[2]
        note = axes.annotate(
            text, value, offset, textcoords="offset points", fontsize=8, color=style(run)["color"]
        )
        note.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


def _stretch(found: Comparison, caches: dict[str, Cache]) -> Figure:
    figure = Figure(figsize=(7.6, 4.2))
    axes = figure.subplots()
    for run in found.of("usual"):
        cache = caches[run.cache]
        axes.plot(cache.time, cache.diagnostics["worst_stretch"].clip(_FLOOR), **style(run))
    axes.set(yscale="log", xlabel="time [s]", ylabel="worst stretch")
    _write_percents(axes.yaxis)
    _show_limit(axes, found)
    _legend(figure, axes)
    return figure


def _distribution(found: Comparison, caches: dict[str, Cache]) -> Figure:
    figure = Figure(figsize=(7.6, 4.2))
    axes = figure.subplots()
    for run in found.of("usual"):
        values = np.sort(type_one(caches[run.cache])[0], axis=None)
        at = np.unique(np.geomspace(1, max(2, values.size), 400).astype(int)) - 1
        axes.plot(values[::-1][at].clip(_FLOOR), (at + 1) / values.size, **style(run))
    axes.set(
        xscale="log", yscale="log", xlabel="stretch", ylabel="share of springs, over all frames, beyond it"
    )
    _write_percents(axes.xaxis)
    _write_percents(axes.yaxis)
    if found.limit:
        axes.axvline(found.limit, **_LIMIT)
    _legend(figure, axes)
    return figure


def _motion(found: Comparison, caches: dict[str, Cache]) -> Figure:
    rows = 3 if found.body.weight else 2
    figure = Figure(figsize=(7.6, 2.3 * rows))
    panels = list(np.atleast_1d(figure.subplots(rows, sharex=True)))
    for run in found.of("usual"):
        cache, look = caches[run.cache], style(run)
        numbers = cache.diagnostics
        total = numbers["kinetic_energy"] + numbers["elastic_energy"] + numbers["potential_energy"]
        if found.body.weight:
            panels[-3].plot(cache.time, -fall(cache, found.body), **look)
        panels[-2].plot(cache.time, numbers["kinetic_energy"], **look)
        panels[-1].plot(cache.time, total - total[0], **look)
    if found.body.weight:
        panels[-3].set_ylabel("centre of mass [m]\nabove its start")
    panels[-2].set_ylabel("kinetic energy [J]")
    panels[-1].set(ylabel="all energy [J]\nless that at the start", xlabel="time [s]")
    for panel, values in zip(panels[-2:], ("kinetic_energy", None), strict=True):
        _keep_in_view(panel, floor=0.0 if values else None)
    _legend(figure, panels[0])
    return figure


def _keep_in_view(axes: Axes, floor: float | None) -> None:
    """Do not let one run that blows up flatten all others."""
    tops = [float(np.nanmax(np.abs(line.get_ydata()))) for line in axes.get_lines()]
    usual = 4 * float(np.median(tops))
    if max(tops, default=0.0) > usual > 0:
        shown = np.concatenate(
            [
                np.asarray(line.get_ydata())
                for line, top in zip(axes.get_lines(), tops, strict=True)
                if top <= usual
            ]
        )
        low, high = float(shown.min()), float(shown.max())
        margin = 0.25 * (high - low)
        axes.set_ylim(low - margin if floor is None else floor, high + margin)


def _passes(found: Comparison) -> Figure:
    columns = min(4, len(found.passes))
    rows = -(-len(found.passes) // columns)
    figure = Figure(figsize=(3.1 * columns + 0.6, 3.5 * rows))
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels = grid.ravel()[: len(found.passes)]
    for axes in grid.ravel()[len(found.passes) :]:
        axes.set_visible(False)
    limit = found.limit or 0.0
    for axes, (run, one) in zip(panels, found.passes, strict=True):
        shown = (one.before > 0) | (one.after > 0)
        pushed = one.pushed
        for chosen, color in ((shown & ~pushed, "#7f8fa0"), (shown & pushed, "#c2182b")):
            axes.plot(one.before[chosen], one.after[chosen], ".", markersize=2, color=color, rasterized=True)
        axes.axhline(limit, **_LIMIT)
        axes.axvline(limit, **_LIMIT)
        put_over = f"{100 * one.pushed.mean():.2g} % of springs put over the limit"
        axes.set_title(f"{run.label}\n{put_over}", fontsize=9, color=style(run)["color"])
        axes.xaxis.set_major_formatter(_PERCENT)
    top = 3 * limit or None
    panels[0].set(xlim=(0, top), ylim=(0, top))
    figure.supxlabel("stretch proposed", fontsize=9)
    figure.supylabel("stretch after the pass", fontsize=9)
    panels[0].yaxis.set_major_formatter(_PERCENT)
    # Moments in which a filter lets a spring go further are beyond the picture; the table counts them.
    return figure


def _show_limit(axes: Axes, found: Comparison) -> None:
    if found.limit:
        axes.axhline(found.limit, **_LIMIT)


class _Numbers(LogFormatter):
    """Numbers at those ticks of a logarithmic axis that matplotlib finds worth one."""

    def __init__(self, text: str, factor: float) -> None:
        super().__init__(labelOnlyBase=False, minor_thresholds=(1, 0.4))
        self._text, self._factor = text, factor

    def __call__(self, value: float, place: int | None = None) -> str:
        return self._text.format(self._factor * value) if super().__call__(value, place) else ""


def _write_numbers(axis: Axis, text: str, factor: float = 1.0) -> None:
    axis.set_major_formatter(_Numbers(text, factor))
    axis.set_minor_formatter(_Numbers(text, factor))


def _write_percents(axis: Axis) -> None:
    _write_numbers(axis, "{:g} %", 100.0)


def _legend(figure: Figure, axes: Axes) -> None:
    """Names beside the plot; many of them in several columns, for which the figure gets wider."""
    handles, labels = axes.get_legend_handles_labels()
    columns = -(-len(labels) // _LEGEND_ROWS)
    figure.set_figwidth(figure.get_figwidth() + 2.2 * (columns - 1))
    figure.legend(handles, labels, loc="outside right upper", fontsize=8, ncols=columns)
