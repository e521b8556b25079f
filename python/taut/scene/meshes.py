"""The geometry that a scene's cloths and bodies name: files beside the scene, or arrays."""

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.errors import SceneError
from taut.scene.plain import shorten

Mesh = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]
"""Vertices [m, before scale], shape (vertices, 3); corners of all faces; number of corners of each face."""

_LONGEST_PATH = 4096
"""No system opens longer paths [bytes]."""

_REFERENCE = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")


def resolve_path(name: str, folder: Path, field: str, sandbox: bool = False) -> Path:
    """Find a mesh file.

    Args:
        name: the path as written in the scene.
        folder: the scene's folder, from which paths start.
        field: where the path stands, for errors.
        sandbox: for scenes from elsewhere: only files in that folder or below it are read.

    Raises:
        SceneError: the path is a URL or names no file; in a sandbox it is absolute, or leaves the folder, by
            a link for example.
    """
    path = allowed_path(name, folder, field, sandbox)
    try:
        found = path.is_file()
    except OSError:  # a part of it is longer than the system's names
        found = False
    if not found:
        raise SceneError(
            f"{field} = {shorten(repr(name))}: there is no file {shorten(str(path), 400)}; "
            "a path is taken from the scene's folder"
        )
    return path


def allowed_path(name: str, folder: Path, field: str, sandbox: bool) -> Path:
    """Where a path leads, whether there is anything or not; otherwise like :func:`resolve_path`."""
    where = f"{field} = {shorten(repr(name))}"
    if _REFERENCE.match(name):
        raise SceneError(
            f"{where}: is a reference, not a path; put the file beside the scene and give its name"
        )
    if sandbox and (Path(name).is_absolute() or PureWindowsPath(name).anchor):
        raise SceneError(
            f"{where}: is absolute, which a sandbox refuses; put the file beside the scene and give its path "
            f"from {folder}, or trust the scene and leave the sandbox out"
        )
    if "\0" in name or not name.strip():
        raise SceneError(f"{where}: is no file name; give the path of a mesh beside the scene")
    if len(os.fsencode(name)) > _LONGEST_PATH:
        raise SceneError(
            f"{where}: is longer than {_LONGEST_PATH} bytes; give the path of a mesh beside the scene"
        )
    path = (folder / name).resolve()
    if sandbox and (".." in PureWindowsPath(name).parts or not path.is_relative_to(folder.resolve())):
        raise SceneError(
            f"{where}: leaves the scene's folder {folder}, which a sandbox refuses; copy the file into it, "
            "or trust the scene and leave the sandbox out"
        )
    return path


def check_arrays(name: str, mesh: tuple[ArrayLike, ArrayLike]) -> Mesh:
    """Check a mesh given as arrays and return it as the engine takes it.

    Args:
        name: its name in the scene.
        mesh: vertices, shape (vertices, 3), and faces, shape (faces, 3) or (faces, 4), counted from 0.

    Raises:
        SceneError: wrong shape or type, a number that is not finite, an index out of range.
    """
    where = f"meshes[{name!r}]"
    if not isinstance(mesh, tuple | list) or len(mesh) != 2:
        raise SceneError(f"{where}: must be a pair (vertices, faces)")
    vertices, faces = _array(mesh[0], f"{where} vertices"), _array(mesh[1], f"{where} faces")
    if vertices.ndim != 2 or vertices.shape[1] != 3 or vertices.dtype.kind not in "fiu":
        raise SceneError(f"{where} vertices: {_kind(vertices)}; must be numbers of shape (vertices, 3)")
    if faces.ndim != 2 or faces.shape[1] not in (3, 4) or faces.dtype.kind not in "iu":
        raise SceneError(f"{where} faces: {_kind(faces)}; must be integers of shape (faces, 3) or (faces, 4)")
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if bad.size:
        raise SceneError(f"{where} vertices[{bad[0]}] = {vertices[bad[0]].tolist()}: must be finite numbers")
    bad = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))
    if bad.size:
        corners = faces[bad[0]].tolist()
        raise SceneError(
            f"{where} faces[{bad[0]}] = {corners}: indices must be from 0 to {len(vertices) - 1}"
        )
    counts = np.full(len(faces), faces.shape[1], dtype=np.int64)
    return np.ascontiguousarray(vertices, np.float64), faces.astype(np.int64).ravel(), counts


def _array(value: ArrayLike, where: str) -> NDArray[Any]:
    try:
        return np.asarray(value)
    except (TypeError, ValueError):
        raise SceneError(f"{where}: is no array of numbers; must be one, its rows equally long") from None


def _kind(array: NDArray[Any]) -> str:
    return f"has shape {array.shape} and type {array.dtype}"


def read_meshes(
    document: Mapping[str, Any], folder: Path, given: Mapping[str, Mesh], sandbox: bool = False
) -> tuple[dict[str, Mesh], list[str]]:
    """Return the geometry of every mesh that a resolved scene names, and what was repaired in it.

    Raises:
        SceneError: a mesh is missing or cannot be read; in a sandbox it lies outside the scene's folder.
    """
    meshes: dict[str, Mesh] = {}
    repairs: list[str] = []
    for field, name in _named(document):
        if name in meshes:
            continue
        if name in given:
            meshes[name] = given[name]
            continue
        from taut.formats import read_mesh  # here: a scene of grids need not load the mesh readers

        polygons = read_mesh(resolve_path(name, folder, field, sandbox))
        meshes[name] = (polygons.vertices, polygons.corners, polygons.counts)
        repairs += [f"{name}: {repair}" for repair in polygons.repairs]
    return meshes, repairs


def _named(document: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Every mesh that a resolved scene names, and where."""
    for kind in ("cloth", "body"):
        for index, holder in enumerate(document.get(kind, ())):
            if holder.get("mesh") is not None:
                yield f"scene.{kind}[{index}].mesh", holder["mesh"]
