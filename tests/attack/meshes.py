"""Mesh files of every format that taut reads, whole and damaged, and what may become of them.

>>> for index, content in enumerate(mutants("ply", seed=1, count=1000)):
...     path.write_bytes(content)
...     judge(path)
"""

from __future__ import annotations

import base64
import json
import random
import re
import struct
import warnings
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from taut.formats import MESH_EXTENSIONS, MeshError, read_mesh

from tests.attack.leaks import leak

FORMATS = MESH_EXTENSIONS

PLACES = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0), (0.5, 2.0, 0.25)]
FACES = [(0, 1, 2), (0, 2, 3), (3, 2, 4)]
POLYGONS = [(0, 1, 2), (0, 2, 4, 3), (0, 1, 2, 4, 3)]
STRANGE = ["0", "-1", "1", "2", "255", "65536", "4294967295", "-2147483648", "1e9", "999999999999", "1e308"]
STRANGE += ["1e999", "-1e-320", "nan", "inf", "9" * 30, "9" * 5000, "x", "", "0x10", "1_0", "1,5", "\xb2"]
VALUES = [None, True, -1, 0, 1, 2, 3, 255, 2**31, 2**64, 10**400, 1.5, -0.0, 1e308, float("inf"), "", "x"]
VALUES += ["data:;base64,AAAA", "\ud800", [], [0], [[]], {}, {"a": 1}, "../../etc/passwd"]
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


@cache
def valid(extension: str) -> tuple[bytes, ...]:
    """Small files of a format, each of which can be read."""
    return tuple(_MAKERS[extension]())


def mutants(extension: str, seed: int, count: int) -> Iterator[bytes]:
    """So many damaged files of a format, the same for the same seed."""
    for index in range(count):
        chance = random.Random(f"{extension} {seed} {index}")
        content = chance.choice(valid(extension))
        for _ in range(chance.choice((1, 1, 1, 2, 3))):
            content = chance.choice(_MUTATIONS)(chance, extension, content)
        yield content


def prefixes(extension: str) -> Iterator[bytes]:
    """The small files of a format, cut at every byte."""
    for content in valid(extension):
        for length in range(len(content)):
            yield content[:length]


