"""Mesh formats other than OBJ, read by trimesh from memory, so that no other file is ever opened."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.formats.declared import check_gltf, declared_counts
from taut.formats.polygons import MeshError, Polygons

EXTENSIONS = ("ply", "stl", "off", "glb", "gltf")
"""What :func:`read_general` can read."""

_UNSHARED = {
    "stl": "STL does not share vertices between triangles",
    "glb": "glTF splits vertices at seams and sharp edges",
    "gltf": "glTF splits vertices at seams and sharp edges",
}
_MOST_TRIANGLES = 20_000_000

Vertices = NDArray[np.float64]
Faces = NDArray[np.int64]


def read_general(path: Path, data: bytes) -> Polygons:
    """Read a mesh of one of the :data:`EXTENSIONS`; all faces become triangles.

    Args:
        path: its name, for the format and for errors.
        data: what stands in the file.

    Raises:
        MeshError: the file is damaged, or needs other files.
    """
    extension = path.suffix[1:].lower()
    try:
        declared = declared_counts(extension, data)
        if extension in ("glb", "gltf"):
            check_gltf(extension, data)
        vertices, faces = _load(extension, data)
        repairs = _checked(vertices, faces, declared)
    except Exception as error:  # trimesh raises nearly everything on damaged files
        reason = f"{type(error).__name__}: {error}" if type(error) is not MeshError else str(error)
        raise MeshError(f"{path}: cannot be read: {_one_line(reason)}") from error
    if extension in _UNSHARED:
        before = len(vertices)
        vertices, faces = _joined(vertices, faces)
        if len(vertices) < before:
            why = _UNSHARED[extension]
            repairs.append(f"{before} vertices were joined into {len(vertices)} where they coincide: {why}")
    counts = np.full(len(faces), 3, dtype=np.int64)
    return Polygons(vertices, faces.ravel(), counts, tuple(repairs))


def _load(extension: str, data: bytes) -> tuple[Vertices, Faces]:
    import trimesh  # here: it takes a while to load, and OBJ does without

    # PLY: by default vertices are split where texture coordinates meet.
    extra: dict[str, Any] = {"fix_texture": False} if extension == "ply" else {}
    with _quiet():
        scene = trimesh.load_scene(
            BytesIO(data), file_type=extension, resolver=None, process=False, skip_materials=True, **extra
        )
        triangles = 0
        for node in scene.graph.nodes_geometry:
            triangles += len(getattr(scene.geometry[scene.graph[node][1]], "faces", ()))
        if triangles > _MOST_TRIANGLES:
            raise MeshError(f"holds {triangles} triangles, at most {_MOST_TRIANGLES} can be used")
        if triangles == 0:
            raise MeshError("holds no faces")
        mesh = scene.to_mesh()
    return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)


def _checked(vertices: Vertices, faces: Faces, declared: tuple[int, int] | None) -> list[str]:
    """Compare what was loaded with itself and with what the file promised; return what was changed."""
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if bad.size:
        raise MeshError(f"vertex {bad[0]} is {vertices[bad[0]].tolist()}: must be finite numbers")
    bad = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))
    if bad.size:
        corners = faces[bad[0]].tolist()
        raise MeshError(f"face {bad[0]} is {corners}: indices must be from 0 to {len(vertices) - 1}")
    if declared is None:
        return []
    if len(vertices) != declared[0] or len(faces) < declared[1]:
        found = f"{len(vertices)} vertices and {len(faces)} triangles were found"
        raise MeshError(f"declares {declared[0]} vertices and {declared[1]} faces, but {found}")
    if len(faces) > declared[1]:
        cut = f"{declared[1]} became {len(faces)}"
        return [f"faces were cut into triangles ({cut}); OBJ keeps polygons whole"]
    return []


def _joined(vertices: Vertices, faces: Faces) -> tuple[Vertices, Faces]:
    """Make vertices of equal position one; the first of each stays, in order."""
    # Adding zero makes -0 and 0 equal.
    _, first, group = np.unique(vertices + 0.0, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return vertices[first[order]], rank[group.reshape(-1)][faces]


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep trimesh from logging, and numbers that cannot be parsed from passing with a mere warning."""
    log, silence = logging.getLogger("trimesh"), logging.NullHandler()
    before = log.propagate
    log.addHandler(silence)
    log.propagate = False
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.filterwarnings("error", message=".*could not be read to its end.*")
            yield
    finally:
        log.propagate = before
        log.removeHandler(silence)


def _one_line(text: str) -> str:
    text = " ".join(text.split()).encode("ascii", "backslashreplace").decode()
    return text if len(text) <= 300 else text[:297] + "..."
