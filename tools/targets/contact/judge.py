"""Whether anything passed through anything: by the IPC Toolkit, and by NumPy for what is round or flat."""

from collections.abc import Mapping
from dataclasses import dataclass

import ipctk
import numpy as np
from numpy.typing import NDArray
from taut import Simulation
from taut.bodies import Body, bodies_at, normal_of

Points = NDArray[np.float64]

UNIT = 100.0
"""Told metres, the toolkit takes a tenth of a millimetre for touching. So it is told centimetres."""


@dataclass(frozen=True, slots=True)
class Seen:
    """What there is to see at a moment."""

    intersects: bool
    """Whether triangles intersect, or links pass through them."""
    crosses: bool
    """Whether something met something since the last look, on the straight ways between the ends of parts."""
    inside: tuple[str, ...]
    """Names of spheres, capsules and planes that a triangle or a link reaches into."""

    @property
    def clean(self) -> bool:
        """Whether nothing is wrong."""
        return not (self.intersects or self.crosses or self.inside)


class Oracle:
    """Looks at a simulation again and again, at all parts of the last steps.

    Spheres and capsules are no meshes. Their middles are, a vertex and an edge: the toolkit sees whether
    cloth goes through those on its way, NumPy how far whole triangles are from them.
    """

    def __init__(self, simulation: Simulation) -> None:
        """Of a simulation as it is now, which keeps its trace from now on."""
        simulation.keep_trace()
        bodies = simulation.bodies
        self._vertices = len(simulation.mass)
        self._used = _used(self._vertices, bodies)
        self._faces, self._links = simulation.faces, links_of(simulation)
        places = self._places(_now(simulation))
        self._mesh = ipctk.CollisionMesh(places, *_world(simulation, bodies))
        # Bodies may overlap: legs begin inside a torso.
        self._mesh.can_collide = ipctk.make_static_obstacle_filter(self._vertices)
        self._before = places

    def look(self, simulation: Simulation) -> Seen:
        """What is wrong now, or was on the way since the last look: at most one call of `step` ago."""
        intersects = crosses = False
        inside: set[str] = set()
        for moment in simulation.trace or [_now(simulation)]:
            places = self._places(moment)
            crosses |= meets(self._mesh, self._before, places)
            intersects |= ipctk.has_intersections(self._mesh, places)
            inside |= self._reached(simulation, moment)
            self._before = places
        return Seen(
            intersects, crosses, tuple(one.name for one in simulation.body_ranges if one.name in inside)
        )

    def _places(self, moment: Points) -> Points:
        """Of all vertices that count."""
        return np.asfortranarray(moment[self._used])

    def _reached(self, simulation: Simulation, moment: Points) -> set[str]:
        """Spheres, capsules and planes that are not clear of all triangles and links."""
        places, of_bodies = moment[: self._vertices], moment[self._vertices :]
        corners, links = places[self._faces], places[self._links]
        found = set()
        for name, body in bodies_at(simulation.body_ranges, of_bodies, simulation.body_triangles).items():
            if body.shape == "plane":
                clear = bool(((places - body.positions[0]) @ normal_of(body) > 0).all())
            elif body.shape in ("sphere", "capsule"):
                line = np.asarray(body.positions)
                nearest = min(distance(corners, line, body.radius), distance_of_links(links, line))
                clear = nearest > body.radius
            else:
                continue
            if not clear:
                found.add(name)
        return found


def meets(mesh: ipctk.CollisionMesh, before: Points, after: Points) -> bool:
    """Whether something in a mesh meets something on straight ways between two places of its vertices [m]."""
    return not ipctk.is_step_collision_free(mesh, before * UNIT, after * UNIT)


def _now(simulation: Simulation) -> Points:
    """Of all vertices of cloths, then of bodies: as the trace has them."""
    return np.concatenate([simulation.exact_positions, simulation.body_positions])


def _used(vertices: int, bodies: Mapping[str, Body]) -> NDArray[np.int64]:
    """Vertices that count: none of planes, none of a surface that are in no triangle."""
    used, first = [np.arange(vertices)], vertices
    for body in bodies.values():
        if body.shape == "surface":
            used.append(first + np.unique(body.triangles))
        elif body.shape != "plane":
            used.append(first + np.arange(len(body.positions)))
        first += len(body.positions)
    return np.concatenate(used)


