"""The tables of a comparison, in Markdown."""

import math
from collections.abc import Sequence

from taut.bench import this_machine
from taut.compare.comparison import Comparison, Run
from taut.compare.measure import REST_SHARE
from taut.compare.running import Search


def tables(found: Comparison) -> list[str]:
    """Both tables and what has to be said below them, as lines of Markdown."""
    lines = ["**As their authors use them**", "", *_table(found, found.of("usual")), ""]
    if found.target is not None:
        lines += [f"**With settings that keep the worst stretch at {percent(found.target)}**", ""]
        lines += [*_equal_table(found), ""]
    if found.passes:
        lines += ["**What one pass does to the springs**", "", *_passes_table(found), ""]
    notes = [f"- `{run.label}` ended early: {run.ended}" for run in found.runs if run.ended]
    notes += [f"- `{found.labels[refusal.method]}` refuses: {refusal.reason}" for refusal in found.refused]
    for name, reason in (("Energy", found.body.no_energy), ("Momentum", found.body.no_momentum)):
        if reason:
            notes.append(f"- {name}: not defined, since {reason}.")
    if found.body.rest_speed:
        notes.append(
            f"- At rest: from frame to frame the cloth moves by less than {found.body.rest_speed:.3g} m/s"
            f" (root mean square), {100 * REST_SHARE:g} % of the speed of a fall by its own size."
        )
    machine = this_machine()
    threads = "one thread" if found.threads == 1 else f"{found.threads} threads"
    notes.append(f"- Times: medians, {threads} on {machine}; taut {machine.version}.")
    return [*lines, *notes, ""]


def _table(found: Comparison, runs: Sequence[Run]) -> list[str]:
    head = [
        "method",
        "steps",
        "worst",
        "warp, weft",
        "99 %",
        "mean",
        "over the limit",
        "ms a frame",
        "ms a step",
    ]
    head += [] if found.body.no_energy else ["energy kept"]
    head += [] if found.body.no_momentum else ["momentum drift"]
    head += ["fallen", "at rest after"] if found.body.rest_speed else []
    rows = [[f"`{run.label}`", *_cells(found, run)] for run in runs]
    return grid(head, rows)


def _cells(found: Comparison, run: Run) -> list[str]:
    figures = run.figures
    cells = [str(figures.steps_per_frame)]
    cells += [percent(x) for x in (figures.worst_stretch, figures.worst_structural)]
    cells += [percent(x) for x in (figures.p99_stretch, figures.mean_stretch, figures.over_limit)]
    cells += [_number(figures.ms_per_frame), _number(figures.ms_per_step)]
    if not found.body.no_energy:
        cells.append("–" if figures.energy_kept is None else f"{100 * figures.energy_kept:.3g} %")
    if not found.body.no_momentum:
        cells.append("–" if figures.momentum_drift is None else f"{figures.momentum_drift:.1e}")
    if found.body.rest_speed:
        cells.append("–" if figures.fallen is None else f"{figures.fallen:.2f} m")
        last = (figures.frames - 1) / found.fps
        cells.append(f"not in {last:.3g} s" if figures.rest_time is None else f"{figures.rest_time:.2f} s")
    return cells


def _equal_table(found: Comparison) -> list[str]:
    """A row for each search; next to the cost, that over the least."""
    reached = {run.method: run for run in found.of("usual")} | {run.method: run for run in found.of("equal")}
    kept = [reached[method] for method, search in found.searches if search.factor is not None]
    least = min((run.figures.ms_per_frame or math.inf for run in kept), default=math.inf)
    head = ["method", "setting", "steps", "worst", "99 %", "ms a frame", "over the least"]
    head += [] if found.body.no_energy else ["energy kept"]
    rows = []
    for method, search in found.searches:
        label = f"`{found.labels[method]}`"
        if search.factor is None:
            rows.append([label, _given_up(search), *["–"] * (len(head) - 2)])
            continue
        figures = reached[method].figures
        setting = "as it is" if search.factor == 1 else f"{search.factor:.3g} x {search.dial.name}"
        cells = [setting, str(figures.steps_per_frame), percent(figures.worst_stretch)]
        cells += [percent(figures.p99_stretch), _number(figures.ms_per_frame)]
        cost = figures.ms_per_frame
        cells.append(f"{cost / least:.3g} x" if cost and least else "–")
        if not found.body.no_energy:
            cells.append("–" if figures.energy_kept is None else f"{100 * figures.energy_kept:.3g} %")
        rows.append([label, *cells])
    return grid(head, rows)


def _given_up(search: Search) -> str:
    """How far the search came."""
    if not search.trials:
        return f"not reached: {search.why_not}"
    last = search.trials[-1]
    seen = f"{percent(last.worst_stretch)} at {last.ended:.2f} s" if last.ended is not None else ""
    return f"not reached within {last.factor:g} x {search.dial.name} ({seen}; {search.why_not})"


def _passes_table(found: Comparison) -> list[str]:
    head = [
        "method",
        "over the limit before",
        "after",
        "put over it by the pass",
        "of the neighbours of mended ones",
    ]
    rows = [
        [
            f"`{run.label}`",
            *[percent(share) for share in (one.over_before, one.over_after, float(one.pushed.mean()))],
            "–" if one.pushed_neighbours is None else percent(one.pushed_neighbours),
        ]
        for run, one in found.passes
    ]
    return grid(head, rows)


def grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table as lines of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(line) + " |" for line in lines]


def percent(share: float) -> str:
    """A share in per cent, for people."""
    percent = 100 * share
    if not math.isfinite(percent) or abs(percent) >= 1e5:
        return f"{percent:.2g} %"
    return f"{percent:.2f} %" if abs(percent) < 100 else f"{percent:.0f} %"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"
