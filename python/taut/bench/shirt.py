"""A T-shirt on which no constant of the engine was chosen: two sides, cut unevenly and sewn."""

import numpy as np
from matplotlib.path import Path
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from taut.bench.meshes import Faces, Random, Vertices, shuffled

Points = NDArray[np.float64]

NECK = (0.085, 0.70)  # where the shoulder seam ends, x and z [m] from the middle of the hem
CUFF_TOP, CUFF_BOTTOM = (0.46, 0.52), (0.40, 0.36)
ARMPIT, HEM = (0.25, 0.43), (0.27, 0.0)
NECKLINES = (0.60, 0.67)  # lowest points of the neck, front and back [m]
DEPTH = 0.11  # half the thickness of the body [m]
JITTER = 0.25
"""Vertices are moved by up to this part of their distance [1]."""
CROWDING = 1.15  # [m^2], found by counting: vertices times the square of `spacing`
ROOM = 0.62
"""None lies nearer to the outline than this part of the distance of vertices there [1]."""


def shirt(vertices: int = 6400, size: float = 1.0, seed: int = 1) -> tuple[Vertices, Faces]:
    """Make a T-shirt with its sleeves spread, the hem round the origin in the plane z = 0.

    Its two sides, front at -y, are triangulated differently, densely at the neck and sparsely at the hem.
    They share the vertices of their seams, which lie in the plane y = 0. Neck, cuffs and hem are open.

    Args:
        vertices: how many there are in all, roughly [1].
        size: 1 m stands for the shirt of a person [m].
        seed: of all that is random.

    Returns:
        Vertices and faces, turned outwards.
    """
    random = np.random.default_rng(seed)
    spacing = np.sqrt(CROWDING / vertices)
    over = _polyline([NECK, CUFF_TOP], spacing, random)
    under = _polyline([CUFF_BOTTOM, ARMPIT, HEM], spacing, random)
    seams = [over, under, *(mirrored * [-1, 1] for mirrored in (over, under))]
    sewn = np.concatenate(seams)
    sides, faces, total = [np.column_stack([sewn[:, 0], np.zeros(len(sewn)), sewn[:, 1]])], [], len(sewn)
    for side, lowest in ((-1, NECKLINES[0]), (1, NECKLINES[1])):
        outline, known = _outline(seams, lowest, spacing, random)
        points = np.concatenate([outline, _filling(outline, spacing, random)])
        triangles = _triangulated(points, len(outline))
        number = np.concatenate([known, np.full(len(points) - len(known), -1)])
        new = number < 0
        number[new] = total + np.arange(int(new.sum()))
        total += int(new.sum())
        depth = side * DEPTH * np.tanh(_to_seams(points[new], seams) / DEPTH)
        sides.append(np.column_stack([points[new, 0], depth, points[new, 1]]))
        faces.append(number[triangles if side < 0 else triangles[:, ::-1]])
    return shuffled(size * np.concatenate(sides), np.concatenate(faces), random)


def shoulders(size: float = 1.0) -> list[list[list[float]]]:
    """Boxes round the middle of both shoulder seams, for pins [m]."""
    x = [0.14 * size, 0.19 * size]
    margin = 0.001 * size
    spans = (x, [-x[1], -x[0]])
    return [[[low, -margin, 0.6 * size], [high, margin, 0.7 * size]] for low, high in spans]


def _spacing(points: Points) -> NDArray[np.float64]:
    """How the distance of vertices varies: less at the neck, more at the hem [1]."""
    return np.asarray(1.35 - 0.85 * points[..., 1] / NECK[1], dtype=np.float64)


def _polyline(corners: list[tuple[float, float]], spacing: float, random: Random) -> Points:
    """Uneven points on a line, its corners among them; shape (points, 2)."""
    found = [np.array(corners[:1])]
    for start, end in zip(corners[:-1], corners[1:], strict=True):
        a, b = np.array(start), np.array(end)
        fine = a + np.linspace(0, 1, 200)[:, None] * (b - a)
        density = 1 / (spacing * _spacing(fine))
        count = max(1, round(float(np.linalg.norm(b - a) * density.mean())))
        wanted = np.arange(1.0, count + 1)
        wanted[:-1] += random.uniform(-JITTER, JITTER, count - 1)
        passed = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
        found.append(
            a + np.interp(wanted / count, passed / passed[-1], np.linspace(0, 1, 200))[:, None] * (b - a)
        )
    return np.concatenate(found)


