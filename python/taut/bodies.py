"""What cloth collides with: spheres, capsules, planes and surfaces of triangles, as they are at a moment."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, cast, get_args

import numpy as np
from numpy.typing import NDArray

Shape = Literal["sphere", "capsule", "plane", "surface"]
"""What the vertices of a body mean: see :attr:`Body.positions`."""


@dataclass(frozen=True, eq=False)
class Body:
    """A body of a scene at a moment."""

    name: str
    shape: Shape
    """``sphere``, ``capsule``, ``plane`` or ``surface``: boxes and meshes are surfaces."""
    radius: float
    """Of a sphere or a capsule [m]; otherwise 0."""
    positions: NDArray[np.floating]
    """Its vertices in the world [m], shape (vertices, 3): the middle of a sphere; both ends of the line of a
    capsule; a point of a plane, and the point 1 m from there along its normal; the corners of a surface."""
    triangles: NDArray[np.int32]
    """Of a surface, counter-clockwise seen from outside, shape (triangles, 3), read-only: vertices counted
    from its first. None unless it is a surface."""
    moves: bool = False
    """Whether the scene lets it move."""


class BodyRange(NamedTuple):
    """Where a body's vertices and triangles lie among those of all bodies."""

    name: str
    shape: str
    radius: float
    """[m]"""
    moves: bool
    """Whether the scene lets it move."""
    first_vertex: int
    vertices: int
    first_triangle: int
    triangles: int

    def check(self, vertices: int, triangles: int) -> None:
        """Make sure that it is a body among so many vertices and triangles.

        Raises:
            ValueError: it is not.
        """
        counts = self[4:]
        if any(type(count) is not int or count < 0 for count in counts) or type(self.moves) is not bool:
            raise ValueError(f"{self!r} is no body")
        if self.shape not in get_args(Shape) or not float(self.radius) >= 0:
            raise ValueError(f"{self!r} is no body")
        least = {"sphere": 1, "capsule": 2, "plane": 2}.get(self.shape, 0)
        if self.vertices < least or self.first_vertex + self.vertices > vertices:
            raise ValueError(f"{self!r} has vertices that are not there")
        if self.first_triangle + self.triangles > triangles:
            raise ValueError(f"{self!r} has triangles that are not there")


def bodies_at(
    ranges: Iterable[BodyRange], positions: NDArray[np.floating], triangles: NDArray[np.int32]
) -> Mapping[str, Body]:
    """Bodies by name, in the scene's order.

    Args:
        ranges: which they are.
        positions: of the vertices of all of them [m], shape (n, 3).
        triangles: of all of them, vertices counted over all bodies, shape (m, 3).
    """
    found = {}
    for one in ranges:
        own = triangles[one.first_triangle : one.first_triangle + one.triangles] - one.first_vertex
        own.flags.writeable = False
        places = positions[one.first_vertex : one.first_vertex + one.vertices]
        found[one.name] = Body(one.name, cast(Shape, one.shape), one.radius, places, own, one.moves)
    return MappingProxyType(found)


def normal_of(plane: Body) -> NDArray[np.float64]:
    """Which way a plane faces: a vector of length 1."""
    start, end = plane.positions.astype(np.float64)
    return np.asarray((end - start) / np.linalg.norm(end - start))


def is_level(body: Body, up: NDArray[np.floating]) -> bool:
    """Whether a body is a plane that lies still and faces up."""
    return body.shape == "plane" and not body.moves and bool(normal_of(body) @ up > _LEVEL)


def floor_of(bodies: Iterable[Body], up: NDArray[np.floating], lowest: float, reach: float) -> Body | None:
    """The highest level plane near the lowest of all heights, if there is one.

    Args:
        bodies: among which it may be.
        up: the way up, of length 1.
        lowest: height of the lowest point of all motion [m]; it may be a little below the floor.
        reach: how far from there the floor may be [m].
    """
    levels = [body for body in bodies if is_level(body, up)]
    near = [body for body in levels if abs(float(body.positions[0] @ up) - lowest) <= reach]
    return max(near, key=lambda body: float(body.positions[0] @ up), default=None)


