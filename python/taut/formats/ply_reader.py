"""PLY, text and binary: tables of vertices, faces and anything else."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.formats.ply_header import Element, Header, read_header
from taut.formats.polygons import Integers, Polygons, Vertices, refusal
from taut.formats.text import lines_of, quoted, reals
from taut.formats.triangles import cut

_CORNERS = ("vertex_indices", "vertex_index")


def read_ply(name: str, data: bytes) -> Polygons:
    """Read a PLY file; all faces become triangles.

    Raises:
        MeshError: the file, the line or byte, what is wrong there and what is allowed.
    """
    header = read_header(name, data)
    tables = {element.name: element for element in header.elements}
    for title in ("vertex", "face"):
        if title not in tables:
            held = f"holds no {'vertices' if title == 'vertex' else 'faces'}"
            raise refusal(
                name, f"{held}, its head has no `element {title}`", "export the mesh with its faces"
            )
    vertex, face = tables["vertex"], tables["face"]
    if missing := {"x", "y", "z"} - {one.name for one in vertex.properties if one.count_kind is None}:
        raise refusal(
            name, f"its vertices have no property {', '.join(sorted(missing))}: must have x, y and z"
        )
    lists = [one.name for one in face.properties if one.count_kind is not None and one.kind[0] != "f"]
    named = [title for title in _CORNERS if title in lists] or lists
    if not named:
        raise refusal(name, f"its faces have no list of integers: must have a property {_CORNERS[0]}")
    read = _Text(name, header, data) if header.order == "" else _Binary(name, header, data)
    vertices, corners, counts = read.tables(named[0])
    return cut(name, vertices, corners, counts)


class _Text:
    """A line for each row."""

    def __init__(self, name: str, header: Header, data: bytes) -> None:
        self.name, self.header, self.data = name, header, data
        self.rows = self._lines()

    def _lines(self) -> Iterator[tuple[int, list[str]]]:
        return lines_of(self.data[self.header.size :])

    def tables(self, title: str) -> tuple[Vertices, Integers, Integers]:
        """Coordinates, corners and their counts."""
        places: list[list[float]] = []
        corners: list[int] = []
        counts: list[int] = []
        declared = sum(element.rows for element in self.header.elements)
        present = sum(1 for _ in self._lines())
        if present < declared:
            what = f"is cut short: its head declares {declared} rows, there are {present}"
            raise refusal(self.name, what)
        for element in self.header.elements:
            for where, words, numbers in self._rows(element):
                if element.name == "vertex":
                    found = self._split(element, where, words, numbers)
                    places.append([found[axis][0] for axis in "xyz"])
                elif element.name == "face":
                    face = self._split(element, where, words, numbers)[title]
                    corners += map(int, face)
                    counts.append(len(face))
        for number, words in self.rows:
            where = f"{self.name}:{self.header.lines + number}"
            raise refusal(where, f"there is more than the head declares: {quoted(words)}")
        vertices = np.array(places, dtype=np.float64).reshape(-1, 3)
        return vertices, np.array(corners, dtype=np.int64), np.array(counts, dtype=np.int64)

    def _rows(self, element: Element) -> Iterator[tuple[str, list[str], list[float]]]:
        for row in range(element.rows):
            number, words = next(self.rows)
            where = f"{self.name}:{self.header.lines + number}"
            numbers = reals(words)
            if numbers is None:
                raise refusal(
                    where, f"{quoted(words)} must be finite numbers: row {row} of {quoted([element.name])}"
                )
            yield where, words, numbers

    def _split(
        self, element: Element, where: str, words: list[str], numbers: list[float]
    ) -> dict[str, list[float]]:
        """The numbers of a row by property."""
        found: dict[str, list[float]] = {}
        start = 0
        for one in element.properties:
            size = 1
            if one.count_kind is not None:
                count = numbers[start] if start < len(numbers) else -1.0
                size, start = int(count), start + 1
                if size != count or size < 0:
                    raise refusal(
                        where, f"{quoted(words)}: {quoted([one.name])} must begin with its number of values"
                    )
            part = numbers[start : start + size]
            if len(part) < size:
                raise refusal(
                    where, f"{quoted(words)} is too short: {quoted([one.name])} has fewer values than it must"
                )
            if one.kind[0] != "f" and any(number != int(number) or abs(number) > 2**53 for number in part):
                raise refusal(where, f"{quoted(words)}: {quoted([one.name])} must be integers")
            found[one.name], start = part, start + size
        if start < len(numbers):
            raise refusal(where, f"{quoted(words)} is too long: {start} values were expected")
        return found


class _Binary:
    """Rows one after the other, without gaps."""

    def __init__(self, name: str, header: Header, data: bytes) -> None:
        self.name, self.header, self.data, self.at = name, header, data, header.size

    def tables(self, title: str) -> tuple[Vertices, Integers, Integers]:
        """Coordinates, corners and their counts."""
        vertices: Vertices = np.zeros((0, 3))
        corners = counts = np.zeros(0, dtype=np.int64)
        for element in self.header.elements:
            least = element.rows * sum(
                np.dtype(one.count_kind or one.kind).itemsize for one in element.properties
            )
            self._need(least, f"{element.rows} rows of {quoted([element.name])}")
            if element.rows == 0:
                continue
            sizes = self._first_sizes(element)
            table = self._alike(element, sizes)
            rows = [self._row(element) for _ in range(element.rows)] if table is None else []
            found: dict[str, Any] = {}
            for index, one in enumerate(element.properties):
                found[one.name] = [row[index] for row in rows] if table is None else table[f"value{index}"]
            if element.name == "vertex":
                columns = [np.array(found[axis], dtype=np.float64).reshape(-1) for axis in "xyz"]
                vertices = np.stack(columns, axis=-1)
            elif element.name == "face":
                counts = np.array([len(face) for face in found[title]], dtype=np.int64)
                corners = np.concatenate(list(found[title])).astype(np.int64)
        if self.at < len(self.data):
            more = f"{len(self.data) - self.at} bytes more than its head declares, from byte {self.at}"
            raise refusal(self.name, f"has {more}")
        return vertices, corners, counts

    def _need(self, size: int, what: str) -> None:
        left = len(self.data) - self.at
        if size > left:
            raise refusal(
                self.name,
                f"is cut short: {what} take {size} bytes from byte {self.at}, and {left} are left",
            )

    def _number(self, kind: str) -> Any:
        dtype = np.dtype(self.header.order + kind)
        self._need(dtype.itemsize, "the values of a row")
        number = np.frombuffer(self.data, dtype, 1, self.at)[0]
        self.at += dtype.itemsize
        return number

    def _size(self, kind: str) -> int:
        size = int(self._number(kind))
        if size < 0:
            raise refusal(self.name, f"a list at byte {self.at} has {size} values: must be 0 or more")
        return size

    def _row(self, element: Element) -> list[NDArray[Any]]:
        """The numbers of the row that comes next, by property."""
        found = []
        for one in element.properties:
            size = 1 if one.count_kind is None else self._size(one.count_kind)
            dtype = np.dtype(self.header.order + one.kind)
            self._need(size * dtype.itemsize, f"{size} values of {quoted([one.name])}")
            found.append(np.frombuffer(self.data, dtype, size, self.at))
            self.at += size * dtype.itemsize
        return found

    def _first_sizes(self, element: Element) -> list[int]:
        """How many numbers each property has in the first row."""
        before, row = self.at, self._row(element)
        self.at = before
        return [len(numbers) for numbers in row]

    def _alike(self, element: Element, sizes: list[int]) -> NDArray[Any] | None:
        """All rows at once, if they are all as long as the first one; else none, and nothing is taken."""
        parts: list[tuple[str, str, tuple[int, ...]]] = []
        for index, (one, size) in enumerate(zip(element.properties, sizes, strict=True)):
            if one.count_kind is not None:
                parts.append((f"count{index}", self.header.order + one.count_kind, ()))
            parts.append((f"value{index}", self.header.order + one.kind, (size,)))
        dtype = np.dtype(parts)
        if element.rows * dtype.itemsize > len(self.data) - self.at:
            return None
        table = np.frombuffer(self.data, dtype, element.rows, self.at)
        for index, (one, size) in enumerate(zip(element.properties, sizes, strict=True)):
            if one.count_kind is not None and (table[f"count{index}"] != size).any():
                return None
        self.at += element.rows * dtype.itemsize
        return table
