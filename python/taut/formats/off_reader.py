"""OFF: a line for each vertex and each face."""

import re
from collections.abc import Iterator

import numpy as np

from taut.formats.polygons import Polygons, refusal
from taut.formats.text import integers, lines_of, quoted, reals
from taut.formats.triangles import cut

# Texture coordinates, colours and normals come after three coordinates; 4OFF would have four.
_HEADER = re.compile(r"(ST)?C?N?OFF")


def read_off(name: str, data: bytes) -> Polygons:
    """Read an OFF file; all faces become triangles.

    Raises:
        MeshError: the file and line, what is wrong there and what is allowed.
    """
    lines = lines_of(data, comment="#")
    vertices, faces = _counts(name, lines)
    coordinates: list[list[float]] = []
    corners: list[int] = []
    counts: list[int] = []
    number = 0
    for number, words in lines:
        where = f"{name}:{number}"
        if len(coordinates) < vertices:
            place = reals(words[:3])
            if place is None or len(place) < 3:
                raise refusal(where, f"{quoted(words)} is no vertex: must begin with 3 finite numbers")
            coordinates.append(place)
        elif len(counts) < faces:
            face = _face(where, words)
            corners += face
            counts.append(len(face))
        else:
            raise refusal(where, f"there is more than the {vertices} vertices and {faces} faces it declares")
    if len(coordinates) < vertices or len(counts) < faces:
        found = f"{len(coordinates)} vertices and {len(counts)} faces"
        raise refusal(
            name, f"is cut short: it declares {vertices} vertices and {faces} faces, and has {found}"
        )
    places = np.array(coordinates, dtype=np.float64).reshape(-1, 3)
    return cut(name, places, np.array(corners, dtype=np.int64), np.array(counts, dtype=np.int64))


def _counts(name: str, lines: Iterator[tuple[int, list[str]]]) -> tuple[int, int]:
    """How many vertices and faces there are, in the line of the word OFF or in the next one."""
    number, words = next(lines, (1, []))
    if not words or not _HEADER.fullmatch(words[0]):
        what = f"has no OFF header, it begins with {quoted(words[:4])}"
        raise refusal(name, what, "the first word must be OFF, in front of the numbers of vertices and faces")
    if words[1:2] == ["BINARY"]:
        raise refusal(f"{name}:{number}", "is a binary OFF file", "save it as text, or as PLY")
    if len(words) == 1:
        number, words = next(lines, (number, []))
    else:
        words = words[1:]
    counts = integers(words[:2])
    if counts is None or len(counts) < 2 or min(counts) < 0:
        what = f"{quoted(words)} must be the numbers of vertices, faces and edges"
        raise refusal(f"{name}:{number}", what)
    return counts[0], counts[1]


def _face(where: str, words: list[str]) -> list[int]:
    count = integers(words[:1])
    if count is None or not 3 <= count[0] <= len(words) - 1:
        what = "the first number must say how many corners follow, 3 or more"
        raise refusal(where, f"{quoted(words)} is no face: {what}")
    face = integers(words[1 : count[0] + 1])
    if face is None:
        raise refusal(where, f"{quoted(words)} is no face: its corners must be integers")
    return face
