"""All panels side by side, the camera that they share, and the finished picture."""

import ctypes
import math
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType

import numpy as np
import pyvista as pv
from PIL import Image

from taut.frames import Frames
from taut.render.caption import Caption, Letterer
from taut.render.framing import frame_motion, looking
from taut.render.options import RenderError, RenderOptions
from taut.render.panel import Look, Panel
from taut.render.strain import strain_scale

_LARGEST_WINDOW = 16384  # pixels a side, of OpenGL


class Stage:
    """Renders any moment of several simulations; use it in a ``with`` statement."""

    def __init__(self, panels: Sequence[Frames], options: RenderOptions, oversampling: int) -> None:
        """Set everything up.

        Args:
            panels: the simulations, each with a frame or more.
            options: how it looks.
            oversampling: rendered pixels for each pixel of the picture, along each side.

        Raises:
            RenderError: the picture is too large, or this machine has no OpenGL, in software or otherwise.
        """
        self._panels, self._oversampling = panels, oversampling
        width, height = options.size
        columns = options.columns or (len(panels) if len(panels) <= 3 else math.ceil(math.sqrt(len(panels))))
        rows = math.ceil(len(panels) / columns)
        self._scale = strain_scale(panels, options.strain_top)
        framing = looking(frame_motion(panels, width / height), options.eye, options.target)
        look = Look(options.color, self._scale, framing, oversampling * height / 720, options.background)
        self._has_captions = options.caption
        window = columns * width * oversampling, rows * height * oversampling
        if max(window) > _LARGEST_WINDOW:
            most = _LARGEST_WINDOW // oversampling
            needed = f"{columns * width} x {rows * height} pixels"
            raise RenderError(f"a picture of {needed}: at most {most} a side; choose a smaller size")
        self._plotter = open_plotter((rows, columns), window)
        self._actors = []
        places = []
        for index, frames in enumerate(panels):
            row, column = divmod(index, columns)
            self._plotter.subplot(row, column)
            self._actors.append(Panel(self._plotter, frames, look))
            places.append((column * width, row * height))
        scale = self._scale if options.color == "strain" else None
        self._letterer = Letterer(options.size, places, scale)

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
        for panel, frame in zip(self._actors, frames, strict=True):
            panel.show(frame)
        self._plotter.render()
        image = np.asarray(self._plotter.screenshot(return_img=True), dtype=np.uint8)
        if self._oversampling > 1:
            image = np.asarray(Image.fromarray(image).reduce(self._oversampling))
        shown = zip(self._panels, frames, strict=True)
        captions = [self._caption(*one) if self._has_captions else None for one in shown]
        return self._letterer.finish(image, captions)

    def _caption(self, panel: Frames, frame: int) -> Caption:
        stretch = np.nan_to_num(panel.stretch(frame), nan=np.inf, posinf=np.inf)
        worst = float(stretch.max()) if stretch.size else None
        over = worst is not None and self._scale.is_over(worst)
        return Caption(panel.title, float(panel.time[frame]), worst, over)


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
    plotter.enable_anti_aliasing("msaa", multi_samples=8)
    return plotter


def _has_osmesa() -> bool:
    for name in ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"):
        with suppress(OSError):
            ctypes.CDLL(name)
            return True
    return False
