"""What touches: the corners, edges and triangles of all cloths and bodies, and the pairs of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.compare.contact.boxes import Boxes, Indices, boxes_of, overlapping
from taut.compare.contact.distance import Mask, Numbers


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pairs of features that share no vertex: a point and a triangle, or two edges."""

    corners: Indices
    """Point and triangle, or both edges, as vertices; shape (n, 4)."""
    edges: Mask
    """Whether each is two edges, shape (n,)."""
    thickness: Numbers
    """How far they shall stay apart [m], shape (n,)."""
    friction: Numbers
    """Coulomb's coefficient [1], shape (n,)."""

    def __len__(self) -> int:
        """How many there are."""
        return len(self.edges)

    def of(self, rows: Indices | Mask) -> "Pairs":
        """Some of them."""
        return Pairs(self.corners[rows], self.edges[rows], self.thickness[rows], self.friction[rows])

    def with_any(self, vertices: Mask) -> "Pairs":
        """Those with any of these vertices, shape (vertices,)."""
        return self if vertices.all() else self.of(np.flatnonzero(vertices[self.corners].any(axis=1)))


class World:
    """Triangles of cloths and bodies; the vertices of cloths come first."""

    def __init__(self, faces: Indices, light: Numbers, half: Numbers, friction: Numbers, cloth: int) -> None:
        """Of triangles.

        Args:
            faces: triangles of cloths, then of bodies, shape (m, 3).
            light: inverse mass of each vertex [1/kg], 0 for what cannot be moved; shape (n,).
            half: how far each vertex keeps others off by itself [m], shape (n,).
            friction: Coulomb's coefficient of each vertex [1], shape (n,).
            cloth: how many of the vertices are cloth.
        """
        sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        self.faces: Indices = faces
        self.edges: Indices = np.unique(sides, axis=0)
        self.light, self.half, self.friction, self.cloth = light, half, friction, cloth
        used = np.unique(faces)
        self._own, self._others = used[used < cloth, None], used[used >= cloth, None]
        self._own_faces = faces[faces[:, 0] < cloth]
        self._own_edges = self.edges[self.edges[:, 0] < cloth]

    def pairs(self, margin: float, *moments: Numbers) -> Pairs:
        """All pairs that may come nearer than their thickness, or than a margin.

        Two features of bodies are no pair, nor is what cannot be moved on either side.

        Args:
            margin: added to the boxes around all moments, on all sides [m].
            moments: places of all vertices [m], each of shape (n, 3).
        """
        found = [
            self._kind(self._own, self.faces, margin, moments),
            self._kind(self._others, self._own_faces, margin, moments),
            self._kind(self._own_edges, self.edges, margin, moments),
        ]
        corners = np.concatenate(found)
        edges = np.repeat([False, True], [len(found[0]) + len(found[1]), len(found[2])])
        first, second = corners[:, 0], corners[:, 3]
        thickness = self.half[first] + self.half[second]
        friction = np.sqrt(self.friction[first] * self.friction[second])
        return Pairs(corners, edges, thickness, friction)

    def _kind(self, a: Indices, b: Indices, margin: float, moments: tuple[Numbers, ...]) -> Indices:
        """Pairs of one kind: corners of both, shape (n, 4)."""
        boxes = [self._boxes(corners, margin, moments) for corners in (a, b)]
        i, j = overlapping(boxes[0], boxes[1])
        if a is self._own_edges:
            # The edges of cloths are the first of all, in the same order: each pair of them once.
            kept = i < j
            i, j = i[kept], j[kept]
        found = np.concatenate([a[i], b[j]], axis=1)
        split = a.shape[1]
        alone = np.ones(len(found), np.bool_)
        for first in range(split):
            for second in range(split, 4):
                alone &= found[:, first] != found[:, second]
        alone &= self.light[found].any(axis=1)
        return np.asarray(found[alone])

    def _boxes(self, corners: Indices, margin: float, moments: tuple[Numbers, ...]) -> Boxes:
        low, high = boxes_of(corners, *moments)
        wide = self.half[corners].max(axis=1, keepdims=True) + margin
        return low - wide, high + wide


class Nearby:
    """Pairs that may meet on the way of a step, whose end changes while a method works on it."""

    def __init__(self, world: World, start: Numbers, end: Numbers) -> None:
        """Of all vertices at the start and at the end of a step [m], shape (n, 3)."""
        self._world, self._start = world, start
        self._find(end)

    def _find(self, end: Numbers) -> None:
        self._pairs = self._world.pairs(0.0, self._start, end)
        self._low, self._high = np.minimum(self._start, end), np.maximum(self._start, end)

    def pairs(self, end: Numbers) -> Pairs:
        """Pairs that may meet on the way to an end, among them all that are too near at the start.

        They are looked for anew where a vertex goes further beyond the way for which they were found than the
        boxes around it reach.
        """
        reach = self._world.half[:, None]
        if (end < self._low - reach).any() or (end > self._high + reach).any():
            self._find(end)
        return self._pairs


def components(count: int, links: NDArray[np.int64]) -> Indices:
    """Label of each of so many things, the least of those that links join it to; shape (count,).

    Args:
        count: how many things there are.
        links: pairs of things, shape (n, 2).
    """
    labels = np.arange(count)
    while True:
        least = labels[links].min(axis=1)
        before = labels.copy()
        for side in (0, 1):
            np.minimum.at(labels, links[:, side], least)
        labels = labels[labels]
        if (labels == before).all():
            return labels
