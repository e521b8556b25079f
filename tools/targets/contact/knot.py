"""A reef knot of two ribbons, loose at the start, whose ends are drawn apart."""

import numpy as np
from numpy.typing import NDArray
from taut.bench.meshes import irregular_sheet

from tools.targets.contact.scenes import Stage

LEG, WIDE, NARROW = 0.25, 0.03, 0.012
"""Length of the ends of a bight; half of its breadth where it is round, and where they leave [m]."""
REACH, HIGH = 0.035, 0.016
"""Half the length over which a bight opens, and how far the ribbons lie apart where they cross [m]."""
DRAWN = 0.08  # how far both ends of each ribbon go [m]
Points = NDArray[np.float64]


def knot(seconds: float, mesh: bool, broad: float, cell: float) -> Stage:
    """Two ribbons of such a breadth and cells [m], upright in a plane, each a bight through the other.

    The ends of each follow a path, `path-0` and `path-1`, and go apart evenly in so many seconds; there is
    no gravity.
    """
    made = Stage({"fps": 60, "gravity": [0, 0, 0]})
    parts = np.linspace(0, 1, round(60 * seconds) + 1)
    for number, side in enumerate((-1, 1)):
        line = centre_line() * (np.array([1, 1, 1]) if side < 0 else np.array([-1, 1, -1]))
        vertices, faces, ends = _ribbon(line, mesh, number + 1, broad, cell)
        path = f"path-{number}"
        made.paths[path] = vertices[ends] + parts[:, None, None] * [side * DRAWN, 0, 0]
        made.cloth(
            f"ribbon-{number}",
            mesh=(vertices, faces),
            thickness=0.001,
            density=0.2,
            bending="fabric",
            friction=0.2,
            air_drag=0.5,
            pins=[{"vertices": ends.tolist(), "follow": path}],
        )
    return made


def centre_line() -> Points:
    """Points along the ribbon whose ends go to -x, close to each other [m], shape (points, 3)."""
    x = np.linspace(-LEG, REACH, 2000)
    opening = 0.5 - 0.5 * np.cos(np.pi * np.clip((x + REACH) / (2 * REACH), 0, 1))
    y = NARROW + (WIDE - NARROW) * opening
    angle = np.linspace(0, np.pi, 1001)[1:-1]
    x = np.concatenate([x, REACH + WIDE * np.sin(angle), x[::-1]])
    y = np.concatenate([y, WIDE * np.cos(angle), -y[::-1]])
    # Over the round of the other one, under its ends, over them where they leave.
    crossing = REACH + np.sqrt(WIDE**2 - NARROW**2)
    z = -0.5 * HIGH * np.cos(np.pi * np.clip(np.abs(x) / crossing, 0, 1))
    return np.column_stack([x, y, z])


def _ribbon(
    line: Points, mesh: bool, seed: int, broad: float, cell: float
) -> tuple[Points, NDArray[np.int64], NDArray[np.int64]]:
    """A ribbon upright along a line: vertices, faces and the vertices of both ends."""
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    length = along[-1]
    cells = (round(length / cell), round(broad / cell))
    flat, faces = irregular_sheet(cells, (length, broad), seed) if mesh else _strip(cells, (length, broad))
    at = np.stack([np.interp(flat[:, 0], along, line[:, axis]) for axis in range(3)], axis=1)
    ends = np.flatnonzero((flat[:, 0] < 1e-9) | (flat[:, 0] > length - 1e-9))
    return at + (flat[:, 1] - broad / 2)[:, None] * [0, 0, 1], faces, ends


def _strip(cells: tuple[int, int], size: tuple[float, float]) -> tuple[Points, NDArray[np.int64]]:
    """An even rectangle of quadrilaterals."""
    i, j = np.meshgrid(np.arange(cells[0] + 1), np.arange(cells[1] + 1), indexing="ij")
    vertices = np.column_stack([i.ravel() * size[0] / cells[0], j.ravel() * size[1] / cells[1]])
    number = np.arange(len(vertices)).reshape(i.shape)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    faces = np.stack([corner.ravel() for corner in corners], axis=1)
    return vertices, faces
