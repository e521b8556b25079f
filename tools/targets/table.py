"""Rows of the table of targets, and how much is measured for them."""

from dataclasses import dataclass
from pathlib import Path

from taut.bench import Window

ROOT = Path(__file__).resolve().parent.parent.parent


@dataclass(frozen=True, slots=True)
class Row:
    """A target and what was reached."""

    target: str
    """What was asked for."""
    reached: str
    """What was measured, with where."""
    met: bool
    """Whether all that was measured meets the target."""
    threads: str = "1"
    """Worker threads."""
    spread: str = "–"
    """Of how much the figures are the middle or the worst; of times and of what is chaotic the spread."""
    detail: str = ""
    """Everything that was measured, a table in Markdown; nothing where `reached` says it all."""


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is measured."""

    divide: int = 1
    """Cells along a side are divided by this [1]."""
    frames: int = 300
    """Frames that are timed, 5 s of them [1]."""
    seconds: float = 60.0
    """No frame is begun after this much time in one measurement [s]."""
    runs: int = 5
    """How often what depends on time or chance is measured [1]."""
    sizes: tuple[int, ...] = ()
    """Vertices along a side of the meshes of the rows about their cost; those of the rows when left out."""
    steps: float = 1.0
    """Steps of each case of the bound are multiplied by this [1]."""
    case: str = ""
    """Of rows about contact only cases that have this in their name."""

    @property
    def whole(self) -> bool:
        """Whether sizes and durations are those of the rows."""
        return self.divide == 1

    def length(self, seconds: float) -> int:
        """Frames at 60 a second [1]."""
        return max(4, round(60 * seconds)) if self.whole else self.frames

    def cells(self, cells: int) -> int:
        """Cells along a side [1]."""
        return max(1, cells // self.divide)

    def vertices(self, across: int) -> int:
        """Vertices of a square sheet that has so many along a side [1]."""
        return max(8, across // self.divide) ** 2

    def garment(self, vertices: int) -> int:
        """Vertices of a garment [1]."""
        return max(300, vertices // self.divide**2)

    @property
    def window(self) -> Window:
        """What is timed where nothing else limits it."""
        return Window(self.frames, self.seconds, self.runs)


FULL = Effort()
QUICK = Effort(divide=16, frames=5, seconds=1.0, runs=1, steps=0.05)
