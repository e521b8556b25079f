"""Where figures are made: simulations into caches that do not stay, pictures into the folder that does."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from taut.cache import Cache
from taut.figures.scenes import Document, Size
from taut.figures.section import Picture
from taut.run import Progress, record
from taut.scene import Scene
from taut.simulation import Simulation

Watch = Callable[[str, int, int, str], object]
"""Told what is being made, how much of it is done, how much there is, and a note."""

Draw = Callable[[Figure, "Ink"], None]
"""Draws a plot."""


@dataclass(frozen=True, slots=True)
class Ink:
    """Colours of a plot, for a light or a dark page."""

    text: str
    faint: str
    bare: str
    """Of what has no constraint."""
    limited: str
    """Of what has it."""


LIGHT = Ink("#1f2933", "#d5dce2", "#c2182b", "#1d5c9c")
DARK = Ink("#e3e8ed", "#3a444e", "#ff7b72", "#6cb2f2")


@dataclass(frozen=True, slots=True)
class Workshop:
    """What every figure needs."""

    pictures: Path
    """Folder of the pictures."""
    caches: Path
    """Folder of the simulations."""
    size: Size
    panel: float
    """Pixels of a panel over those of the page [1]."""
    threads: int | None
    """Worker threads [1]; all cores when left out."""
    watch: Watch

    def simulate(self, document: Document) -> Cache:
        """Simulate a scene to its end.

        Raises:
            CacheWriteError: the disk is full, say.
        """
        simulation = Simulation(Scene(document), self.threads)
        out = self.caches / f"{len(list(self.caches.iterdir()))}.zarr"

        def tell(now: Progress) -> None:
            note = f"worst stretch {100 * now.worst_stretch:.4g} %"
            self.watch(simulation.scene.title, now.frame + 1, now.frames, note)

        return Cache.open(record(simulation, out, on_frame=tell).path)

    def panels(self, width: int, height: int) -> tuple[int, int]:
        """Width and height of a panel [pixels]."""
        return max(64, round(width * self.panel)), max(64, round(height * self.panel))

    def plot(self, name: str, caption: str, size: tuple[float, float], draw: Draw) -> Picture:
        """Draw a plot twice, for light and for dark pages.

        Args:
            name: of the file, without its suffix.
            caption: what is seen.
            size: width and height [inches].
            draw: draws it.
        """
        for suffix, ink in (("", LIGHT), ("-dark", DARK)):
            look = {
                "font.size": 10,
                "text.color": ink.text,
                "axes.labelcolor": ink.text,
                "axes.edgecolor": ink.faint,
                "axes.facecolor": "none",
                "axes.grid": True,
                "axes.spines.top": False,
                "axes.spines.right": False,
                "grid.color": ink.faint,
                "grid.linewidth": 0.6,
                "xtick.color": ink.text,
                "ytick.color": ink.text,
                "legend.frameon": False,
                "figure.facecolor": "none",
                "figure.constrained_layout.use": True,
                "svg.hashsalt": name,
            }
            with matplotlib.rc_context(look):  # type: ignore[arg-type]
                figure = Figure(figsize=size)
                draw(figure, ink)
                FigureCanvasSVG(figure)
                figure.savefig(self.pictures / f"{name}{suffix}.svg", metadata={"Date": None})
        return Picture(f"{name}.svg", caption, f"{name}-dark.svg")
