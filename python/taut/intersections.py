"""Where cloth intersects bodies, other cloth or itself."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple


class Intersection(NamedTuple):
    """A place where cloth intersects something."""

    cloth: str
    """Its name."""
    other: str
    """Name of what it intersects: of a body, of another cloth, or of the same one."""
    kind: Literal["cloth", "body"]
    """What that is."""
    fault: Literal["crosses", "inside"]
    """``crosses``: an edge of one passes through a triangle of the other, or touches it, or two links of
    networks touch exactly. ``inside``: a vertex is inside of a closed surface or behind a plane, or a
    triangle or a link comes into a sphere or a capsule."""
    vertex: int
    """The nearest vertex of the cloth, index into :attr:`taut.Simulation.positions`."""
    position: tuple[float, float, float]
    """Where, in the world [m]."""
    depth: float | None
    """How deep inside of a sphere or a capsule or behind a plane [m]; ``None``: unknown."""


@dataclass(frozen=True, slots=True)
class Intersections:
    """What intersects at a moment."""

    count: int
    """How many places there are [1]."""
    places: tuple[Intersection, ...]
    """The first of them, at most 100 of each pair of things."""

    def __bool__(self) -> bool:
        """Whether there is any place."""
        return self.count > 0


def intersections_of(count: int, places: Iterable[tuple[Any, ...]]) -> Intersections:
    """From what the engine tells."""
    told = (
        Intersection(cloth, other, kind, fault, vertex, (position[0], position[1], position[2]), depth)
        for cloth, other, kind, fault, vertex, position, depth in places
    )
    return Intersections(count, tuple(told))
