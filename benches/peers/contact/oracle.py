"""Who judges: the IPC Toolkit says what intersects, NumPy how deep cloth is in bodies; no engine has a say.

Both look at the written positions alone, in double precision.
"""

from dataclasses import dataclass

import ipctk
import numpy as np
from numpy.typing import NDArray

from contact.scenes import Ball, Body, Box, ContactSheet, Floor, Frames
from sheet import Indices, Reals

INSET = 1e-4
"""The toolkit's bodies are smaller by this [m], so that cloth that just touches one does not count."""
DIVISIONS = 5
"""Times that the sides of an icosahedron are halved for the ball: edges of 1 cm, on 0.06 mm."""


@dataclass(frozen=True, slots=True)
class Touch:
    """What a run did."""

    frames: int
    """Frames that were looked at, all of them finite [1]."""
    worst: float
    """Largest stretch of rows and columns in all of them [1]."""
    worst_everywhere: float
    """The same with the diagonals of the triangles [1]."""
    itself: int
    """Frames in which triangles of the cloth intersect each other [1]."""
    bodies: int
    """Frames in which triangles of the cloth intersect a body, or are below the floor [1]."""
    wrong: int
    """Frames in which either is so [1]."""
    depth: float
    """How deep a vertex or an edge was in a body at most [m]."""
    falls: list[float]
    """How far the centre of mass was below its start, frame by frame [m]."""
    finite: bool = True
    """Whether all frames were finite and near."""


class Oracle:
    """Looks at frames of a sheet."""

    def __init__(self, sheet: ContactSheet) -> None:
        """Of this cloth and the bodies of its scene."""
        self._sheet = sheet
        self._edges = ipctk.edges(sheet.triangles.astype(np.int32))
        self._cloth = _mesh(sheet.positions, sheet.triangles)
        shapes = [shape for body in sheet.bodies if (shape := surface(body)) is not None]
        self._shapes: Reals = np.concatenate([places for places, _ in shapes] or [np.empty((0, 3))])
        self._world = None
        if shapes:
            faces, first = [sheet.triangles], len(sheet.positions)
            for places, triangles in shapes:
                faces.append(triangles + first)
                first += len(places)
            self._world = _mesh(np.concatenate([sheet.positions, self._shapes]), np.concatenate(faces))
            groups = np.repeat([0, 1], [len(sheet.positions), len(self._shapes)])
            self._world.can_collide = ipctk.make_vertex_patches_filter(groups.astype(np.int32))

    def crosses_itself(self, positions: Reals) -> bool:
        """Whether triangles of the cloth intersect each other."""
        return bool(ipctk.has_intersections(self._cloth, np.asfortranarray(positions)))

    def crosses_bodies(self, positions: Reals) -> bool:
        """Whether triangles of the cloth intersect a ball or a box, or vertices are below a floor."""
        floors = [body for body in self._sheet.bodies if isinstance(body, Floor)]
        if any(depth(positions, self._edges, floor) > INSET for floor in floors):
            return True
        if self._world is None:
            return False
        places = np.asfortranarray(np.concatenate([positions, self._shapes]))
        return bool(ipctk.has_intersections(self._world, places))

    def measure(self, frames: Frames) -> Touch:
        """Judge a run, up to the first frame that is not finite or further than 1 km away."""
        sheet = self._sheet
        finite = [bool(np.isfinite(frame).all() and np.abs(frame).max() < 1e3) for frame in frames]
        count = finite.index(False) if False in finite else len(finite)
        worst = everywhere = deepest = 0.0
        itself = bodies = wrong = 0
        falls = []
        weights = sheet.masses / sheet.masses.sum()
        for frame in frames[:count]:
            worst = max(worst, _stretch(sheet.flat, frame, sheet.structural))
            everywhere = max(everywhere, worst, _stretch(sheet.flat, frame, sheet.diagonal))
            deepest = max([deepest, *(depth(frame, self._edges, body) for body in sheet.bodies)])
            folded, pierced = self.crosses_itself(frame), self.crosses_bodies(frame)
            itself, bodies, wrong = itself + folded, bodies + pierced, wrong + (folded or pierced)
            falls.append(round(float(weights @ (sheet.positions - frame)[:, 2]), 6))
        return Touch(count, worst, everywhere, itself, bodies, wrong, deepest, falls, count == len(frames))


