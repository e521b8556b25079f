"""Films as files."""

from pathlib import Path
from types import TracebackType

import imageio_ffmpeg  # type: ignore[import-untyped]
from PIL import Image


class EncoderError(Exception):
    """The encoder stopped before the end."""


class Encoder:
    """Writes pictures into a film, as H.264; use it in a ``with`` statement."""

    def __init__(self, out: Path, size: tuple[int, int], rate: float) -> None:
        """Start a film.

        Args:
            out: the file; its extension says what holds the film.
            size: width and height of the pictures [pixels], both even.
            rate: pictures per second [1/s].
        """
        self._frames = imageio_ffmpeg.write_frames(
            out,
            size,
            fps=rate,
            quality=6.5,
            macro_block_size=2,
            ffmpeg_log_level="error",
            # As small and as good as with slower ones, on pictures with so much that is smooth and still.
            output_params=["-preset", "veryfast", "-movflags", "+faststart"],
        )
        self._frames.send(None)

    def __enter__(self) -> "Encoder":
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the film."""
        self._frames.close()

    def write(self, picture: Image.Image) -> None:
        """Append a picture.

        Raises:
            EncoderError: the encoder has stopped.
        """
        try:
            self._frames.send(picture.tobytes())
        except OSError as error:
            raise EncoderError from error


def check_film(film: Path, count: int) -> None:
    """Make sure that a film has so many frames: the encoder does not say how it ended; what it wrote does.

    Raises:
        EncoderError: it has others, or is none.
    """
    try:
        written, _ = imageio_ffmpeg.count_frames_and_secs(film)
    except RuntimeError as error:
        raise EncoderError from error
    if written != count:
        raise EncoderError
