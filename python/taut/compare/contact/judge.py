"""What is wrong at a moment: seen by a test of its own, which no method uses.

Two triangles without a common vertex intersect if an edge of one passes through the other. A segment passes
through a triangle if its ends lie on different sides of it, and all three sides of the triangle are turned
around the segment in the same sense. These are five signs of triple products, in double precision, with no
distance and no time.
"""

from dataclasses import dataclass

import numpy as np

from taut.bodies import normal_of
from taut.compare.contact.boxes import Indices, boxes_of, overlapping
from taut.compare.contact.distance import Mask, Numbers, between, closest, cross, dot
from taut.compare.contact.surfaces import faces_of, points_of
from taut.compare.contact.world import World, components
from taut.simulation import Simulation


@dataclass(frozen=True, slots=True)
class Seen:
    """What there is to see at a moment."""

    crossings: int
    """Edges that pass through triangles [1]."""
    inside: int
    """Vertices of cloth inside of closed bodies or behind planes [1]; looked for where nothing crosses."""
    closest: float
    """Least distance of two features over their thickness [1], as far as the thickness; 0 where they cross.
    Features within two edges of each other do not count."""

    @property
    def intersects(self) -> bool:
        """Whether anything is wrong."""
        return self.crossings > 0 or self.inside > 0


class Judge:
    """Looks at a run again and again."""

    def __init__(self, world: World, bodies: Simulation) -> None:
        """Of a world, and the simulation that tells where bodies are."""
        self._world, self._bodies = world, bodies
        links = world.edges[(world.edges < world.cloth).all(axis=1)]
        labels = components(world.cloth, links)
        self._pieces = np.unique(labels)
        self._near = _within_two(world.edges, len(world.light))

    def look(self, places: Numbers) -> Seen:
        """What is wrong with places of all vertices [m], shape (n, 3)."""
        crossings = count_crossings(self._world, places)
        inside = 0 if crossings else self._inside(places)
        return Seen(crossings, inside, 0.0 if crossings else self._closest(places))

    def _inside(self, places: Numbers) -> int:
        """A piece of cloth that crosses no closed surface is inside or outside as a whole."""
        cloth = places[: self._world.cloth]
        found = 0
        for body in self._bodies.bodies.values():
            if body.shape == "plane":
                found += int(np.count_nonzero((cloth - body.positions[0]) @ normal_of(body) < 0))
                continue
            faces, points = faces_of(body), points_of(body)
            sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
            closed = (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
            if closed:
                found += sum(abs(winding(point, points[faces])) > 0.5 for point in cloth[self._pieces])
        return found

    def _closest(self, places: Numbers) -> float:
        pairs = self._world.pairs(0.0, places)
        near = np.zeros(len(pairs), np.bool_)
        for i, j in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3)):
            first, second = pairs.corners[:, i], pairs.corners[:, j]
            codes = np.minimum(first, second) * len(places) + np.maximum(first, second)
            # Of a point and a triangle the point is the first, of edges both ends are.
            counts = ~pairs.edges if j == 1 and i == 0 else pairs.edges | (i == 0)
            near |= counts & np.isin(codes, self._near)
        pairs = pairs.of(~near)
        if not len(pairs):
            return 1.0
        corners = places[pairs.corners]
        apart = between(closest(corners, pairs.edges), corners)
        return float(min(1.0, (np.sqrt(dot(apart, apart)) / pairs.thickness).min()))


def count_crossings(world: World, places: Numbers) -> int:
    """Edges that pass through triangles with which they share no vertex, one of them of a cloth [1]."""
    found = 0
    cloth = world.edges[:, 0] < world.cloth
    own = world.faces[world.faces[:, 0] < world.cloth]
    for edges, faces in ((world.edges[cloth], world.faces), (world.edges[~cloth], own)):
        i, j = overlapping(boxes_of(edges, places), boxes_of(faces, places))
        alone = (edges[i][:, :, None] != faces[j][:, None, :]).all(axis=(1, 2))
        i, j = i[alone], j[alone]
        found += int(np.count_nonzero(passes_through(places[edges[i]], places[faces[j]])))
    return found


def passes_through(segments: Numbers, triangles: Numbers) -> Mask:
    """Whether segments, shape (n, 2, 3), pass through triangles, shape (n, 3, 3)."""
    p, q = segments[:, 0], segments[:, 1]
    a, b, c = (triangles[:, corner] for corner in range(3))
    normal = cross(b - a, c - a)
    sides = np.sign(dot(normal, p - a)) * np.sign(dot(normal, q - a)) < 0
    way = q - p
    turns = np.stack(
        [np.sign(dot(cross(first - p, second - p), way)) for first, second in ((a, b), (b, c), (c, a))]
    )
    return np.asarray(sides & ((turns > 0).all(axis=0) | (turns < 0).all(axis=0)))


def winding(point: Numbers, triangles: Numbers) -> float:
    """How often triangles, shape (n, 3, 3), go around a point, shape (3,) [1]: 1 inside of a closed surface.

    The solid angles of [VanOosterom83], over the whole sphere.
    """
    a, b, c = (triangles[:, corner] - point for corner in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return float(2.0 * np.arctan2(dot(a, cross(b, c)), below).sum() / (4.0 * np.pi))


def _within_two(edges: Indices, count: int) -> Indices:
    """Codes of pairs of vertices that at most two edges join."""
    both = np.concatenate([edges, edges[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    begin = np.searchsorted(both[:, 0], np.arange(count + 1))
    many = np.diff(begin)[both[:, 1]]
    first = np.repeat(both[:, 0], many)
    rank = np.arange(len(first)) - np.repeat(np.cumsum(many) - many, many)
    second = both[np.repeat(begin[both[:, 1]], many) + rank, 1]
    ends = np.concatenate([both, np.stack([first, second], axis=1)])
    return np.unique(ends.min(axis=1) * count + ends.max(axis=1))
