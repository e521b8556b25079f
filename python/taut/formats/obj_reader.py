"""Wavefront OBJ: vertices and polygons exactly as they stand in the file.

General readers split a vertex where materials or texture coordinates meet, and cut or drop polygons. Cloth
needs neither: here a vertex is a ``v`` line, in order. Materials, textures, normals, groups, curves and
anything unknown are passed over; no other file is ever opened.
"""

from array import array
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from taut.formats.polygons import MeshError, Polygons
from taut.formats.text import quoted

_BYTE_ORDER_MARK = "\xef\xbb\xbf"  # of UTF-8, read as Latin-1
_READ = ("v", "f", "fo")  # fo: the old name of f


def read_obj(path: Path) -> Polygons:
    """Read a Wavefront OBJ file.

    Raises:
        MeshError: the file and line, what is wrong there and what is allowed.
    """
    with opened(path) as file:
        return _Reader(str(path)).read(file)


def read_obj_vertices(path: Path) -> NDArray[np.float64]:
    """Read the vertices of a Wavefront OBJ file alone, shape (vertices, 3), whether it has faces or none.

    Raises:
        MeshError: the file and line, what is wrong there and what is allowed.
    """
    with opened(path) as file:
        return _Reader(str(path), ("v",)).read_vertices(file)


def opened(path: Path) -> TextIO:
    """An OBJ file as text, whatever its encoding."""
    with path.open("rb") as binary:
        if b"\0" in binary.read(4096):
            raise MeshError(f"{path}: is no text file (or one in UTF-16); save it as OBJ in UTF-8 or ASCII")
    # Latin-1 decodes every byte: names in comments and groups may be in any encoding.
    return path.open(encoding="latin-1")


class _Reader:
    """The numbers read so far; flat arrays, so that memory stays near the size of the file."""

    def __init__(self, name: str, keywords: tuple[str, ...] = _READ) -> None:
        self.name = name
        self.keywords = keywords
        self.coordinates = array("d")
        self.corners = array("q")
        self.counts = array("q")
        self.vertex_lines = array("q")
        self.face_lines = array("q")

    def read(self, lines: Iterable[str]) -> Polygons:
        vertices = self.read_vertices(lines)
        return Polygons(vertices, self._checked_corners(len(vertices)), _integers(self.counts))

    def read_vertices(self, lines: Iterable[str]) -> NDArray[np.float64]:
        """Read everything; return the vertices."""
        for number, line in logical_lines(lines):
            words = line.split()
            if not words or words[0] not in self.keywords:
                continue
            if "_" in line:  # Python's own grouping of digits, which no OBJ has
                raise self._error(number, "an underscore is no part of a number")
            if words[0] == "v":
                self._vertex(number, words)
            else:
                self._face(number, words)
        return self._checked_vertices()

    def _vertex(self, number: int, words: list[str]) -> None:
        # A fourth number is a weight of curves, more are colours: neither moves a vertex.
        if len(words) < 4:
            raise self._error(number, f"a vertex needs 3 coordinates, this line has {len(words) - 1}")
        try:
            self.coordinates.extend(map(float, words[1:4]))
        except ValueError:
            raise self._error(number, f"not a vertex: {quoted(words)} must be numbers") from None
        self.vertex_lines.append(number)

    def _face(self, number: int, words: list[str]) -> None:
        if len(words) < 4:
            raise self._error(number, f"a face needs 3 corners or more, this line has {len(words) - 1}")
        try:
            indices = [int(word.partition("/")[0]) for word in words[1:]]
        except ValueError:
            raise self._error(
                number, f"not a face: {quoted(words)} must be integers, as in 3 or 3/1/2"
            ) from None
        if min(indices) < 0:
            indices = [self._counted_back(index, number) for index in indices]
        try:
            self.corners.extend(indices)
        except OverflowError:
            raise self._error(number, "a face index is too large") from None
        self.counts.append(len(indices))
        self.face_lines.append(number)

    def _counted_back(self, index: int, number: int) -> int:
        """Turn a negative index, counted back from the last vertex so far, into one from 1."""
        seen = len(self.vertex_lines)
        if index < -seen:
            raise self._error(number, _out_of_range(index, seen, " before this line"))
        return index + seen + 1 if index < 0 else index

    def _checked_vertices(self) -> NDArray[np.float64]:
        vertices = np.array(self.coordinates, dtype=np.float64).reshape(-1, 3)
        if len(vertices) == 0:
            raise MeshError(f"{self.name}: holds no vertices (no line `v x y z`)")
        bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
        if bad.size:
            coordinates = " ".join(map(str, vertices[bad[0]]))
            raise self._error(self.vertex_lines[bad[0]], f"vertex {coordinates} is not finite")
        return vertices

    def _checked_corners(self, vertices: int) -> NDArray[np.int64]:
        corners = _integers(self.corners)
        if len(corners) == 0:
            raise MeshError(f"{self.name}: holds no faces (no line `f a b c`)")
        bad = np.flatnonzero((corners < 1) | (corners > vertices))
        if bad.size:
            face = int(np.searchsorted(np.cumsum(_integers(self.counts)), bad[0], side="right"))
            line = self.face_lines[face]
            raise self._error(line, _out_of_range(int(corners[bad[0]]), vertices, ""))
        return corners - 1

    def _error(self, line: int, text: str) -> MeshError:
        return MeshError(f"{self.name}:{line}: {text}")


def logical_lines(lines: Iterable[str]) -> Iterator[tuple[int, str]]:
    r"""Number the lines from 1, join those that end with a backslash, cut comments."""
    pending, first = "", 0
    for number, line in enumerate(lines, start=1):
        if number == 1:
            line = line.removeprefix(_BYTE_ORDER_MARK)
        if "\\" in line and line.rstrip().endswith("\\"):
            pending += line.rstrip()[:-1] + " "
            first = first or number
            continue
        if pending:
            line = pending + line
        if "#" in line:
            line = line.partition("#")[0]
        yield first or number, line
        pending, first = "", 0
    yield first, pending


def _out_of_range(index: int, vertices: int, where: str) -> str:
    allowed = f": allowed are 1 to {vertices}, or -1 to -{vertices} counted back" if vertices else ""
    return f"face index {index} is out of range, the file has {vertices} vertices{where}{allowed}"


def _integers(values: "array[int]") -> NDArray[np.int64]:
    return np.array(values, dtype=np.int64)
