"""Write the mesh of the shipped scene `cape`: a cape, cut from a flat pattern and laid round the shoulders.

The pattern is a sector of a ring, as a tailor draws it, with rounded front corners and a hem that is longer
at the back. It is filled with irregular points and triangles (no grid), then rolled into an open cone,
which bends the cloth but stretches it nowhere: the springs' natural lengths are those of the pattern.

Metres, z up, right-handed. The cone's axis is the z axis; the front opening faces the viewer, towards -y.
The neckline is the circle of radius 0.09 m at z = 1.45 m round the z axis, open at the front; nothing else
reaches above z = 1.44 m. So

    pins = [{ box = [[-0.12, -0.12, 1.445], [0.12, 0.12, 1.46]] }]

pins the whole neckline, and two clasps and a hook at the nape are

    pins = [
        { nearest = [-0.035, -0.083, 1.45] },
        { nearest = [0.035, -0.083, 1.45] },
        { nearest = [0.0, 0.09, 1.45] },
    ]

The result is the same, byte for byte, every time.
"""

import argparse
from pathlib import Path

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

MESH = Path(__file__).resolve().parent.parent / "python/taut/scenes/meshes/cape.obj"

NECK_HEIGHT = 1.45
NECK_RADIUS = 0.09
SLOPE = np.sin(np.radians(24))
"""Distance from the axis for each metre along the cloth."""
OPENING = np.radians(46)
"""Angle round the axis that the front leaves open."""
LENGTH_FRONT, LENGTH_BACK = 0.72, 0.92
"""From neckline to hem, along the cloth."""
CORNER = 0.12
"""Radius of the rounded front corners of the hem."""
SPACING = 0.0148
"""Least distance of neighbouring vertices."""
DARTS = 40_000
"""Random points tried; the more, the fewer gaps remain."""

Points = NDArray[np.float64]

INNER = NECK_RADIUS / SLOPE
HALF_ANGLE = (np.pi - OPENING / 2) * SLOPE
"""Half the angle of the flat pattern."""


def outline() -> Points:
    """The pattern's border, counterclockwise, evenly spaced; shape (points, 2)."""
    angle = np.linspace(-HALF_ANGLE, HALF_ANGLE, 2000)
    back = np.cos(angle / HALF_ANGLE * np.pi / 2) ** 2
    hem = INNER + LENGTH_FRONT + (LENGTH_BACK - LENGTH_FRONT) * back
    # A quarter circle rounds each corner: near the edge the hem draws in.
    edge = np.clip((HALF_ANGLE - np.abs(angle)) * hem / CORNER, 0, 1)
    hem -= CORNER * (1 - np.sqrt(1 - (1 - edge) ** 2))
    neck = np.linspace(HALF_ANGLE, -HALF_ANGLE, 500)
    border = np.concatenate([polar(hem, angle), polar(np.full_like(neck, INNER), neck)])
    steps = np.linalg.norm(np.diff(border, axis=0, append=border[:1]), axis=1)
    length = np.concatenate([[0], np.cumsum(steps)])
    # The ends of the neckline stay vertices: each side is divided for itself.
    sides = ((0, 1999), (1999, 2000), (2000, 2499), (2499, 2500))
    return np.concatenate([_divided(border, length, *side) for side in sides])


def polar(radius: Points, angle: Points) -> Points:
    """Points of the pattern; angle 0 is the middle of the back; shape (points, 2)."""
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def _divided(border: Points, length: Points, first: int, last: int) -> Points:
    steps = max(1, round((length[last] - length[first]) / (1.2 * SPACING)))
    at = np.linspace(length[first], length[last], steps, endpoint=False)
    closed = np.concatenate([border, border[:1]])
    return np.stack([np.interp(at, length, axis) for axis in closed.T], axis=1)


def fill(border: Points) -> Points:
    """Random points inside the border, none nearer to another than the spacing; shape (points, 2)."""
    random = np.random.default_rng(1995)
    darts = random.uniform(border.min(axis=0), border.max(axis=0), (DARTS, 2))
    darts = darts[inside(border, darts)]
    kept, count = np.concatenate([border, np.empty_like(darts)]), len(border)
    for dart in darts:
        if ((kept[:count] - dart) ** 2).sum(axis=1).min() > SPACING**2:
            kept[count] = dart
            count += 1
    return kept[len(border) : count]


def inside(border: Points, points: Points) -> NDArray[np.bool_]:
    """Whether points lie within a polygon, by counting crossings; shape (points,)."""
    x, y = points[:, None].transpose(2, 0, 1)
    start, end = border, np.roll(border, -1, axis=0)
    crosses = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    left = x < start[:, 0] + (y - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    return np.asarray((crosses & left).sum(axis=1) % 2 == 1)


def triangulate(points: Points, border: Points) -> NDArray[np.int64]:
    """Delaunay triangles whose middle lies within the border, counterclockwise; shape (triangles, 3)."""
    flat = np.column_stack([points, np.zeros(len(points))])
    faces: NDArray[np.int64] = pv.PolyData(flat).delaunay_2d().faces.reshape(-1, 4)[:, 1:]
    faces = faces[inside(border, points[faces].mean(axis=1))]
    a, b, c = points[faces].transpose(1, 2, 0)
    clockwise = (b - a)[0] * (c - a)[1] < (b - a)[1] * (c - a)[0]
    return np.asarray(np.where(clockwise[:, None], faces[:, ::-1], faces))


def roll(points: Points) -> Points:
    """Roll the pattern into a cone round the z axis, isometrically; shape (points, 3)."""
    radius, angle = np.linalg.norm(points, axis=1), np.arctan2(points[:, 1], points[:, 0])
    turn, out = angle / SLOPE + np.pi / 2, radius * SLOPE
    height = NECK_HEIGHT - (radius - INNER) * np.sqrt(1 - SLOPE**2)
    return np.stack([out * np.cos(turn), out * np.sin(turn), height], axis=1)


def main() -> None:
    """Write the scene's mesh, or the file that the command line names."""
    parser = argparse.ArgumentParser(description="Write a cape as a Wavefront OBJ.")
    parser.add_argument("--out", type=Path, default=MESH)
    out: Path = parser.parse_args().out
    border = outline()
    pattern = np.concatenate([border, fill(border)])
    faces = triangulate(pattern, border) + 1
    vertices = "".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in roll(pattern))
    triangles = "".join(f"f {a} {b} {c}\n" for a, b, c in faces)
    head = f"# a cape: {len(pattern)} vertices, {len(faces)} triangles\n"
    out.write_text(head + vertices + triangles, encoding="ascii", newline="\n")


if __name__ == "__main__":
    main()
