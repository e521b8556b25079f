"""A round mesh and the area of a shadow."""

import math
from typing import Any

import numpy as np
import shapely
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

UNDER = 2
"""Rings of vertices on the disc; what lies further in would not move."""
TURN = 0.618034
"""Each ring is turned against the one before by this part of a circle [1]: where their vertices come to lie
on one line, the rings would put in six folds of their own."""
SCATTER = 0.15
"""Vertices between the rims are moved by up to this part of an edge, both ways [1]."""


def disc_mesh(
    cloth: float, disc: float, edge: float, seed: int = 1
) -> tuple[NDArray[np.float64], NDArray[np.int64], float]:
    """Triangulate a flat ring: what hangs over a disc, and a margin on it.

    The outermost vertices that are to be held lie half an edge beyond the rim. A fold between triangles is a
    curvature over both, so that cloth begins to bend half an edge before the last held ring.

    Args:
        cloth: outer radius [m].
        disc: radius of the disc [m].
        edge: length of the edges [m].
        seed: which way vertices are moved off their rings.

    Returns:
        Vertices [m], shape (vertices, 3), ring by ring, the outermost last; triangles, shape (faces, 3);
        and the radius within which vertices are held [m].
    """
    rings = round((cloth - disc) / edge)
    step = (cloth - disc) / (rings + 0.5)
    rim = disc + 0.5 * step
    random = np.random.default_rng(seed)
    points = []
    for ring in range(-UNDER, rings + 1):
        radius = rim + ring * step
        count = round(2.0 * math.pi * radius / edge)
        angle = 2.0 * math.pi * (np.arange(count) / count + TURN * ring)
        out = np.full(count, radius)
        if ring not in (-UNDER, 0, rings):
            out += edge * random.uniform(-SCATTER, SCATTER, count)
            angle += edge / radius * random.uniform(-SCATTER, SCATTER, count)
        points.append(np.column_stack([out * np.cos(angle), out * np.sin(angle), np.zeros(count)]))
    vertices = np.concatenate(points)
    faces = Triangulation(vertices[:, 0], vertices[:, 1]).triangles.astype(np.int64)
    first = len(points[0])
    return vertices, faces[(faces >= first).any(axis=1)], rim


def shadow_area(positions: NDArray[np.floating[Any]], faces: NDArray[np.int64], disc: float) -> float:
    """Area that triangles darken beside a disc, with the light straight above [m²].

    Args:
        positions: vertices [m], shape (vertices, 3); z is up.
        faces: triangles, shape (faces, 3).
        disc: radius of the disc round the z axis [m].
    """
    flat = positions[faces][:, :, :2].astype(np.float64)
    across, along = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    upright = np.abs(across[:, 0] * along[:, 1] - across[:, 1] * along[:, 0]) > 1e-14
    shadow = shapely.union_all(shapely.polygons(flat[upright]))
    return float(shadow.difference(shapely.Point(0.0, 0.0).buffer(disc, quad_segs=256)).area)
