"""From nothing to a folder with the page, its pictures and its numbers."""

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

from taut.bench import this_machine
from taut.figures.drops import figures_6_and_7, figures_8_and_9
from taut.figures.flags import figure_4, figure_5
from taut.figures.page import page
from taut.figures.scenes import QUICK, Size
from taut.figures.section import Section
from taut.figures.strip import figure_2
from taut.figures.workshop import Watch, Workshop
from taut.output import whole_folder

FIGURES = (figure_2, figure_4, figure_5, figures_6_and_7, figures_8_and_9)
"""In the order of the paper."""


@dataclass(frozen=True, slots=True)
class Options:
    """What a user may choose."""

    quick: bool = False
    """Tiny cloths and pictures: everything is made, nothing is worth reading."""
    threads: int | None = None
    """Worker threads [1]; all cores when left out."""
    overwrite: bool = False
    """Replace what an earlier call has made."""
    watch: Watch = lambda what, done, total, note: None
    """Told of the progress; may raise to stop, and nothing is left behind."""


def make_figures(out: str | Path, options: Options | None = None) -> list[Section]:
    """Make the figures of the paper and the page that shows them; it appears whole or not at all.

    Args:
        out: the folder to make: `index.html`, `figures.json` and the folder `pictures`.
        options: how.

    Raises:
        OutputError: `out` exists or cannot be written, or pictures cannot be made here.
    """
    options = options or Options()
    ours = {"index.html", "figures.json", "pictures"}
    with (
        whole_folder(Path(out), options.overwrite, ours.__contains__) as folder,
        tempfile.TemporaryDirectory() as caches,
    ):
        (folder / "pictures").mkdir()
        size = QUICK if options.quick else Size()
        scale = 0.2 if options.quick else 1.0
        shop = Workshop(folder / "pictures", Path(caches), size, scale, options.threads, options.watch)
        sections = [make(shop) for make in FIGURES]
        machine = this_machine()
        quick = ", in the quick way that is for tests only" if options.quick else ""
        made = f"Made by taut {machine.version} on {machine}{quick}."
        (folder / "index.html").write_text(page(sections, made), encoding="utf-8")
        numbers = {section.number: {"verdict": section.verdict, **section.numbers} for section in sections}
        (folder / "figures.json").write_text(json.dumps(numbers, indent=2) + "\n", encoding="utf-8")
    return sections
