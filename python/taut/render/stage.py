"""All panels side by side, the camera that they share, and the finished picture."""

import ctypes
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from types import TracebackType

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from taut.frames import Frames
from taut.render.caption import Caption, Letterer
from taut.render.framing import frame_motion, looking
from taut.render.options import RenderError, RenderOptions
from taut.render.panel import Cast, Look, Panel
from taut.render.strain import strain_scale

_LARGEST_WINDOW = 16384  # pixels a side, of OpenGL
_SAMPLES = 8  # of each rendered pixel


@dataclass(frozen=True)
class Quality:
    """How finely pictures are drawn."""

    oversampling: float
    """Rendered pixels for each pixel of the picture, along each side [1]."""
    samples: int
    """Of each rendered pixel [1]; 0: one. In software they cost more than as many rendered pixels."""


STILL, FILM = Quality(2.0, _SAMPLES), Quality(1.5, 0)


@dataclass(frozen=True)
class Drawing:
    """A moment as far as OpenGL draws it."""

    pixels: NDArray[np.uint8]
    """What moves, from the bottom up: red, green, blue and how much of the pixel it covers, which the colours
    are multiplied by; shape (height, width, 4)."""
    casts: list[Cast]
    """What throws shadows, for each panel."""
    captions: list[Caption | None]


class Stage:
    """Renders any moment of several simulations; use it in a ``with`` statement.

    Sky and ground are drawn once. Each frame has what moves drawn alone, and is put together from both.
    """

    def __init__(self, panels: Sequence[Frames], options: RenderOptions, quality: Quality) -> None:
        """Set everything up.

        Args:
            panels: the simulations, each with a frame or more.
            options: how it looks.
            quality: of what moves; what stands still always has samples.

        Raises:
            RenderError: the picture is too large, or this machine has no OpenGL, in software or otherwise.
        """
        self._panels = panels
        width, height = options.size
        columns = options.columns or (len(panels) if len(panels) <= 3 else math.ceil(math.sqrt(len(panels))))
        rows = math.ceil(len(panels) / columns)
        self._scale = strain_scale(panels, options.strain_top)
        framing = looking(frame_motion(panels, width / height), options.eye, options.target)
        pixels = quality.oversampling * height / 720
        look = Look(options.color, self._scale, framing, options.size, pixels, options.background)
        self._has_captions = options.caption
        self._whole = columns * width, rows * height
        self._plotter = open_plotter((rows, columns), _drawn_size(self._whole, quality.oversampling))
        places = [divmod(index, columns) for index in range(len(panels))]
        self._corners = [(column * width, row * height) for row, column in places]
        self._actors = []
        for place, frames in zip(places, panels, strict=True):
            self._plotter.subplot(*place)
            self._actors.append(Panel(self._plotter, frames, look))
        scale = self._scale if options.color == "strain" else None
        self._letterer = Letterer(options.size, self._corners, scale)
        assert self._plotter.render_window is not None  # It is open.
        self._window = self._plotter.render_window
        # No screenshot by PyVista: after one it draws the whole window for each actor that is added.
        self._window.Render()
        behind = Image.fromarray(np.ascontiguousarray(self._pixels(front=True)[::-1, :, :3]))
        self._behind = self._letterer.mount(behind.resize(self._whole, Image.Resampling.HAMMING))
        self._window.SetMultiSamples(quality.samples)
        for place, panel in zip(places, self._actors, strict=True):
            self._plotter.subplot(*place)
            panel.enter(self._plotter)

    def __enter__(self) -> "Stage":
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Free the window and its memory."""
        self._plotter.close()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures [pixels]; both are even."""
        return self._letterer.size

    def picture(self, frames: Sequence[int]) -> Image.Image:
        """Render one frame of each panel."""
        return self.finish(self.draw(frames))

    def draw(self, frames: Sequence[int]) -> Drawing:
        """Draw what moves in one frame of each panel."""
        casts = [panel.show(frame) for panel, frame in zip(self._actors, frames, strict=True)]
        self._window.Render()
        # The back: VTK's front has its samples mixed as if they were opaque.
        drawn = self._pixels(front=False)
        shown = zip(self._panels, frames, strict=True)
        captions = [self._caption(*one) if self._has_captions else None for one in shown]
        return Drawing(drawn, casts, captions)

    def _pixels(self, front: bool) -> NDArray[np.uint8]:
        """What was rendered, from the bottom up, shape (height, width, 4)."""
        width, height = self._window.GetSize()
        pixels = vtkUnsignedCharArray()
        self._window.GetRGBACharPixelData(0, 0, width - 1, height - 1, int(front), pixels)
        found: NDArray[np.uint8] = vtk_to_numpy(pixels).reshape(height, width, 4)  # type: ignore[no-untyped-call]
        return found

    def finish(self, drawing: Drawing) -> Image.Image:
        """Make a picture of a drawing. It may be called in another thread than the rest."""
        picture = self._behind.copy()
        for panel, corner, cast in zip(self._actors, self._corners, drawing.casts, strict=True):
            panel.lay_shadow(picture, corner, cast)
        _cover(picture, self._whole, drawing.pixels)
        self._letterer.write(picture, drawing.captions)
        return picture

    def _caption(self, panel: Frames, frame: int) -> Caption:
        stretch = np.nan_to_num(panel.stretch(frame), nan=np.inf, posinf=np.inf)
        worst = float(stretch.max()) if stretch.size else None
        over = worst is not None and self._scale.is_over(worst)
        return Caption(panel.title, float(panel.time[frame]), worst, over)


