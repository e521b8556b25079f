"""What every exporter needs: checked frames, file names, the folder of one file a frame."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.frames import Exact, Frames, Progress
from taut.output import OutputError, whole_folder


class ExportError(OutputError):
    """Frames cannot be exported. The text names the file or frame, the reason and a remedy."""


Places = NDArray[np.float32] | NDArray[np.float64]
ROUNDING = 1e-6
"""Part of the size of all cloth by which single precision may round places [1]."""


def checked_frames(frames: Frames, progress: Progress | None) -> Iterator[tuple[int, Places]]:
    """Yield every frame's number and positions [m], little-endian, shape (vertices, 3).

    They are float32, and float64 where that would round places of cloth far from the origin.

    Raises:
        ExportError: a position is not finite; there are no frames.
    """
    if frames.frames == 0:
        raise ExportError(f"{frames.title!r} has no frames to export: run the simulation first")
    for frame in range(frames.frames):
        positions = _places(frames, frame)
        bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
        if bad.size:
            where = f"frame {frame}: vertex {bad[0]} is at {positions[bad[0]].tolist()}"
            raise ExportError(f"{where}, not a place in space; export a cache that ends before that frame")
        yield frame, positions
        if progress is not None:
            progress(frame + 1, frames.frames)


def _places(frames: Frames, frame: int) -> Places:
    single = np.ascontiguousarray(frames.positions(frame), dtype="<f4")
    if not isinstance(frames, Exact):
        return single
    exact = np.ascontiguousarray(frames.exact_positions(frame), dtype="<f8")
    # What is not finite compares as false, and is refused.
    rounded = len(exact) > 0 and np.abs(single - exact).max() > ROUNDING * np.ptp(exact, axis=0).max()
    return exact if rounded else single


def write_folder(
    frames: Frames,
    out: Path,
    write: Callable[[Path, int, Places], None],
    overwrite: bool,
    progress: Progress | None,
) -> None:
    """Fill the folder ``out`` with one file a frame: ``frame_0000`` .. and the suffix after ``write``.

    Args:
        frames: what to export.
        out: the folder to make.
        write: writes one frame to the path given, less its suffix.
        overwrite: replace a folder of an earlier export.
        progress: told how far it is.

    Raises:
        ExportError: see :func:`checked_frames` and :func:`taut.output.whole_folder`.
    """
    digits = max(4, len(str(frames.frames - 1)))
    ours = re.compile(r"frame_\d{4,}\.(obj|ply)|bodies(_\d{4,})?\.obj").fullmatch
    with whole_folder(out, overwrite, lambda name: ours(name) is not None, ExportError) as folder:
        for frame, positions in checked_frames(frames, progress):
            write(folder / f"frame_{frame:0{digits}d}", frame, positions)
