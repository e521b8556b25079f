"""Stills and films of one or more simulations."""

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np

from taut.frames import Frames, frame_rate
from taut.output import whole_file
from taut.render.encoder import Encoder, EncoderError, check_film
from taut.render.options import RenderError, RenderOptions
from taut.render.stage import FILM, STILL, Stage

STILL_EXTENSIONS = (".png", ".jpg", ".jpeg")
"""What :func:`render_still` can write."""

FILM_EXTENSIONS = (".mp4", ".mov")
"""What :func:`render_film` can write, as H.264."""


def render_still(panels: Sequence[Frames], out: str | Path, options: RenderOptions | None = None) -> None:
    """Render one frame of one or more simulations side by side.

    Shorter simulations show their last frame.

    Args:
        panels: the simulations, each with a frame or more.
        out: the picture to make, with one of the :data:`STILL_EXTENSIONS`.
        options: how it looks.

    Raises:
        RenderError: the frame or the extension is out of range, there is no frame, or ``out`` exists or
            cannot be written; then nothing is left behind.
    """
    out, options = Path(out), options or RenderOptions()
    _check(panels, out, STILL_EXTENSIONS)
    moments = _moments(panels, frame_rate(panels[0]))
    frame = len(moments) - 1 if options.frame is None else options.frame
    if not -len(moments) <= frame < len(moments):
        raise RenderError(f"frame {frame} is out of range: there are {len(moments)}, 0 to {len(moments) - 1}")
    with whole_file(out, options.overwrite, RenderError) as part, Stage(panels, options, STILL) as stage:
        stage.picture(moments[frame]).save(part, quality=93)


def render_film(panels: Sequence[Frames], out: str | Path, options: RenderOptions | None = None) -> None:
    """Render one or more simulations side by side, at the frame rate of the first or another one.

    Shorter simulations hold their last frame.

    Args:
        panels: the simulations, each with a frame or more.
        out: the film to make, with one of the :data:`FILM_EXTENSIONS`.
        options: how it looks.

    Raises:
        RenderError: see :func:`render_still`.
    """
    out, options = Path(out), options or RenderOptions()
    _check(panels, out, FILM_EXTENSIONS)
    with whole_file(out, options.overwrite, RenderError) as part, Stage(panels, options, FILM) as stage:
        try:
            _encode(stage, part, panels, options)
        except EncoderError as error:
            reason = "the film encoder stopped before the end"
            raise RenderError(f"{out} cannot be written: {reason}; is the disk full?") from error


def _encode(stage: Stage, part: Path, panels: Sequence[Frames], options: RenderOptions) -> None:
    rate = frame_rate(panels[0]) if options.fps is None else options.fps
    moments = _moments(panels, rate)

    def wait(written: Future[None], done: int) -> None:
        written.result()
        if options.progress is not None:
            options.progress(done, len(moments))

    # A frame is put together and encoded while the next one is drawn.
    with Encoder(part, stage.size, rate) as encoder, ThreadPoolExecutor(1) as worker:
        written: Future[None] | None = None
        for done, moment in enumerate(moments):
            drawing = stage.draw(moment)
            if written is not None:
                wait(written, done)
            written = worker.submit(lambda drawing: encoder.write(stage.finish(drawing)), drawing)
        if written is not None:
            wait(written, len(moments))
    check_film(part, len(moments))


def _check(panels: Sequence[Frames], out: Path, extensions: tuple[str, ...]) -> None:
    if out.suffix.lower() not in extensions:
        still, film = ", ".join(STILL_EXTENSIONS), ", ".join(FILM_EXTENSIONS)
        raise RenderError(f"{out}: cannot be written; a still ends in {still}, a film in {film}")
    if not panels:
        raise RenderError("there is nothing to render: name a cache or more")
    for panel in panels:
        if panel.frames == 0:
            raise RenderError(f"{panel.title!r} has no frames to render: run the simulation first")


def _moments(panels: Sequence[Frames], rate: float) -> list[tuple[int, ...]]:
    """For each frame of the film, which frame each panel shows: the last one not later than that time."""
    count = max(1 + round(float(panel.time[-1]) * rate) for panel in panels)
    times = np.arange(count) / rate + 0.01 / rate
    shown = [np.searchsorted(panel.time, times, side="right") - 1 for panel in panels]
    return [tuple(int(frame) for frame in frames) for frames in np.maximum(shown, 0).T]