def _outline(
    seams: list[Points], lowest: float, spacing: float, random: Random
) -> tuple[Points, NDArray[np.int64]]:
    """Border of a side, counter-clockwise from the front; the number of each point of a seam, or -1."""
    over, under, over_left, under_left = (np.arange(len(seam)) for seam in seams)
    first = np.concatenate([[0], np.cumsum([len(seam) for seam in seams])])
    right = np.array(NECK)
    angle = np.linspace(0, np.pi, 17)
    arc = np.column_stack([right[0] * np.cos(angle), NECK[1] - (NECK[1] - lowest) * np.sin(angle)])
    neck = _polyline([(float(x), float(z)) for x, z in arc], spacing, random)[1:-1]
    cuff = _polyline([CUFF_BOTTOM, CUFF_TOP], spacing, random)[1:-1]
    hem = _polyline([(-HEM[0], HEM[1]), HEM], spacing, random)[1:-1]
    cuff_left = _polyline([CUFF_TOP, CUFF_BOTTOM], spacing, random)[1:-1] * [-1, 1]

    def sewn(seam: int, order: NDArray[np.int64]) -> tuple[Points, NDArray[np.int64]]:
        return seams[seam][order], first[seam] + order

    def free(points: Points) -> tuple[Points, NDArray[np.int64]]:
        return points, np.full(len(points), -1)

    parts = [
        *(free(hem), sewn(1, under[::-1]), free(cuff), sewn(0, over[::-1])),
        *(free(neck), sewn(2, over_left), free(cuff_left), sewn(3, under_left)),
    ]
    return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])


def _filling(outline: Points, spacing: float, random: Random) -> Points:
    """Uneven points inside: rows whose distance varies, every second shifted, all jittered."""
    rows, z = [], 0.0
    while z < NECK[1]:
        step = spacing * float(_spacing(np.array([0.0, z])))
        x = np.arange(-0.5, 0.5, step * random.uniform(0.9, 1.2)) + random.uniform(0, step)
        rows.append(
            np.column_stack([x, np.full(len(x), z)]) + random.uniform(-JITTER, JITTER, (len(x), 2)) * step
        )
        z += 0.9 * step * random.uniform(0.9, 1.25)
    points = np.concatenate(rows)
    points = points[Path(outline).contains_points(points)]
    nearest = np.full(len(points), np.inf)
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        room = max(float(np.linalg.norm(b - a)), spacing * float(_spacing((a + b) / 2)))
        nearest = np.minimum(nearest, _distance(points, a, b) / room)
    return np.asarray(points[nearest > ROOM])


def _triangulated(points: Points, border: int) -> Faces:
    """Triangles inside the outline, which is made of the first points; counter-clockwise from the front."""
    triangles = np.asarray(Triangulation(points[:, 0], points[:, 1]).triangles, dtype=np.int64)
    inside = Path(points[:border]).contains_points(points[triangles].mean(axis=1))
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    longest = np.maximum.reduce(
        [((b - a) ** 2).sum(axis=1), ((c - b) ** 2).sum(axis=1), ((a - c) ** 2).sum(axis=1)]
    )
    # Three points of a straight seam are no triangle.
    return np.asarray(triangles[inside & (doubled > 1e-6 * longest)])


def _to_seams(points: Points, seams: list[Points]) -> NDArray[np.float64]:
    """Distance of each point from the nearest seam [m]."""
    nearest = np.full(len(points), np.inf)
    for seam in seams:
        for a, b in zip(seam[:-1], seam[1:], strict=True):
            nearest = np.minimum(nearest, _distance(points, a, b))
    return nearest


def _distance(points: Points, a: Points, b: Points) -> NDArray[np.float64]:
    """Distance of each point from a line between two others [m]."""
    along = np.clip((points - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-30), 0, 1)
    return np.asarray(np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
