"""The arrays that pins and bodies follow: files beside the scene, or arrays."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.errors import SceneError
from taut.scene.frame_files import is_pattern, read_frames
from taut.scene.meshes import resolve_path
from taut.scene.plain import shorten

FollowedPath = tuple[NDArray[np.float64], float | None]
"""Places [m], shape (frames, vertices, 3), and frames per second [1/s]: ``None``, those of the scene."""


def check_path(where: str, path: ArrayLike) -> NDArray[np.float64]:
    """Check places given as an array and return them as the engine takes them.

    Raises:
        SceneError: wrong shape or type.
    """
    try:
        array = np.asarray(path)
    except (TypeError, ValueError):
        raise SceneError(f"{where}: is no array of numbers; must be one, its rows equally long") from None
    if array.ndim != 3 or array.shape[2] != 3 or array.dtype.kind not in "fiu":
        raise SceneError(
            f"{where}: has shape {array.shape} and type {array.dtype}; "
            "must be numbers of shape (frames, vertices, 3)"
        )
    with np.errstate(invalid="ignore"):  # what is not finite is refused later
        return np.ascontiguousarray(array, np.float64)


def read_paths(
    document: Mapping[str, Any], folder: Path, given: Mapping[str, FollowedPath], sandbox: bool = False
) -> dict[str, FollowedPath]:
    """Return every array that a pin or a body of a resolved scene follows.

    Raises:
        SceneError: a file is missing or no such array.
    """
    paths: dict[str, FollowedPath] = {}
    for field, files in _named(document):
        name = _name(files)
        if name in paths:
            continue
        if name in given:
            paths[name] = given[name]
        elif isinstance(files, list) or is_pattern(files):
            paths[name] = read_frames(files, folder, field, sandbox), None
        else:
            where = f"{field} = {shorten(repr(files))}"
            paths[name] = _read(resolve_path(files, folder, field, sandbox), where, document)
    return paths


def _name(files: str | list[str]) -> str:
    """The name under which the engine asks for the places: that of a list is what it is as JSON."""
    if isinstance(files, str):
        return files
    return json.dumps(files, ensure_ascii=False, separators=(",", ":"))


def _named(document: Mapping[str, Any]) -> Iterator[tuple[str, str | list[str]]]:
    """The path or paths of every array that a resolved scene names, and where."""
    for index, cloth in enumerate(document["cloth"]):
        for number, pin in enumerate(cloth["pins"]):
            if pin.get("follow") is not None:
                yield f"scene.cloth[{index}].pins[{number}].follow", pin["follow"]
    for index, body in enumerate(document.get("body", ())):
        if body.get("motion") is not None:
            yield f"scene.body[{index}].motion", body["motion"]


def _read(path: Path, where: str, document: Mapping[str, Any]) -> FollowedPath:
    if path.suffix.lower() == ".pc2":
        from taut.formats.pc2 import read_pc2  # here: a scene without such pins need not load the formats
        from taut.formats.polygons import MeshError

        try:
            start, sampling, places = read_pc2(path)
        except MeshError as error:
            raise SceneError(f"{where}: {error}") from None
        if start != 0.0 or not sampling > 0.0:
            raise SceneError(
                f"{where}: begins at frame {start} with {sampling} frames per sample; must begin at frame 0"
            )
        rate = None if sampling == 1.0 else float(document["fps"]) / sampling
        return check_path(where, places), rate
    if path.suffix.lower() != ".npy":
        remedy = "; of .obj files, one for each frame, give a list, or walk_*.obj for walk_000.obj and so on"
        raise SceneError(f"{where}: must be an .npy or .pc2 file{remedy}")
    try:
        places = np.load(path, allow_pickle=False)
    except OSError as error:
        raise SceneError(f"{where}: cannot be opened: {error.strerror or 'it cannot be read'}") from None
    except Exception:  # NumPy raises nearly everything on damaged files
        raise SceneError(
            f"{where}: is cut short, damaged, or holds objects; write it again with numpy.save"
        ) from None
    return check_path(where, places), None