def _drawn_size(size: tuple[int, int], oversampling: float) -> tuple[int, int]:
    """Rendered pixels, across and along, for a picture of some size."""
    drawn = math.ceil(size[0] * oversampling), math.ceil(size[1] * oversampling)
    if max(drawn) > _LARGEST_WINDOW:
        most = int(_LARGEST_WINDOW / oversampling)
        needed = f"{size[0]} x {size[1]} pixels"
        raise RenderError(f"a picture of {needed}: at most {most} a side; choose a smaller size")
    return drawn


def _cover(picture: Image.Image, size: tuple[int, int], pixels: NDArray[np.uint8]) -> None:
    """Lay a drawing over the upper left part of a picture, of some size: what it does not cover stays."""
    height, width, _ = pixels.shape
    # To Pillow just four numbers: it would weigh colours with what they cover, which is done already.
    drawn = Image.frombuffer("RGBX", (width, height), pixels, "raw", "RGBX", 0, 1)
    box = drawn.getbbox()
    if box is None:
        return
    across, along = width / size[0], height / size[1]
    left, right = int(box[0] / across), math.ceil(box[2] / across)
    low, high = int(box[1] / along), math.ceil(box[3] / along)
    part = left * across, low * along, right * across, high * along
    small = drawn.resize((right - left, high - low), Image.Resampling.HAMMING, part)
    cover = Image.frombuffer("RGBa", small.size, small.tobytes(), "raw", "RGBa", 0, -1).convert("RGBA")
    picture.paste(cover, (left, size[1] - high), cover)


def open_plotter(shape: tuple[int, int], size: tuple[int, int]) -> pv.Plotter:
    """Open an invisible window.

    Args:
        shape: rows and columns of panels.
        size: width and height of the whole [pixels].

    Raises:
        RenderError: this machine has no OpenGL, in software or otherwise.
    """
    with pv.vtk_verbosity("error"):  # It warns where there is no display; we need none.
        plotter = pv.Plotter(
            off_screen=True, shape=shape, window_size=list(size), border=False, lighting="none"
        )
    # VTK's last resort needs a library that it does not bring; without it the process would die.
    if type(plotter.render_window).__name__ == "vtkOSOpenGLRenderWindow" and not _has_osmesa():
        plotter.close()
        raise RenderError("no OpenGL was found to render with: install libegl1 and libgl1-mesa-dri, or alike")
    plotter.enable_anti_aliasing("msaa", multi_samples=_SAMPLES)
    return plotter


def _has_osmesa() -> bool:
    for name in ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"):
        with suppress(OSError):
            ctypes.CDLL(name)
            return True
    return False
