"""The tables of a comparison of contact, in Markdown."""

from collections.abc import Sequence

from taut.bench import this_machine
from taut.compare.contact.comparing import Found, SceneFound
from taut.compare.contact.running import Run
from taut.compare.table import grid, percent


def tables(found: Found) -> list[str]:
    """A table for each scene and what has to be said below them, as lines of Markdown."""
    lines: list[str] = []
    for scene in found.scenes:
        limit = "no limit for some springs" if scene.limit is None else f"limit {percent(scene.limit)}"
        lines += [f"**{scene.title}** (`{scene.name}`, {scene.vertices} vertices, {limit})", ""]
        lines += [*_table(scene), ""]
    machine = this_machine()
    threads = "one thread" if found.threads == 1 else f"{found.threads} threads"
    notes = [note for scene in found.scenes for note in _notes(scene)]
    notes.append(
        f"- Times: medians, the engine with {threads} on {machine}; taut {machine.version}. `ours` is "
        "compiled, the others are NumPy: rounds tell more about them than milliseconds."
    )
    return [*lines, *notes, ""]


def _table(scene: SceneFound) -> list[str]:
    head = ["method", "steps", "frames that intersect", "closest", "worst stretch", "before contact"]
    head += ["over the limit"]
    head += [] if scene.no_energy else ["energy gained"]
    head += ["rigid", "rounds a step", "ms a frame"]
    return grid(head, [[f"`{run.method}`", *_cells(scene, run)] for run in scene.runs])


def _cells(scene: SceneFound, run: Run) -> list[str]:
    figures = run.figures
    first = figures.first_intersection
    since = "" if first is None else f", first at {first:.2f} s"
    cells = [str(figures.steps_per_frame), f"{figures.intersecting_frames} of {figures.frames}{since}"]
    cells += [closeness(figures.closest), percent(figures.worst_stretch)]
    before = figures.worst_before_contact
    cells += ["–" if before is None else percent(before), percent(figures.over_limit)]
    if not scene.no_energy:
        gained = figures.energy_gained
        cells.append("–" if gained is None else f"{1e3 * gained:.3g} mJ")
    rounds, ms = figures.rounds_per_step, figures.ms_per_frame
    cells.append(percent(figures.rigid) if figures.rigid else "–")
    cells.append(f"{rounds:.2f}" if rounds else "–")
    return [*cells, "–" if ms is None else f"{ms:.3g}"]


def closeness(share: float) -> str:
    """A part of the thickness, for people."""
    if share == 0:
        return "0"
    return f"{100 * share:.0f} %" if share >= 0.01 else f"{100 * share:.0e} %"


def _notes(scene: SceneFound) -> Sequence[str]:
    notes = [
        f"- `{run.method}` on `{scene.name}` ended early: {run.ended}" for run in scene.runs if run.ended
    ]
    notes += [f"- `{method}` refuses `{scene.name}`: {reason}" for method, reason in scene.refused]
    notes += [
        f"- `{run.method}` on `{scene.name}` gives up in {run.figures.given_up} steps: zones still grow."
        for run in scene.runs
        if run.figures.given_up
    ]
    if scene.no_energy:
        notes.append(f"- Energy of `{scene.name}`: not told, since {scene.no_energy}.")
    return notes
