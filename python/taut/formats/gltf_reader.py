"""glTF and GLB: the triangles of a scene, each mesh where its nodes put it."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taut.arrays import shown
from taut.formats.gltf_document import Document, Entry, from_glb, from_gltf
from taut.formats.polygons import Integers, Polygons, Vertices, refusal
from taut.formats.triangles import check_size, joined

_FLOAT = 5126
_INDICES = {5121: "<u1", 5123: "<u2", 5125: "<u4"}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_MOVING = ("matrix", "translation", "rotation", "scale")

Part = tuple[Vertices, Integers]
"""Vertices, shape (vertices, 3), and triangles, shape (triangles, 3)."""


def read_gltf(name: str, data: bytes) -> Polygons:
    """Read a glTF file whose data are embedded.

    Raises:
        MeshError: the file, the entry of its JSON, what is wrong there and what is allowed.
    """
    return _read(from_gltf(name, data))


def read_glb(name: str, data: bytes) -> Polygons:
    """Read a binary glTF file.

    Raises:
        MeshError: see :func:`read_gltf`.
    """
    return _read(from_glb(name, data))


def _read(document: Document) -> Polygons:
    meshes: dict[int, list[Part]] = {}
    found: list[tuple[int, NDArray[np.float64]]] = []
    vertices = triangles = 0
    for node, matrix in _placed(document):
        if "mesh" not in node.table:
            continue
        mesh = node.index("mesh", "meshes")
        if mesh not in meshes:
            meshes[mesh] = list(_parts(document, mesh))
        vertices += sum(len(part[0]) for part in meshes[mesh])
        triangles += sum(len(part[1]) for part in meshes[mesh])
        check_size(document.name, vertices, triangles)
        found.append((mesh, matrix))
    if triangles == 0:
        raise refusal(document.name, "holds no faces in its scene", "export the mesh with its faces")
    places, faces, first = [], [], 0
    turned = np.linalg.det(np.array([matrix[:3, :3] for _, matrix in found])) < 0
    for (mesh, matrix), turns in zip(found, turned, strict=True):
        for place, corners in meshes[mesh]:
            places.append(place @ matrix[:3, :3].T + matrix[:3, 3])
            faces.append((corners[:, ::-1] if turns else corners) + first)
            first += len(place)
    why = "glTF splits vertices at seams and sharp edges"
    return joined(document.name, np.concatenate(places), np.concatenate(faces), why)


def _placed(document: Document) -> Iterator[tuple[Entry, NDArray[np.float64]]]:
    """Each node of the scene once, and the matrix that takes it there; parents come before children.

    Raises:
        MeshError: a node has two parents, or is its own ancestor, or something in it is wrong.
    """
    scene = document.entry("scenes", document.top.integer("scene", default=0), "scene")
    following = [(root, np.eye(4)) for root in scene.indices("nodes", "nodes")]
    seen: set[int] = set()
    while following:
        index, before = following.pop()
        node = document.entry("nodes", index, scene.where)
        if index in seen:
            raise node.refusal("is reached twice: each node must have one parent and no loop")
        seen.add(index)
        matrix = before if node.table.keys().isdisjoint(_MOVING) else before @ _local(node)
        following += [(child, matrix) for child in node.indices("children", "nodes")]
        yield node, matrix


def _local(node: Entry) -> NDArray[np.float64]:
    """The matrix of a node: that of its JSON, times shift, rotation and scale."""
    moved = np.zeros((4, 4))
    moved[3, 3] = 1.0
    moved[:3, 3] = node.reals("translation", [0.0, 0.0, 0.0])
    moved[:3, :3] = _rotation(*node.reals("rotation", [0.0, 0.0, 0.0, 1.0]))
    moved[:3, :3] *= node.reals("scale", [1.0, 1.0, 1.0])
    if "matrix" not in node.table:
        return moved
    return np.array(node.reals("matrix", [0.0] * 16)).reshape(4, 4).T @ moved


def _rotation(x: float, y: float, z: float, w: float) -> list[list[float]]:
    """The matrix of a quaternion of any length; that of no length turns nothing."""
    length = math.hypot(x, y, z, w)
    if not 1e-8 < length < math.inf:
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    x, y, z, w = x / length, y / length, z / length, w / length
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def _parts(document: Document, mesh: int) -> Iterator[Part]:
    """The primitives of a mesh that have triangles."""
    for primitive in document.entry("meshes", mesh, "meshes").tables("primitives"):
        mode = primitive.integer("mode", default=_TRIANGLES)
        if mode > _FAN:
            raise primitive.refusal(f"has the mode {shown(mode)}: must be 0 to {_FAN}")
        if mode < _TRIANGLES:
            continue  # points and lines
        attributes = primitive.table_of("attributes")
        places = document.numbers(attributes, "POSITION", "VEC3", {_FLOAT: "<f4"}).astype(np.float64)
        if "indices" in primitive.table:
            indices = document.numbers(primitive, "indices", "SCALAR", _INDICES).astype(np.int64).ravel()
        else:
            indices = np.arange(len(places), dtype=np.int64)
        for bad in np.flatnonzero(indices >= len(places))[:1]:
            raise primitive.refusal(
                f"has the index {indices[bad]}: indices must be from 0 to {len(places) - 1}"
            )
        if mode == _TRIANGLES and len(indices) % 3:
            raise primitive.refusal(f"has {len(indices)} indices of triangles: must be a multiple of 3")
        yield places, _triangles(mode, indices)


def _triangles(mode: int, indices: Integers) -> Integers:
    if mode == _TRIANGLES:
        return indices.reshape(-1, 3)
    if mode == _FAN:
        return np.stack([np.full(max(0, len(indices) - 2), indices[0]), indices[1:-1], indices[2:]], axis=-1)
    faces = np.stack([indices[:-2], indices[1:-1], indices[2:]], axis=-1)
    faces[1::2] = faces[1::2, ::-1]
    return faces
