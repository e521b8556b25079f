"""Numbers of a run as tables for people."""

import math
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from taut.cache import Cache, Summary
    from taut.compare import Comparison
    from taut.compare.contact import Found
    from taut.scene import Needs

Rows = list[tuple[str, str]]


def run_table(cache: "Cache", summary: "Summary") -> Rows:
    """The short table at the end of a run."""
    return [
        ("worst stretch", worst_stretch(cache, summary)),
        ("energy at the end", _energy(summary)),
        ("speed", _speed(summary)),
        ("limited steps", _limited(summary)),
        ("state hash", summary.state_hash),
    ]


def full_table(cache: "Cache", summary: "Summary") -> Rows:
    """Everything that ``taut info`` prints."""
    length = f"{summary.frames}, {summary.duration:.3f} s"
    step = f"{summary.substeps} a frame of {1e3 * summary.step_length:.4g} ms"
    limit = "none for some springs" if summary.limit is None else f"{_per_cent(summary.limit)}"
    return [
        ("title", summary.title),
        ("frames", length),
        ("vertices", str(summary.vertices)),
        ("springs", str(summary.springs)),
        ("steps", step),
        ("strain limit", limit),
        *run_table(cache, summary),
        ("worst between frames", _per_cent(summary.worst_stretch_in_steps)),
        *([("contact", _contact(summary))] if summary.contacts else []),
        *([("time of phases", _phases(summary))] if summary.solve_ms else []),
        ("threads", str(summary.threads)),
        ("written by", f"taut {summary.version}"),
    ]


def needs_table(needs: "Needs", frames: int) -> Rows:
    """What ``taut run --dry-run`` prints."""
    return [
        ("frames", str(frames)),
        ("vertices", str(needs.vertices)),
        ("springs", f"about {needs.springs}"),
        ("memory", f"about {_size(needs.memory)}, beside Python and the scene itself"),
        ("disk", f"about {_size(needs.disk)}"),
    ]


def _size(count: int) -> str:
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{max(1, round(count / 1e6))} MB"


def comparison_table(found: "Comparison") -> Rows:
    """A line for each run of a comparison, and one for each method that could not take part."""
    rows = []
    for run in found.runs:
        figures = run.figures
        worst = f"worst stretch {_per_cent(figures.worst_stretch)}"
        cost = "" if figures.ms_per_frame is None else f", {figures.ms_per_frame:.3g} ms a frame"
        ended = f"; ended early: {run.ended}" if run.ended else ""
        rows.append((run.label, worst + cost + ended))
    for method, search in found.searches:
        if search.factor is None:
            rows.append((found.labels[method], f"limit not reached: {search.why_not}"))
    return rows + [(found.labels[refusal.method], f"refused: {refusal.reason}") for refusal in found.refused]


def contact_table(found: "Found") -> Rows:
    """A line for each run of a comparison of contact, and one for each method that could not take part."""
    rows = []
    for scene in found.scenes:
        for run in scene.runs:
            figures = run.figures
            text = f"{figures.intersecting_frames} of {figures.frames} frames intersect, "
            text += f"worst stretch {_per_cent(figures.worst_stretch)}"
            text += "" if figures.ms_per_frame is None else f", {figures.ms_per_frame:.3g} ms a frame"
            text += f"; ended early: {run.ended}" if run.ended else ""
            rows.append((f"{scene.name}, {run.method}", text))
        rows += [(f"{scene.name}, {method}", f"refused: {reason}") for method, reason in scene.refused]
    return rows


def show(rows: Rows) -> None:
    """Print a table to standard output."""
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in rows:
        table.add_row(name, value)
    Console(markup=False, highlight=False).print(table)


def worst_stretch(cache: "Cache", summary: "Summary") -> str:
    """The worst stretch in per cent, where and when."""
    if summary.worst_vertices is None:
        return "no springs"
    from taut.cache import cloth_of

    first, second = (cloth_of(cache, vertex)[1] for vertex in summary.worst_vertices)
    where = f"in {summary.worst_cloth}, vertices {first} and {second}"
    when = f"frame {summary.worst_frame} ({summary.worst_time:.3f} s)"
    return f"{_per_cent(summary.worst_stretch)} {where}, {when}"


def _per_cent(fraction: float) -> str:
    return f"{100 * fraction:.2f} %"


def _energy(summary: "Summary") -> str:
    parts = {
        "kinetic": summary.kinetic_energy,
        "elastic": summary.elastic_energy,
        "potential": summary.potential_energy,
    }
    return ", ".join(f"{name} {value:.4g} J" for name, value in parts.items())


def _limited(summary: "Summary") -> str:
    steps = f"{summary.limited_steps} of {(summary.frames - 1) * summary.substeps}"
    pins = f"{summary.held_back_pins} times with pins held back" if summary.held_back_pins else ""
    if summary.cuts == 0:
        return f"{steps}, {pins}" if pins else steps
    pins = f" ({pins})" if pins else ""
    lost = (
        f"{_per_cent(summary.mean_lost_motion)} of the motion lost ({_per_cent(summary.lost_motion)} at most)"
    )
    return f"{steps}, {summary.cuts} shortened by the certificate{pins}: {lost}"


def _contact(summary: "Summary") -> str:
    steps = max(1, (summary.frames - 1) * summary.substeps)
    nearest = f", {1e3 * summary.closest:.3g} mm at the nearest" if math.isfinite(summary.closest) else ""
    cuts = f"{summary.halved_steps} of {steps} steps in parts, {summary.contact_cuts} shortened"
    pinched = f", {summary.pinched / steps:.3g} of them pinched" if summary.pinched else ""
    held = f", bodies held back {summary.held_back_bodies} times" if summary.held_back_bodies else ""
    left = f", {summary.penetrations} places still intersect" if summary.penetrations else ""
    return f"{summary.contacts / steps:.0f} pairs a step{pinched}{nearest}, {cuts}{held}{left}"


def _phases(summary: "Summary") -> str:
    frames = max(1, summary.frames - 1)
    detection, solve, certificate = (
        f"{total / frames:.2f}" for total in (summary.detection_ms, summary.solve_ms, summary.certificate_ms)
    )
    if not summary.detection_ms + summary.certificate_ms:
        return f"solve {solve} ms a frame on the mean"
    return f"detection {detection}, solve {solve}, certificate {certificate} ms a frame on the mean"


def _speed(summary: "Summary") -> str:
    if summary.ms_per_frame is None or summary.real_time is None:
        return "nothing was simulated"
    speed = f"{summary.ms_per_frame:.2f} ms a frame, {summary.real_time:.3g} x real time"
    return f"{speed} ({summary.threads} threads)"
