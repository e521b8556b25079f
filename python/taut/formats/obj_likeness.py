"""What a user's own OBJ file says besides vertices, to be written again round vertices that have moved."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.formats.obj_reader import logical_lines, opened, read_obj
from taut.formats.writing import ExportError

_KEPT = ("g", "o", "s", "usemtl", "mtllib", "f", "fo")
"""Groups, objects, smoothing, materials and faces; in the order of the file, after all vertices."""


class Likeness:
    """Texture coordinates, groups, materials and faces of a file, and its normals for any places.

    Corners keep the normals that they share: each is the mean of its faces, by area, where they are now.
    """

    def __init__(self, path: Path, vertices: int, before: tuple[int, int, int]) -> None:
        """Read the file.

        Args:
            path: of the OBJ file.
            vertices: how many it must have.
            before: vertices, texture coordinates and normals that are written before those of this file.

        Raises:
            ExportError: it is not there, or has another number of vertices, or a corner that names a texture
                coordinate or a normal which is not there.
            MeshError: it cannot be read.
        """
        if not path.is_file():
            raise ExportError(f"like: there is no file {path}; name the OBJ file that the scene was run with")
        mesh = read_obj(path)
        if len(mesh.vertices) != vertices:
            raise ExportError(
                f"{path}: has {len(mesh.vertices)} vertices, the cloth {vertices}; name the OBJ file that "
                "the scene was run with"
            )
        self._path, self._before = path, before
        self._corners, self._counts = mesh.corners, mesh.counts
        self._normals: list[int] = []
        self.texture = ""
        """Its lines of texture coordinates."""
        self.elements = ""
        """Its groups, materials and faces, with numbers as they are in all of the file that is written."""
        self._seen = [0, 0, 0]
        self._read()
        self.counts = self._seen[1], self._seen[2]
        """How many texture coordinates and normals it has."""
        for at, name in ((1, "texture coordinate"), (2, "normal")):
            if self._most[at] > self._seen[at]:
                raise ExportError(f"{path}: a face names {name} {self._most[at]} of {self._seen[at]}")

    def _read(self) -> None:
        texture, elements, corners = [], [], iter(self._corners.tolist())
        self._most = [0, 0, 0]
        with opened(self._path) as file:
            for _, line in logical_lines(file):
                words = line.split()
                if not words:
                    continue
                if words[0] in ("v", "vt", "vn"):
                    self._seen[("v", "vt", "vn").index(words[0])] += 1
                    texture += [f"{' '.join(words)}\n"] if words[0] == "vt" else []
                elif words[0] in ("f", "fo"):
                    faces = [self._corner(word, next(corners)) for word in words[1:]]
                    elements.append(f"f {' '.join(faces)}\n")
                elif words[0] in _KEPT:
                    elements.append(f"{' '.join(words)}\n")
        self.texture, self.elements = "".join(texture), "".join(elements)

    def _corner(self, word: str, vertex: int) -> str:
        """A corner of a face, its numbers from 1."""
        parts = [str(vertex + 1 + self._before[0])]
        own = [*word.split("/")[1:], "", ""][:2]
        for at, text in enumerate(own, start=1):
            number = self._number(text, at)
            if at == 2:
                self._normals.append(number - 1)
            parts.append(str(number + self._before[at]) if number else "")
        return "/".join(parts).rstrip("/")

    def _number(self, text: str, at: int) -> int:
        """A number from 1, or 0 where there is none; those below 0 count back from what came so far."""
        try:
            given = int(text or 0)
        except ValueError:
            given = -1 - self._seen[at]
        number = given + self._seen[at] + 1 if given < 0 else given
        if number < (1 if text else 0):
            raise ExportError(f"{self._path}: a face has {text!r} where a number from 1 is allowed")
        self._most[at] = max(self._most[at], number)
        return number

    def normals(self, places: NDArray[np.floating]) -> NDArray[np.float64]:
        """Its normals round vertices at these places, shape (normals, 3)."""
        corners, starts = self._corners, np.cumsum(self._counts) - self._counts
        after = np.arange(len(corners)) + 1
        after[starts + self._counts - 1] = starts
        points = places[corners].astype(np.float64) - places.mean(axis=0)
        faces = np.add.reduceat(np.cross(points, points[after]), starts, axis=0)
        named = np.array(self._normals)
        given = named >= 0
        sums = np.zeros((self.counts[1], 3))
        np.add.at(sums, named[given], np.repeat(faces, self._counts, axis=0)[given])
        length = np.linalg.norm(sums, axis=1, keepdims=True)
        # A normal that no face has, or of faces without area, points up.
        return np.where(length > 0, sums / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])
