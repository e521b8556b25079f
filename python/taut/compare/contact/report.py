"""A comparison of contact as a folder: a page in Markdown, the figures in JSON, plots, strips and films."""

import re
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from taut.cache import Cache
from taut.compare.contact.comparing import CACHES, Found, SceneFound
from taut.compare.contact.plots import draw_plot
from taut.compare.contact.running import Run
from taut.compare.contact.table import tables
from taut.compare.report import Picture, finite, head, make_film, write_pages
from taut.compare.running import Watch
from taut.render import RenderOptions, render_strip

FORMAT = "taut-contact-comparison/1"
"""Of the JSON file; the number changes when a name in it changes its meaning or goes."""

_MOMENTS = (0.1, 0.3, 0.5, 0.75, 1.0)
"""Of a strip, as shares of the duration."""
_PANEL = (300, 250)
_MADE = re.compile(r"contact-[\w-]+\.(png|jpg|mp4)")


def is_ours(name: str) -> bool:
    """Whether a file name in the folder is one that a comparison of contact makes."""
    return name in {CACHES, "compare.md", "compare.json"} or bool(_MADE.fullmatch(name))


def write_report(found: Found, folder: Path, film: bool, watch: Watch) -> None:
    """Write everything that is made of the runs in a folder beside them.

    Args:
        found: what was found.
        folder: where the caches are, and the report goes.
        film: whether to make films; a comparison that was interrupted gets none.
        watch: told of the frames of the films.

    Raises:
        RenderError: pictures cannot be made here.
        OSError: the folder cannot be written.
    """
    pictures: list[Picture] = []
    films: list[Picture] = []
    for scene in found.scenes:
        plot = Picture(f"contact-{scene.name}.png", f"{scene.title}: distance, stretch, crossings, energy")
        draw_plot(scene, folder / plot.name)
        shown = [Cache.open(folder / run.cache) for run in scene.runs]
        end = max(float(cache.time[-1]) for cache in shown)
        times = sorted({round(share * end, 4) for share in _MOMENTS})
        strip = Picture(f"contact-{scene.name}-strip.jpg", f"{scene.title}: the same moments of each method")
        render_strip(shown, times, folder / strip.name, RenderOptions(color="strain", size=_PANEL))
        pictures += [plot, strip]
        name = f"contact-{scene.name}.mp4"
        if film and not found.interrupted and make_film(found, shown, folder / name, 600, watch):
            films.append(Picture(name, f"{scene.title}: all of them side by side"))
    page = markdown(found, pictures, films)
    write_pages(folder, page, to_json(found, [*pictures, *films]))


def to_json(found: Found, pictures: Sequence[Picture]) -> dict[str, Any]:
    """The comparison as plain values; what is not defined is null."""
    document = head(FORMAT, found) | {
        "scenes": [_scene(scene) for scene in found.scenes],
        "pictures": [asdict(picture) for picture in pictures],
    }
    plain = finite(document)
    assert isinstance(plain, dict)
    return plain


def _scene(scene: SceneFound) -> dict[str, Any]:
    return {
        "name": scene.name,
        "title": scene.title,
        "vertices": scene.vertices,
        "strain_limit": scene.limit,
        "no_energy": scene.no_energy,
        "runs": [_run(run) for run in scene.runs],
        "refused": [{"method": method, "reason": reason} for method, reason in scene.refused],
    }


def _run(run: Run) -> dict[str, Any]:
    moments = [asdict(moment) for moment in run.moments]
    return {
        "method": run.method,
        "cache": run.cache,
        "ended": run.ended,
        **asdict(run.figures),
        "moments": {name: [moment[name] for moment in moments] for name in moments[0]},
    }


def markdown(found: Found, pictures: Sequence[Picture], films: Sequence[Picture]) -> str:
    """The comparison as a page."""
    lines = ["# Ways to handle contact side by side", ""]
    if found.interrupted:
        lines += ["Stopped before its end: not everything is here.", ""]
    lines += tables(found)
    for picture in pictures:
        lines += [f"![{picture.caption}]({picture.name})", "", f"*{picture.caption}.*", ""]
    for film in films:
        lines += [f"[{film.caption}]({film.name}).", ""]
    return "\n".join(lines)
