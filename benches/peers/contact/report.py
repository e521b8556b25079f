"""The table of contact in docs/peers.md, from the results."""

import statistics
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

from contact.choose import LIMIT, Verdict
from contact.contenders import Contender
from contact.results import Outcome, Results
from contact.scenes import FRAMES, FRICTION, THICKNESS
from listed import Earlier
from report import figures
from search import MOTION, words
from sheet import FPS

PAGE = "peers.md"
BEGIN, END = "<!-- contact: begin -->\n", "<!-- contact: end -->"
OURS = "taut"
OWN_VERSION = f"taut=={version(OURS)}"

Key = tuple[str, str, int]
"""An engine's name, a scene, a size."""


def line(outcome: Outcome) -> str:
    """One result in words."""
    case, touch = outcome.case, outcome.touch
    head = f"{case.engine} {case.scene} {case.size}, {words(case.settings)}: {outcome.cost:.2f} ms a frame"
    if touch is None:
        return f"{head}; {outcome.error or f'{len(outcome.cpu_ms)} frames timed again'}"
    return (
        f"{head}; {touch.frames} frames, stretch {100 * touch.worst:.2f} %, "
        f"with diagonals {100 * touch.worst_everywhere:.2f} %, intersect {touch.itself} + {touch.bodies}, "
        f"depth {1e3 * touch.depth:.1f} mm, fell {touch.falls[-1] if touch.falls else 0:.3f} m"
        f"{'; ' + outcome.error if outcome.error else ''}"
    )


def write(
    contenders: Sequence[Contender],
    chosen: Mapping[Key, Verdict],
    results: Results,
    documents: Path,
) -> None:
    """Write what is known between the markers of the page."""
    page = documents / PAGE
    head, rest = page.read_text().split(BEGIN)
    inside, rest = rest.split(END)
    earlier = Earlier(inside)
    lines = [*overview(contenders, chosen, results, earlier), ""]
    lines += [*details(contenders, chosen, results, earlier), "", *_absent(contenders, results)]
    lines.append(" ".join([_circumstances(contenders, chosen, results, earlier), *earlier.words()]))
    page.write_text(head + BEGIN + "\n".join(lines) + "\n" + END + rest)
    print("\n".join(lines))


def overview(
    contenders: Sequence[Contender], chosen: Mapping[Key, Verdict], results: Results, earlier: Earlier
) -> list[str]:
    """The cost of each engine in each scene, and what it breaks for that."""
    columns = sorted({(scene, size) for _, scene, size in chosen}, key=lambda column: (column[1], column[0]))
    titles = ["CPU ms a frame", *(f"{scene}, {size}²" for scene, size in columns)]
    rows = [_row(titles), "|---" * len(titles) + "|"]
    for contender in contenders:
        name = contender.name
        unknown = "not installed" if contender.engine.name in results.missing else "not run"
        cells = [
            _cell(chosen, results, (name, *column)) or earlier.cell(contender.title, title) or unknown
            for column, title in zip(columns, titles[1:], strict=True)
        ]
        rows.append(_row([contender.title, *cells]))
    return rows


def _cell(chosen: Mapping[Key, Verdict], results: Results, key: Key) -> str:
    """Empty if there is no result."""
    verdict = chosen.get(key)
    if verdict is None:
        return ""
    touch = verdict.outcome.touch
    if touch is None or touch.frames == 0:
        return f"failed: {verdict.outcome.error or 'no frame'}"
    cost = statistics.median(results.costs(verdict.outcome.case))
    ours = chosen.get((OURS, *key[1:]))
    times = ""
    if key[0] != OURS and ours is not None:
        same_frames = results.costs(ours.outcome.case, touch.frames)
        times = f" ({figures(cost / statistics.median(same_frames))} ×)"
    broken = {
        "failed": verdict.outcome.error or "",
        "intersections": f"{touch.wrong} of {touch.frames} frames intersect",
        "stretch": f"stretch {_per_cent(touch.worst)}",
        "motion": f"motion {100 * verdict.motion:.0f} %",
    }
    faults = [broken[name] for name in verdict.broken]
    if touch.finite and touch.frames < FRAMES:
        faults.append(f"first {touch.frames / FPS:.2f} s")
    return f"{figures(cost)}{times}" + (f"; {', '.join(faults)}" if faults else "")


def details(
    contenders: Sequence[Contender], chosen: Mapping[Key, Verdict], results: Results, earlier: Earlier
) -> list[str]:
    """A line for each engine, size and scene."""
    titles = ["engine", "scene", "size", "setting", "CPU ms (spread)", "stretch", "frames that intersect"]
    titles += ["depth [mm]", "motion", "time [s]", "keeps all"]
    rows = [_row(titles), "|---" * len(titles) + "|"]
    for contender in contenders:
        for (name, scene, size), verdict in chosen.items():
            touch = verdict.outcome.touch
            if name != contender.name or touch is None:
                continue
            case = verdict.outcome.case
            cells = [contender.title, scene, f"{size}²", words(case.settings)]
            cells += [_spread(results.costs(case)), _per_cent(touch.worst)]
            cells += [f"{touch.itself} itself, {touch.bodies} bodies", f"{1e3 * touch.depth:.1f}"]
            cells += [f"{100 * verdict.motion:.0f} %", f"{touch.frames / FPS:.2f}"]
            rows.append(_row([*cells, "no" if verdict.broken else "yes"]))
        known = {(scene, f"{size}²") for name, scene, size in chosen if name == contender.name}
        for row in earlier.details(titles, contender.title):
            if (row["scene"], row["size"]) not in known:
                rows.append(_row(list(row.values())))
    return rows


def _absent(contenders: Sequence[Contender], results: Results) -> list[str]:
    """Why engines are not in the table."""
    known = dict.fromkeys(contender.engine.name for contender in contenders)
    reasons = [results.missing[name] for name in known if name in results.missing]
    return [*(f"- {reason}" for reason in reasons), ""] if reasons else []


def _circumstances(
    contenders: Sequence[Contender], chosen: Mapping[Key, Verdict], results: Results, earlier: Earlier
) -> str:
    run = {name for name, _, _ in chosen} | {one.name for one in contenders if one.title in earlier.kept}
    packages = dict.fromkeys(
        f"{contender.engine.title}: {', '.join(contender.engine.packages) or OWN_VERSION}"
        for contender in contenders
        if contender.name in run
    )
    lacks = [f"{one.title} has {one.lacks}." for one in contenders if one.lacks and one.name in run]
    low, high = MOTION
    sentences = [
        f"Measured on {results.machine}.",
        *([f"{'; '.join(packages)}."] if packages else []),
        f"A run has {FRAMES} frames of 1/60 s if its time sufficed, the thickness is {1e3 * THICKNESS:g} mm,",
        f"the friction {FRICTION:g}. To be kept: {100 * LIMIT:g} % of stretch, no intersection,",
        f"{100 * low:.0f} to {100 * high:.0f} % of the motion.",
        *lacks,
    ]
    return " ".join(sentences)


def _spread(costs: Sequence[float]) -> str:
    middle = figures(statistics.median(costs))
    return middle if len(costs) < 2 else f"{middle} ({figures(min(costs))} – {figures(max(costs))})"


def _per_cent(value: float) -> str:
    return f"{100 * value:.1f} %"


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"
