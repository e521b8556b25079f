"""What a user may choose about a picture."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

from matplotlib.colors import is_color_like

from taut.frames import Progress
from taut.output import OutputError

Color = Literal["strain", "fabric"]


class RenderError(OutputError):
    """A picture cannot be made. The text names what is wrong and what is allowed."""


@dataclass(frozen=True)
class RenderOptions:
    """How a still or a film looks."""

    frame: int | None = None
    """Frame of a still, counted from 0, or from the end if negative; ``None``: the last. Films show all."""
    color: Color = "fabric"
    """``fabric``: plain two-sided cloth; ``strain``: a heat map of the stretch."""
    eye: tuple[float, float, float] | None = None
    """Where the camera stands in the world [m]; ``None``: where it has all motion in view."""
    target: tuple[float, float, float] | None = None
    """What the camera looks at [m]; ``None``: the middle of all motion."""
    fps: float | None = None
    """Frames of a film per second [1/s]; ``None``: those of the scene."""
    background: str | None = None
    """A colour as ``white`` or ``#102030``, without a horizon and a ground; ``None``: the sky above them."""
    caption: bool = True
    """Whether title, time and worst stretch stand above each panel."""
    size: tuple[int, int] = (800, 720)
    """Width and height of each cache's panel [pixels]."""
    columns: int | None = None
    """Panels in a row; ``None``: three panels or less in one row, more in a square."""
    strain_top: float | None = None
    """Stretch at the top of the heat map (0.1 is 10 %); ``None``: twice the strain limit."""
    overwrite: bool = False
    """Replace an existing picture."""
    progress: Progress | None = None
    """Told how many frames of a film are done and how many there are."""

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            RenderError: a value is out of range.
        """
        if self.color not in get_args(Color):
            raise RenderError(f"color = {self.color!r}: must be one of {', '.join(get_args(Color))}")
        for name in ("eye", "target"):
            place = getattr(self, name)
            if place is not None and (len(place) != 3 or not all(map(math.isfinite, place))):
                raise RenderError(f"{name} = {place}: must be three finite numbers [m]")
        if self.eye is not None and self.eye == self.target:
            raise RenderError(f"target = {self.target}: the camera stands there; name another place")
        if self.fps is not None and not 0.1 <= self.fps <= 1000:
            raise RenderError(f"fps = {self.fps}: must be 0.1 to 1000 frames per second")
        if self.background is not None and not is_color_like(self.background):
            raise RenderError(f"background = {self.background!r}: must be a colour as white or #102030")
        if not all(64 <= side <= 4096 for side in self.size):
            raise RenderError(f"size = {self.size}: a panel must be 64 to 4096 pixels wide and high")
        if self.columns is not None and self.columns < 1:
            raise RenderError(f"columns = {self.columns}: must be 1 or more")
        if self.strain_top is not None and not 0 < self.strain_top < float("inf"):
            raise RenderError(f"strain_top = {self.strain_top}: must be above 0; 0.1 is 10 %")