def quad_of(plane: Body, middle: NDArray[np.floating], reach: float) -> NDArray[np.float64]:
    """Corners of a square part of a plane, counter-clockwise seen from where it faces, shape (4, 3).

    Args:
        plane: the body.
        middle: the square lies round the point of the plane that is nearest to here [m].
        reach: half of its side [m].
    """
    across = normal_of(plane)
    point = plane.positions[0].astype(np.float64)
    foot = middle - across * ((middle - point) @ across)
    first, second, _ = _frame(across)
    return np.stack(
        [foot + reach * (a * first + b * second) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    )


class Skin:
    """A body as triangles for pictures: round ones smooth, edges sharp. Its faces never change."""

    def __init__(self, body: Body) -> None:
        """Of any body but a plane; edges are sharp that are so now."""
        self.faces: NDArray[np.int32]
        """Triangles, counter-clockwise seen from outside, shape (faces, 3)."""
        if body.shape == "surface":
            self.faces, self._source = _creased(body.positions.astype(np.float64), body.triangles)
            self._out = np.zeros((len(self._source), 3))
        else:
            self.faces, self._source, self._out = _round(two_ends=body.shape == "capsule")

    def points(self, body: Body) -> NDArray[np.float64]:
        """Where the corners of the faces are [m], shape (points, 3), for the same body at any moment."""
        places = body.positions.astype(np.float64)
        out = self._out
        if body.shape == "capsule":
            out = out @ np.stack(_frame(places[1] - places[0]))
        return np.asarray(places[self._source] + body.radius * out)


_PARTS, _RINGS = 48, 12  # of a round body: all round, and from its equator to a pole
_SHARP = np.cos(np.radians(40.0))
"""Faces that meet at a greater angle than this meet in an edge."""

_LEVEL = 0.99999  # cosine of the slope of a plane that is level

_Round = tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.float64]]


def _round(two_ends: bool) -> _Round:
    """Faces of a sphere or of a capsule along z; of each point its end, and its direction from there."""
    quarter = np.linspace(0, np.pi / 2, _RINGS + 1)
    # A capsule has two equators, one at each end.
    heights = np.concatenate([-quarter[1:-1][::-1], np.zeros(1 + two_ends), quarter[1:-1]])
    turns = np.arange(_PARTS) * (2 * np.pi / _PARTS)
    flat, up = np.cos(heights)[:, None], np.broadcast_to(np.sin(heights)[:, None], (len(heights), _PARTS))
    rings = np.stack([flat * np.cos(turns), flat * np.sin(turns), up], axis=-1).reshape(-1, 3)
    out = np.concatenate([[[0.0, 0.0, -1.0]], rings, [[0.0, 0.0, 1.0]]])
    here = 1 + np.arange(len(rings)).reshape(len(heights), _PARTS)
    ahead = np.roll(here, -1, axis=1)
    a, b, c, d = here[:-1], ahead[:-1], ahead[1:], here[1:]
    bottom = np.stack([np.zeros(_PARTS, np.int64), ahead[0], here[0]], axis=-1)
    top = np.stack([here[-1], ahead[-1], np.full(_PARTS, len(out) - 1)], axis=-1)
    sides = [np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))]
    faces = np.concatenate([bottom, *sides, top]).astype(np.int32)
    source = np.zeros(len(out), np.int64)
    if two_ends:
        source[len(out) // 2 :] = 1
    return faces, source, out


def _creased(
    places: NDArray[np.float64], triangles: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Triangles that share corners only where they meet smoothly, and the vertex of each such corner."""
    corners = places[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
    # The sides of all triangles as pairs of corners, which are counted over all of them; lower vertex first.
    numbers = np.arange(triangles.size).reshape(-1, 3)
    ends = np.stack([numbers, np.roll(numbers, -1, axis=1)], axis=-1).reshape(-1, 2)
    named = triangles.ravel()[ends]
    ends = np.where((named[:, 0] > named[:, 1])[:, None], ends[:, ::-1], ends)
    named = np.sort(named, axis=1)
    order = np.lexsort((named[:, 1], named[:, 0]))
    one, other = order[:-1], order[1:]
    smooth = (named[one] == named[other]).all(axis=1)
    smooth &= (across[one // 3] * across[other // 3]).sum(axis=1) > _SHARP
    joined = np.stack([ends[one[smooth]].ravel(), ends[other[smooth]].ravel()])
    labels = np.arange(triangles.size)
    while True:
        least = labels[joined].min(axis=0)
        before = labels.copy()
        for row in joined:
            np.minimum.at(labels, row, least)
        if (labels == before).all():
            break
    kept, faces = np.unique(labels, return_inverse=True)
    return faces.reshape(-1, 3).astype(np.int32), triangles.ravel()[kept].astype(np.int64)


def _frame(z: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Three directions at right angles, right-handed, the last one along `z`."""
    length = float(np.linalg.norm(z))
    z = z / length if length > 0 else np.array([0.0, 0.0, 1.0])
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return x, np.cross(z, x), z
