"""Read a mesh file of any format we know."""

import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.formats.gltf_reader import read_glb, read_gltf
from taut.formats.obj_reader import read_obj, read_obj_vertices
from taut.formats.off_reader import read_off
from taut.formats.ply_reader import read_ply
from taut.formats.polygons import MeshError, Polygons
from taut.formats.stl_reader import read_stl

_READERS: dict[str, Callable[[str, bytes], Polygons]] = {
    "ply": read_ply,
    "stl": read_stl,
    "off": read_off,
    "glb": read_glb,
    "gltf": read_gltf,
}

MESH_EXTENSIONS = ("obj", *_READERS)
"""File name extensions that :func:`read_mesh` can read."""

LARGEST_FILE = 1 << 30
"""Mesh files larger than this are refused [bytes]."""


def read_mesh(path: str | Path) -> Polygons:
    """Read a polygon mesh; only this one file is opened, whatever it refers to.

    Args:
        path: an OBJ (vertices and polygons come out exactly as they stand there), or a PLY, STL, OFF, GLB or
            glTF with embedded data (which come out as triangles).

    Raises:
        MeshError: the file, what is wrong with it and what is allowed.
    """
    path = Path(path)
    extension = path.suffix[1:].lower()
    if extension not in MESH_EXTENSIONS:
        known = ", ".join(f".{name}" for name in MESH_EXTENSIONS)
        raise MeshError(f"{path}: {path.suffix or 'no extension'} is not a mesh format; readable are {known}")
    with _readable(path):
        return read_obj(path) if extension == "obj" else _READERS[extension](str(path), path.read_bytes())


def read_vertices(path: str | Path) -> NDArray[np.float64]:
    """Read the vertices of an OBJ exactly as they stand there, shape (vertices, 3); it need not have faces.

    Raises:
        MeshError: the file, what is wrong with it and what is allowed.
    """
    path = Path(path)
    with _readable(path):
        return read_obj_vertices(path)


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Look at a file before it is read; explain what the system says."""
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise MeshError(f"{path}: is not a regular file")
        if status.st_size > LARGEST_FILE:
            size = f"{status.st_size / 1e9:.1f} GB"
            raise MeshError(f"{path}: is too large ({size}); the limit is {LARGEST_FILE / 1e9:.1f} GB")
        if status.st_size == 0:
            raise MeshError(f"{path}: is empty")
        # What is not finite is refused, by name: NumPy need not warn of it.
        with np.errstate(all="ignore"):
            yield
    except OSError as error:
        raise MeshError(f"{path}: cannot be opened: {error.strerror or error}") from error
