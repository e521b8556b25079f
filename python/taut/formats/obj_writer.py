"""Wavefront OBJ: a folder with one file a frame."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.formats.obj_bodies import BodyFiles
from taut.formats.writing import Places, write_folder
from taut.frames import Frames, Progress, links


def export_obj(frames: Frames, out: Path, overwrite: bool, progress: Progress | None) -> None:
    """Write one OBJ a frame into the folder ``out``: vertices in their order, faces and links counted from 1.

    Positions have nine significant digits, with which a float32 is read back as it was, and more far from the
    origin. Springs that no
    triangle shows (nets, chains) become line elements. Bodies have files of their own:
    :class:`taut.formats.obj_bodies.BodyFiles`.

    Raises:
        ExportError: see :func:`taut.formats.export`.
    """
    title = " ".join(frames.title.split())
    bodies = BodyFiles(frames)
    topology = _elements("f", frames.faces) + _elements("l", frames.springs[links(frames)])

    def write(stem: Path, frame: int, positions: Places) -> None:
        head = f"# {title}: frame {frame}, t = {frames.time[frame]:.6g} s\n"
        line = "v %.9g %.9g %.9g\n" if positions.dtype == np.float32 else "v %.15g %.15g %.15g\n"
        vertices = (line * len(positions)) % tuple(positions.ravel().tolist())
        with stem.with_suffix(".obj").open("w", encoding="utf-8", newline="\n") as file:
            file.write(head + vertices + topology)
        bodies.write(stem, frame)

    write_folder(frames, out, write, overwrite, progress)


def _elements(keyword: str, indices: NDArray[np.int32]) -> str:
    rows: list[list[int]] = (indices + 1).tolist()
    return "".join(f"{keyword} {' '.join(map(str, row))}\n" for row in rows)
