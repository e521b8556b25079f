"""A comparison as a folder: a page in Markdown, the figures in JSON, plots, a strip of stills and a film."""

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

from taut import _taut
from taut.bench import this_machine
from taut.cache import Cache
from taut.compare.comparison import Comparison, Run
from taut.compare.plots import draw_plots
from taut.compare.running import Search, Watch
from taut.compare.table import percent, tables
from taut.frames import Frames
from taut.render import RenderOptions, render_film, render_strip

FORMAT = "taut-comparison/1"
"""Of the JSON file; the number changes when a name in it changes its meaning or goes."""

_MOMENTS = (0.1, 0.2, 0.4, 0.7, 1.0)
"""Of the strip, as shares of the duration."""
_LARGEST_FILM = 1200  # pixels wide, or a little more
_STRIP_PANEL = (380, 320)
_MOST_PANELS, _TALLEST = 60, 7500  # of a strip; beyond either, panels get smaller


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture in the folder."""

    name: str
    """File name."""
    caption: str
    """What it shows."""


def write_report(found: Comparison, folder: Path, film: bool, watch: Watch) -> None:
    """Write everything that is made of the runs in a folder beside them.

    Args:
        found: what was found.
        folder: where the caches are, and the report goes.
        film: whether to make the side-by-side film; a comparison that was interrupted gets none.
        watch: told of the frames of the film.

    Raises:
        RenderError: pictures cannot be made here.
        OSError: the folder cannot be written.
    """
    pictures = [Picture(*plot) for plot in draw_plots(found, folder)]
    shown = [Cache.open(folder / run.cache) for run in found.of("usual")]
    end = max(float(cache.time[-1]) for cache in shown)
    times = sorted({round(share * end, 4) for share in _MOMENTS})
    size = _panel(len(shown), len(times))
    render_strip(shown, times, folder / "strip.jpg", RenderOptions(color="strain", size=size))
    pictures.append(Picture("strip.jpg", "The same moments of each, coloured by stretch"))
    filmed = film and not found.interrupted and make_film(found, shown, folder / "film.mp4", 720, watch)
    page = markdown(found, pictures, filmed)
    write_pages(folder, page, to_json(found, pictures))


def _panel(rows: int, columns: int) -> tuple[int, int]:
    """Width and height of a panel of the strip [pixels]."""
    width, height = _STRIP_PANEL
    share = min(1.0, math.sqrt(_MOST_PANELS / (rows * columns)), _TALLEST / (rows * height))
    return max(64, round(width * share)), max(64, round(height * share))


def is_ours(name: str) -> bool:
    """Whether a file name in the folder is one that a comparison makes."""
    fixed = {"caches", "compare.md", "compare.json", "film.mp4", "strip.jpg"}
    plots = {f"{plot}.png" for plot in ("cost", "stretch", "distribution", "motion", "passes")}
    return name in fixed | plots


class Ended(Protocol):
    """What every comparison has."""

    threads: int
    interrupted: bool


def make_film(found: Ended, shown: Sequence[Frames], out: Path, widest: int, watch: Watch) -> bool:
    """Make a film of caches side by side, if it is not interrupted.

    Args:
        found: what is told of an interruption.
        shown: the caches.
        out: the film.
        widest: the most that one of them is wide [pixels].
        watch: told of the frames.
    """
    side = min(widest, _LARGEST_FILM // math.ceil(math.sqrt(len(shown))))

    def tell(done: int, total: int) -> None:
        watch(out.name, done, total, "")

    try:
        render_film(shown, out, RenderOptions(color="strain", size=(side, side * 9 // 10), progress=tell))
    except KeyboardInterrupt:
        found.interrupted = True
    return not found.interrupted


def head(name: str, found: Ended) -> dict[str, Any]:
    """How the JSON of a comparison begins: its format, and where it was made."""
    return {
        "format": name,
        "version": _taut.__version__,
        "machine": str(this_machine()),
        "threads": found.threads,
        "interrupted": found.interrupted,
    }


def write_pages(folder: Path, page: str, document: dict[str, Any]) -> None:
    """Write the page and the figures of a comparison."""
    (folder / "compare.md").write_text(page, encoding="utf-8")
    text = json.dumps(document, indent=2, allow_nan=False)
    (folder / "compare.json").write_text(text + "\n", encoding="utf-8")


def to_json(found: Comparison, pictures: Sequence[Picture]) -> dict[str, Any]:
    """The comparison as plain values; what is not defined is null."""
    document = head(FORMAT, found) | {
        "scene": {
            "title": found.title,
            "vertices": found.vertices,
            "springs": found.springs,
            "strain_limit": found.limit,
            "fps": found.fps,
        },
        "rest_speed": found.body.rest_speed,
        "undefined": {"energy_kept": found.body.no_energy, "momentum_drift": found.body.no_momentum},
        "equal_stretch": {"target": found.target, "budget": found.budget if found.searched else None},
        "runs": [_run(found, run) for run in found.runs],
        "searches": [{**asdict(method), **_search(search)} for method, search in found.searches],
        "refused": [{**asdict(refusal.method), "reason": refusal.reason} for refusal in found.refused],
        "passes": [
            {
                **asdict(run.method),
                "over_before": one.over_before,
                "over_after": one.over_after,
                "pushed_over": float(one.pushed.mean()),
                "pushed_neighbours": one.pushed_neighbours,
            }
            for run, one in found.passes
        ],
        "pictures": [asdict(picture) for picture in pictures],
    }
    plain = finite(document)
    assert isinstance(plain, dict)
    return plain


def _run(found: Comparison, run: Run) -> dict[str, Any]:
    search = next((one for method, one in found.searches if method == run.method), None)
    settings = list(search.settings) if search and run.settings == "equal" else []
    return {
        **asdict(run.method),
        "settings": run.settings,
        "changed": settings,
        "cache": run.cache,
        "ended": run.ended,
        **asdict(run.figures),
    }


def _search(search: Search) -> dict[str, Any]:
    trials = [asdict(trial) for trial in search.trials]
    return {
        "dial": search.dial.name,
        "factor": search.factor,
        "why_not": search.why_not or None,
        "trials": trials,
    }


def finite(value: Any) -> Any:
    """JSON has no infinity: what is not finite becomes null."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def markdown(found: Comparison, pictures: Sequence[Picture], film: bool) -> str:
    """The comparison as a page."""
    lines = [f"# {found.title or 'Comparison'}: methods side by side", ""]
    lines += [f"{found.vertices} vertices, {found.springs} springs, {_limit(found)}.", ""]
    if found.interrupted:
        lines += ["Stopped before its end: not everything is here.", ""]
    lines += tables(found)
    for picture in pictures:
        lines += [f"![{picture.caption}]({picture.name})", "", f"*{picture.caption}.*", ""]
    if film:
        lines += ["[The film](film.mp4): all of them side by side.", ""]
    return "\n".join(lines)


def _limit(found: Comparison) -> str:
    return "no limit for some springs" if found.limit is None else f"limit {percent(found.limit)}"
