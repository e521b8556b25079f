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
