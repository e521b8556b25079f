"""Bodies as a page draws them: triangles, planes as large squares, the floor as a height."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.bodies import Body, Skin, floor_of, quad_of

_REACH = 1.5
"""Half the side of the square that stands for a plane, in diagonals of the cloth."""

_CORNERS = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


class Solids:
    """What does not change of the bodies of a scene; and their places at any moment."""

    def __init__(self, bodies: Mapping[str, Body], rest: NDArray[np.floating], up: int) -> None:
        """Look at bodies as they are at the start.

        Args:
            bodies: by name.
            rest: positions of the cloth's vertices at the start [m].
            up: the axis that points up.
        """
        low, high = rest.min(axis=0), rest.max(axis=0)
        self._middle, size = (low + high) / 2, max(float(np.linalg.norm(high - low)), 0.1)
        self._reach = _REACH * size
        floor = floor_of(bodies.values(), np.eye(3)[up], float(low[up]), 2 * size)
        self.floor_name = None if floor is None else floor.name
        """Its name."""
        self.floor = None if floor is None else float(floor.positions[0, up])
        """Height of the plane on which all stands [m], if there is one; it is not among the squares."""
        solid = [body for body in bodies.values() if body.shape != "plane"]
        self._skins = {body.name: Skin(body) for body in solid}
        self._planes = [body.name for body in bodies.values() if body.shape == "plane" and body is not floor]
        self.moves = any(bodies[name].moves for name in (*self._skins, *self._planes))
        """Whether anything of it may move."""
        counts = [len(skin.points(bodies[name])) for name, skin in self._skins.items()]
        firsts = np.concatenate([[0], np.cumsum(counts)])[:-1].astype(np.int32)
        numbers = {name: number for number, name in enumerate(bodies)}
        self.parts = [(numbers[name], len(skin.faces)) for name, skin in self._skins.items()]
        """Number of a body, and how many of the triangles are its own, for one body after the other."""
        self.square_parts = [(numbers[name], len(_CORNERS)) for name in self._planes]
        """The same of the squares."""
        faces = [skin.faces + first for skin, first in zip(self._skins.values(), firsts, strict=True)]
        self.faces: NDArray[np.int32] = _joined(faces, np.int32)
        """Triangles, counter-clockwise seen from outside, shape (faces, 3)."""
        squares = [_CORNERS + 4 * number for number in range(len(self._planes))]
        self.square_faces: NDArray[np.int32] = _joined(squares, np.int32)
        """Triangles of the squares, counter-clockwise seen from where planes face, shape (faces, 3)."""

    def points(self, bodies: Mapping[str, Body]) -> NDArray[np.float32]:
        """Where the corners of the triangles are [m], shape (points, 3)."""
        return _joined([skin.points(bodies[name]) for name, skin in self._skins.items()], np.float32)

    def squares(self, bodies: Mapping[str, Body]) -> NDArray[np.float32]:
        """Where the corners of the squares are [m], shape (points, 3)."""
        found = [quad_of(bodies[name], self._middle, self._reach) for name in self._planes]
        return _joined(found, np.float32)

    def arrays(self, bodies: Mapping[str, Body], index: int) -> dict[str, NDArray[np.float32]]:
        """Both, and the middles of all bodies, with the names that they have in messages to the page."""
        middles = [body.positions.mean(axis=0, keepdims=True) for body in bodies.values()]
        return {
            f"solids{index}": self.points(bodies),
            f"squares{index}": self.squares(bodies),
            f"middles{index}": _joined(middles, np.float32),
        }


def _joined(rows: Sequence[NDArray[Any]], kind: type[np.generic]) -> NDArray[Any]:
    return np.concatenate([np.zeros((0, 3)), *rows]).astype(kind)