def _world(simulation: Simulation, bodies: Mapping[str, Body]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Edges and triangles among the vertices that count."""
    faces, rods = [simulation.faces.astype(np.int32)], []
    first = len(simulation.mass)
    for body in bodies.values():
        if body.shape == "plane":
            continue
        if body.shape == "capsule":
            rods.append([first, first + 1])
        used = np.unique(body.triangles) if body.shape == "surface" else np.arange(len(body.positions))
        if len(body.triangles):
            faces.append(np.searchsorted(used, body.triangles).astype(np.int32) + np.int32(first))
        first += len(used)
    triangles = np.concatenate(faces).astype(np.int32)
    # The toolkit finds no edges of no triangles.
    sides = [ipctk.edges(triangles)] if len(triangles) else []
    edges = np.concatenate([*sides, links_of(simulation), np.array(rods, np.int32).reshape(-1, 2)])
    return edges.astype(np.int32), triangles


def links_of(simulation: Simulation) -> NDArray[np.int32]:
    """The links of networks, pairs of vertices: what no triangle has."""
    links = simulation.springs[simulation.spring_kind == 0]
    return links[~np.isin(links, simulation.faces).any(axis=1)]


def distance(corners: Points, line: Points, within: float = np.inf) -> float:
    """The least distance of triangles, shape (n, 3, 3), from a point (1, 3) or a line between two (2, 3) [m].

    Only triangles that may be nearer than `within` are looked at; infinite if there are none. A line that
    goes through the inside of a triangle is not noticed.
    """
    middles = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    start, end = line[0], line[-1]
    away = np.sqrt(_points_from_segments(middles, start[None], end[None]))
    corners = corners[away - reach <= within]
    if not len(corners):
        return np.inf
    found = min(float(_points_from_triangles(point, corners).min()) for point in line)
    if len(line) == 2:
        for a in range(3):
            ends = corners[:, a], corners[:, (a + 1) % 3]
            found = min(found, float(_segments_from_segments(start, end, *ends).min()))
    return float(np.sqrt(found))


def distance_of_links(links: Points, line: Points) -> float:
    """The least distance of links, shape (n, 2, 3), from a point (1, 3) or a line between two (2, 3) [m]."""
    if not len(links):
        return np.inf
    start, end = links[:, 0], links[:, 1]
    if len(line) == 1:
        points = np.broadcast_to(line, start.shape)
        return float(np.sqrt(_points_from_segments(points, start, end).min()))
    return float(np.sqrt(_segments_from_segments(line[0], line[1], start, end).min()))


def _points_from_segments(points: Points, start: Points, end: Points) -> Points:
    """Squared distances [m^2]."""
    way = end - start
    along = np.einsum("nc,nc->n", points - start, np.broadcast_to(way, points.shape))
    length = np.maximum(np.einsum("nc,nc->n", way, way), 1e-300)
    nearest = start + np.clip(along / length, 0, 1)[:, None] * way
    return np.asarray(((points - nearest) ** 2).sum(axis=1))


def _points_from_triangles(point: Points, corners: Points) -> Points:
    """Squared distances of a point from triangles [m^2]."""
    a, b, c = (corners[:, corner] for corner in range(3))
    points = np.broadcast_to(point, a.shape)
    sides = [_points_from_segments(points, *ends) for ends in ((a, b), (b, c), (c, a))]
    normal = np.cross(b - a, c - a)
    area = np.maximum((normal**2).sum(axis=1), 1e-300)
    height = ((points - a) * normal).sum(axis=1) ** 2 / area
    above = np.ones(len(a), np.bool_)
    for first, second in ((a, b), (b, c), (c, a)):
        above &= (np.cross(second - first, points - first) * normal).sum(axis=1) >= 0
    return np.asarray(np.where(above, height, np.minimum.reduce(sides)))


def _segments_from_segments(start: Points, end: Points, a: Points, b: Points) -> Points:
    """Squared distances of a segment from others, the lines of which it does not cross exactly [m^2]."""
    way, other = end - start, b - a
    apart = start - a
    ww, oo, wo = way @ way, (other**2).sum(axis=1), other @ way
    wa, oa = apart @ way, (other * apart).sum(axis=1)
    denominator = ww * oo - wo**2
    safe = np.where(denominator > 0, denominator, 1.0)
    s = np.clip(np.where(denominator > 0, (wo * oa - oo * wa) / safe, 0.0), 0, 1)
    t = np.clip((wo * s + oa) / np.maximum(oo, 1e-300), 0, 1)
    s = np.clip((wo * t - wa) / ww, 0, 1)
    nearest = start + s[:, None] * way - (a + t[:, None] * other)
    return np.asarray((nearest**2).sum(axis=1))
