"""Wavefront OBJ: a folder with one file a frame."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.formats.obj_bodies import BodyFiles
from taut.formats.obj_likeness import Likeness
from taut.formats.writing import ExportError, Places, write_folder
from taut.frames import Frames, Progress, links


def export_obj(
    frames: Frames,
    out: Path,
    overwrite: bool,
    progress: Progress | None,
    like: Mapping[str, Path] | None = None,
) -> None:
    """Write one OBJ a frame into the folder ``out``: vertices in their order, faces and links counted from 1.

    Positions have nine significant digits, with which a float32 is read back as it was, and more far from the
    origin. Springs that no
    triangle shows (nets, chains) become line elements. Bodies have files of their own:
    :class:`taut.formats.obj_bodies.BodyFiles`. Cloths in `like` have the texture coordinates, groups,
    materials and faces of those files, and their normals where the cloth is.

    Raises:
        ExportError: see :func:`taut.formats.export`.
    """
    title = " ".join(frames.title.split())
    bodies = BodyFiles(frames)
    own = _likenesses(frames, like or {})
    others = np.ones(len(frames.faces), np.bool_)
    for part, _ in own:
        others &= (frames.faces[:, 0] < part.start) | (frames.faces[:, 0] >= part.stop)
    topology = _elements("f", frames.faces[others]) + _elements("l", frames.springs[links(frames)])
    topology += "".join(likeness.elements for _, likeness in own)
    texture = "".join(likeness.texture for _, likeness in own)

    def write(stem: Path, frame: int, positions: Places) -> None:
        head = f"# {title}: frame {frame}, t = {frames.time[frame]:.6g} s\n"
        line = "v %.9g %.9g %.9g\n" if positions.dtype == np.float32 else "v %.15g %.15g %.15g\n"
        vertices = (line * len(positions)) % tuple(positions.ravel().tolist())
        with stem.with_suffix(".obj").open("w", encoding="utf-8", newline="\n") as file:
            file.write(head + vertices + texture)
            for part, likeness in own:
                normals = likeness.normals(positions[part])
                file.write(("vn %.6g %.6g %.6g\n" * len(normals)) % tuple(normals.ravel().tolist()))
            file.write(topology)
        bodies.write(stem, frame)

    write_folder(frames, out, write, overwrite, progress)


def _likenesses(frames: Frames, like: Mapping[str, Path]) -> list[tuple[slice, Likeness]]:
    """The vertices of each cloth that has a file of its own, and what is in that, in the order of cloths."""
    cloths = getattr(frames, "attributes", {}).get("cloths", [])
    names = [cloth["name"] for cloth in cloths]
    for name in like:
        if name not in names:
            raise ExportError(f"like = {name!r}: there is no such cloth; there are {', '.join(names)}")
    found: list[tuple[slice, Likeness]] = []
    texture = normals = 0
    for cloth in cloths:
        if (path := like.get(cloth["name"])) is not None:
            first, count = cloth["first_vertex"], cloth["vertices"]
            likeness = Likeness(path, count, (first, texture, normals))
            found.append((slice(first, first + count), likeness))
            texture, normals = texture + likeness.counts[0], normals + likeness.counts[1]
    return found


def _elements(keyword: str, indices: NDArray[np.int32]) -> str:
    rows: list[list[int]] = (indices + 1).tolist()
    return "".join(f"{keyword} {' '.join(map(str, row))}\n" for row in rows)