def judge(path: Path) -> str | None:
    """What taut says about a file; `None` where it reads it.

    Raises:
        AssertionError: it reads what is no mesh, or refuses it with another error or in words of others.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            mesh = read_mesh(path)
    except MeshError as error:
        said = str(error)
        assert leak(error) is None, f"{leak(error)!r} in {said!r}"
        where = re.match(rf"{re.escape(str(path))}(:\d+)?: (?=\S)", said)
        assert where, f"does not begin with the file: {said!r}"
        return said[where.end() :]
    counts, corners = mesh.counts, mesh.corners
    assert mesh.vertices.ndim == 2 and mesh.vertices.shape[1] == 3 and len(mesh.vertices) > 0
    assert np.isfinite(mesh.vertices).all(), "vertices must be finite"
    assert len(counts) > 0 and (counts >= 3).all() and counts.sum() == len(corners), "corners must fit counts"
    assert (corners >= 0).all() and (corners < len(mesh.vertices)).all(), "indices must be in range"
    return None


# ---- whole files


def _obj() -> Iterator[bytes]:
    text = "# cloth\nmtllib a.mtl\no one\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in PLACES)
    text += "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1//1 3//1 5//1 4//1\nf -5 -4 \\\n -3 -1 -2\n"
    yield text.encode()


def _off() -> Iterator[bytes]:
    lines = [f"{x} {y} {z}" for x, y, z in PLACES] + [f"{len(f)} {' '.join(map(str, f))}" for f in POLYGONS]
    yield f"OFF\n# cloth\n{len(PLACES)} 2 0\n".encode() + "\n".join(lines[:-1]).encode()
    coloured = [f"{line} 0.5 0.5 0.5 1" for line in lines]
    yield f"COFF {len(PLACES)} {len(POLYGONS)} 0\r\n".encode() + "\r\n".join(coloured).encode() + b"\r\n"


def _ply() -> Iterator[bytes]:
    def head(kind: str, faces: int) -> bytes:
        return (
            f"ply\nformat {kind} 1.0\ncomment cloth\nelement vertex {len(PLACES)}\nproperty float x\n"
            "property float y\nproperty float z\nproperty uchar red\n"
            f"element face {faces}\nproperty list uchar int vertex_indices\n"
            "element seam 1\nproperty int start\nproperty int stop\nend_header\n"
        ).encode()

    for faces in (FACES, POLYGONS):
        lines = [f"{x} {y} {z} 255" for x, y, z in PLACES] + [
            f"{len(f)} {' '.join(map(str, f))}" for f in faces
        ]
        yield head("ascii", len(faces)) + "\n".join([*lines, "0 1"]).encode() + b"\n"
        for kind, order in (("binary_little_endian", "<"), ("binary_big_endian", ">")):
            body = b"".join(struct.pack(order + "3fB", *place, 255) for place in PLACES)
            body += b"".join(struct.pack(f"{order}B{len(face)}i", len(face), *face) for face in faces)
            yield head(kind, len(faces)) + body + struct.pack(order + "2i", 0, 1)


def _stl() -> Iterator[bytes]:
    triangles = [[PLACES[corner] for corner in face] for face in FACES]
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *sum(triangle, ()), 0) for triangle in triangles)
    yield b"solid, but binary".ljust(80, b"\0") + struct.pack("<I", len(triangles)) + body
    text = "solid cloth\n"
    for triangle in triangles:
        corners = "".join(f"      vertex {x} {y} {z}\n" for x, y, z in triangle)
        text += f"  facet normal 0 0 1\n    outer loop\n{corners}    endloop\n  endfacet\n"
    yield (text + "endsolid cloth\n").encode()


def gltf_tree(uri: str | None, size: int) -> dict[str, Any]:
    strip = {"attributes": {"POSITION": 0}, "indices": 2, "mode": 5}
    lines = {"attributes": {"POSITION": 0}, "mode": 1}
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"children": [1, 2], "rotation": [0.0, 0.0, 0.7071068, 0.7071068]},
            {"mesh": 0, "translation": [1.0, 2.0, 3.0], "scale": [1.0, -1.0, 1.0]},
            {"mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1], "name": "two"},
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}]},
            {"primitives": [strip, lines]},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 9, "type": "SCALAR"},
            {"bufferView": 1, "byteOffset": 2, "componentType": 5123, "count": 4, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 60},
            {"buffer": 0, "byteOffset": 60, "byteLength": 18},
        ],
        "buffers": [{"byteLength": size} | ({} if uri is None else {"uri": uri})],
    }


_DATA = struct.pack("<15f9H", *sum(PLACES, ()), *sum(FACES, ()))


def _gltf() -> Iterator[bytes]:
    uri = "data:application/octet-stream;base64," + base64.b64encode(_DATA).decode()
    yield json.dumps(gltf_tree(uri, len(_DATA)), indent=1).encode()


def glb(tree: Any, data: bytes = _DATA) -> bytes:
    """A binary glTF file of a tree of JSON."""
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _glb() -> Iterator[bytes]:
    yield glb(gltf_tree(None, len(_DATA)))


_MAKERS = {"obj": _obj, "ply": _ply, "stl": _stl, "off": _off, "glb": _glb, "gltf": _gltf}


# ---- damage; each takes chance, format and content


def _place(chance: random.Random, content: bytes) -> tuple[int, int]:
    start = chance.randrange(len(content) + 1)
    return start, min(len(content), start + chance.choice((1, 1, 2, 4, 8, 50)))


def _flipped(chance: random.Random, _: str, content: bytes) -> bytes:
    found = bytearray(content)
    if found:
        found[chance.randrange(len(found))] ^= 1 << chance.randrange(8)
    return bytes(found)


def _written(chance: random.Random, _: str, content: bytes) -> bytes:
    start, end = _place(chance, content)
    return content[:start] + chance.randbytes(end - start) + content[end:]


def _deleted(chance: random.Random, _: str, content: bytes) -> bytes:
    start, end = _place(chance, content)
    return content[:start] + content[end:]


def _doubled(chance: random.Random, _: str, content: bytes) -> bytes:
    start, end = _place(chance, content)
    return content[:end] + content[start:]


def _truncated(chance: random.Random, _: str, content: bytes) -> bytes:
    return content[: chance.randrange(len(content) + 1)]


def _spliced(chance: random.Random, extension: str, content: bytes) -> bytes:
    other = chance.choice(valid(chance.choice((extension, extension, *FORMATS))))
    return content[: chance.randrange(len(content) + 1)] + other[chance.randrange(len(other)) :]


def _renumbered(chance: random.Random, _: str, content: bytes) -> bytes:
    """Another number, or one that is scaled, in the text."""
    found = list(_NUMBER.finditer(content))
    if not found:
        return content
    number = chance.choice(found)
    new = chance.choice(STRANGE).encode("latin-1")
    if chance.random() < 0.3:
        new = repr(float(number[0]) * 10.0 ** chance.randint(-300, 300)).encode()
    return content[: number.start()] + new + content[number.end() :]


def _recounted(chance: random.Random, _: str, content: bytes) -> bytes:
    """Another binary number, where heads have theirs or anywhere."""
    new = struct.pack("<I", chance.choice((0, 1, 2, 3, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 1, 0x7FC00000)))
    start = chance.choice((4, 8, 12, 16, 80, chance.randrange(len(content) + 1)))
    return content[:start] + new + content[start + 4 :]


def _line_changed(chance: random.Random, _: str, content: bytes) -> bytes:
    lines = content.split(b"\n")
    index = chance.randrange(len(lines))
    match chance.randrange(3):
        case 0:
            del lines[index]
        case 1:
            lines.insert(index, chance.choice(lines))
        case _:
            words = lines[index].split()
            chance.shuffle(words)
            lines[index] = b" ".join(words[: chance.randrange(len(words) + 1)])
    return b"\n".join(lines)


def _replanted(chance: random.Random, extension: str, content: bytes) -> bytes:
    """Another value somewhere in the JSON of a glTF file; other files get another number."""
    if extension not in ("glb", "gltf"):
        return _renumbered(chance, extension, content)
    tree = gltf_tree(None, len(_DATA)) if extension == "glb" else json.loads(next(_gltf()))
    for _ in range(chance.choice((1, 1, 2, 3))):
        branch, key = chance.choice(list(_leaves(tree)))
        value = chance.choice(VALUES)
        if chance.random() < 0.2:
            del branch[key]
        else:
            branch[key] = chance.randrange(6) if chance.random() < 0.3 else value
    return glb(tree) if extension == "glb" else json.dumps(tree).encode()


def _leaves(branch: Any) -> Iterator[tuple[Any, Any]]:
    """Each place of a tree, as the table or list and its key."""
    for key in list(branch) if isinstance(branch, dict) else range(len(branch)):
        yield branch, key
        if isinstance(branch[key], dict | list):
            yield from _leaves(branch[key])


_MUTATIONS = (
    _flipped, _written, _deleted, _doubled, _truncated, _spliced, _renumbered, _renumbered, _recounted,
    _line_changed, _replanted, _replanted,
)  # fmt: skip