def depth(positions: Reals, edges: Indices | NDArray[np.int32], body: Body) -> float:
    """How deep the deepest point of any edge, its ends included, is in a body [m]; 0 if none is.

    Args:
        positions: vertices [m], shape (vertices, 3).
        edges: pairs of them, shape (edges, 2).
        body: the body itself, not a mesh of it.

    Returns:
        The distance from there to the body's surface.
    """
    if isinstance(body, Floor):
        return max(0.0, body.height - float(positions[:, 2].min()))
    start, end = positions[edges[:, 0]], positions[edges[:, 1]]
    if isinstance(body, Ball):
        return max(0.0, body.radius - float(_distances(start, end, np.array(body.centre)).min()))
    return max(0.0, float(_in_box(start, end, body).max()))


def _distances(start: Reals, end: Reals, point: Reals) -> Reals:
    """Of segments from a point [m]."""
    way = end - start
    length = np.maximum((way**2).sum(axis=1), 1e-300)
    along = np.clip(((point - start) * way).sum(axis=1) / length, 0, 1)
    distances: Reals = np.linalg.norm(start + along[:, None] * way - point, axis=1)
    return distances


def _in_box(start: Reals, end: Reals, box: Box) -> Reals:
    """How deep the deepest point of each segment is in a box [m], negative if it is outside.

    Depth is the least of six functions that are linear along a segment, so it is largest at an end or where
    two of them are equal.
    """
    half = np.array(box.half)
    first, last = ((ends - np.array(box.centre)) @ box.axes for ends in (start, end))
    at_start = np.concatenate([half - first, half + first], axis=1)
    slopes = np.concatenate([half - last, half + last], axis=1) - at_start
    places = [np.zeros(len(start)), np.ones(len(start))]
    for a in range(6):
        for b in range(a):
            steep = slopes[:, a] - slopes[:, b]
            apart = at_start[:, b] - at_start[:, a]
            meets = np.divide(apart, steep, out=np.zeros_like(apart), where=np.abs(steep) > 1e-300)
            places.append(np.clip(meets, 0, 1))
    found: Reals = np.max([(at_start + place[:, None] * slopes).min(axis=1) for place in places], axis=0)
    return found


def surface(body: Body) -> tuple[Reals, Indices] | None:
    """Vertices [m] and triangles inside of a body, next to its surface; None for a floor, which has none."""
    if isinstance(body, Floor):
        return None
    if isinstance(body, Ball):
        unit, triangles = icosphere(DIVISIONS)
        return unit * (body.radius - INSET) + np.array(body.centre), triangles
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([[(a, b, c), (a, c, d)] for a, b, c, d in sides], np.int64).reshape(-1, 3)
    return corners * (np.array(body.half) - INSET) @ body.axes.T + np.array(body.centre), faces


def icosphere(divisions: int) -> tuple[Reals, Indices]:
    """A ball of radius 1 whose vertices are on its surface: vertices and triangles, outward."""
    golden = (1 + 5**0.5) / 2
    places = [[0.0, a, b * golden] for a in (-1, 1) for b in (-1, 1)]
    vertices = np.array([np.roll(place, shift) for shift in range(3) for place in places])
    vertices /= np.linalg.norm(vertices[0])
    near = np.linalg.norm(vertices[:, None] - vertices[None], axis=2) < 1.1
    triangles = np.array(
        [
            (a, b, c) if np.dot(vertices[a], np.cross(vertices[b], vertices[c])) > 0 else (a, c, b)
            for a in range(12)
            for b in range(a + 1, 12)
            for c in range(b + 1, 12)
            if near[a, b] and near[b, c] and near[a, c]
        ],
        np.int64,
    )
    for _ in range(divisions):
        vertices, triangles = _halved(vertices, triangles)
    return vertices, triangles


def _halved(vertices: Reals, triangles: Indices) -> tuple[Reals, Indices]:
    """Every triangle as four, the new vertices lifted onto the ball."""
    a, b, c = triangles.T
    sides = np.sort(np.concatenate([np.stack([a, b], 1), np.stack([b, c], 1), np.stack([c, a], 1)]), axis=1)
    edges, numbers = np.unique(sides, axis=0, return_inverse=True)
    middles = vertices[edges].mean(axis=1)
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    ab, bc, ca = numbers.reshape(3, -1) + len(vertices)
    parts = [np.stack(corners, axis=1) for corners in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
    return np.concatenate([vertices, middles]), np.concatenate(parts)


def _mesh(positions: Reals, triangles: Indices) -> ipctk.CollisionMesh:
    faces = triangles.astype(np.int32)
    return ipctk.CollisionMesh(np.asfortranarray(positions), ipctk.edges(faces), faces)


def _stretch(flat: Reals, positions: Reals, edges: Indices) -> float:
    rest, now = (
        np.linalg.norm(places[edges[:, 1]] - places[edges[:, 0]], axis=1) for places in (flat, positions)
    )
    return float((now / rest).max()) - 1
