"""Bodies as triangles: what the methods of the literature collide with."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from taut.bodies import Body, quad_of
from taut.compare.contact.distance import Numbers

Faces = NDArray[np.int64]

DIVISIONS = 3
"""Each triangle of the icosahedron is divided into four so many times [1]: 1280 triangles."""

PLANE = 50.0
"""Half of the side of the square that stands for a plane [m]."""


@cache
def icosphere(divisions: int = DIVISIONS) -> tuple[Numbers, Faces]:
    """A sphere of radius 1 round the origin: an icosahedron, divided.

    Its corners lie on the sphere, so that it is inscribed.

    Returns:
        Corners, shape (n, 3), and triangles, counter-clockwise seen from outside, shape (m, 3).
    """
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    flat = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)]
    corners = np.array(
        [(x, y, 0.0) for x, y in flat] + [(0.0, x, y) for x, y in flat] + [(y, 0.0, x) for x, y in flat]
    )
    # The faces of the convex hull are those triples whose corners are all next to each other.
    near = np.abs(np.linalg.norm(corners[:, None] - corners, axis=2) - 2.0) < 1e-6
    triples = [
        (i, j, k)
        for i in range(12)
        for j in range(i)
        for k in range(j)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    faces = np.array(triples, np.int64)
    for _ in range(divisions):
        sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        unique, which = np.unique(sides, axis=0, return_inverse=True)
        middles = len(corners) + which.reshape(-1, 3)
        corners = np.concatenate([corners, 0.5 * (corners[unique[:, 0]] + corners[unique[:, 1]])])
        a, b, c = faces.T
        ab, bc, ca = middles.T
        parts = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        faces = np.concatenate([np.stack(part, axis=1) for part in parts])
    corners /= np.linalg.norm(corners, axis=1, keepdims=True)
    first, second, third = (corners[faces[:, corner]] for corner in range(3))
    inwards = (np.cross(second - first, third - first) * first).sum(axis=1) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    corners.flags.writeable = faces.flags.writeable = False
    return corners, faces


def faces_of(body: Body) -> Faces:
    """Triangles of a body, vertices counted from its first point of :func:`points_of`; shape (m, 3)."""
    if body.shape == "surface":
        used = np.unique(body.triangles)
        return np.searchsorted(used, body.triangles).astype(np.int64)
    if body.shape == "plane":
        return np.array([[0, 1, 2], [0, 2, 3]])
    return icosphere()[1]


def points_of(body: Body) -> Numbers:
    """Corners of the triangles of a body, where it is now [m], shape (n, 3).

    A sphere is an icosphere, a capsule one whose halves are pulled apart, a plane a large square.
    """
    places = np.asarray(body.positions, np.float64)
    if body.shape == "surface":
        return places[np.unique(body.triangles)]
    if body.shape == "plane":
        return quad_of(body, places[0], PLANE)
    round_ = icosphere()[0]
    if body.shape == "sphere":
        return np.asarray(places[0] + body.radius * round_)
    upper = round_ @ (places[1] - places[0]) > 0
    return np.asarray(places[upper.astype(np.int64)] + body.radius * round_)
