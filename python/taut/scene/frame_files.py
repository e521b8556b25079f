"""Places that pins and bodies follow in OBJ files, one for each frame."""

import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.errors import SceneError
from taut.scene.meshes import allowed_path, resolve_path
from taut.scene.plain import shorten


def is_pattern(name: str) -> bool:
    """Whether a path means all files that are numbered in the place of a ``*``."""
    return "*" in name and name.lower().endswith(".obj")


def read_frames(files: str | list[str], folder: Path, field: str, sandbox: bool) -> NDArray[np.float64]:
    """Read places [m], shape (frames, vertices, 3).

    Args:
        files: the path of each frame, or a pattern as in ``walk_*.obj``: the ``*`` stands for the number of
            the frame, in decimal digits, with zeros before it or without. Numbers begin anywhere and leave no
            gap.
        folder: the scene's folder, from which paths start.
        field: where the paths stand, for errors.
        sandbox: only files in that folder or below it are read.

    Raises:
        SceneError: a file is missing, no OBJ or has another number of vertices than the first; numbers leave
            a gap; or as :func:`taut.scene.meshes.resolve_path`.
    """
    from taut.formats.polygons import MeshError  # here: a scene without such files need not load the formats
    from taut.formats.read import read_vertices

    is_list = isinstance(files, list)
    names = files if isinstance(files, list) else _numbered(files, folder, field, sandbox)
    places: list[NDArray[np.float64]] = []
    read: dict[Path, NDArray[np.float64]] = {}  # a pose that is held is read once
    for frame, name in enumerate(names):
        own = f"{field}[{frame}]" if is_list else field
        where = f"{own} = {shorten(repr(name))}"
        if not name.lower().endswith(".obj"):
            raise SceneError(
                f"{where}: must be an .obj file, which holds one frame; an .npy or .pc2 file, which holds "
                "all of them, is given without a list"
            )
        path = resolve_path(name, folder, own, sandbox)
        if path not in read:
            try:
                read[path] = read_vertices(path)
            except MeshError as error:
                raise SceneError(f"{where}, frame {frame}: {error}") from None
        places.append(read[path])
        count, expected = len(places[-1]), len(places[0])
        if count != expected:
            raise SceneError(
                f"{where}: has {count} vertices in frame {frame}, but frame 0, {shorten(repr(names[0]))}, "
                f"has {expected}; all frames must have the same vertices in the same order: export every one "
                "of them from the same mesh, without modifiers that add or remove vertices"
            )
    return np.stack(places)


def _numbered(pattern: str, folder: Path, field: str, sandbox: bool) -> list[str]:
    """The paths that a pattern means, in the order of their numbers."""
    where = f"{field} = {shorten(repr(pattern))}"
    parent, name = os.path.split(pattern)
    if pattern.count("*") != 1 or "*" not in name:
        raise SceneError(
            f"{where}: must have one * in the file's name, which stands for the number of the frame, as in "
            "walk_*.obj; or give a list of files"
        )
    before, _, after = name.partition("*")
    matching = re.compile(re.escape(before) + "([0-9]+)" + re.escape(after))
    path = allowed_path(pattern, folder, field, sandbox)
    try:
        there = sorted(os.listdir(path.parent))
    except OSError:
        there = []
    found: dict[int, str] = {}
    for match in filter(None, map(matching.fullmatch, there)):
        other = found.setdefault(int(match[1]), match[0])
        if other != match[0]:
            raise SceneError(
                f"{where}: {shorten(repr(other))} and {shorten(repr(match[0]))} have the same number; remove "
                "one of them, or give a list of files"
            )
    if not found:
        raise SceneError(
            f"{where}: there is no such file in {shorten(str(path.parent), 400)}; the * stands for the "
            "number of the frame, as in walk_000.obj, and a path is taken from the scene's folder"
        )
    first, last = min(found), max(found)
    if len(found) <= last - first:
        gap = next(number for number in range(first, last) if number not in found)
        raise SceneError(
            f"{where}: there is no number {gap} between {shorten(repr(found[first]))} and "
            f"{shorten(repr(found[last]))}; numbers must leave no gap, so that no frame is left out "
            "unnoticed: write the file, or give a list of those that there are"
        )
    return [os.path.join(parent, found[number]) for number in sorted(found)]
