"""Irregular meshes on which no constant of the engine was chosen: sheets, skirts, capes and nets.

All are made the same way each time for a seed. Vertices and faces come in random order, as from other
programs. Every mesh is a manifold with consistently turned faces.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Vertices = NDArray[np.float64]
"""[m], shape (vertices, 3)."""
Faces = NDArray[np.int64]
"""Vertex indices, counter-clockwise, shape (faces, 3) or (faces, 4)."""
Random = np.random.Generator

JITTER = 0.25
"""Vertices are moved by up to this part of their distance [1]; more could turn a cell inside out."""

WAIST, HEM, DROP = 0.12, 0.34, 0.6
"""Radii and height of a skirt of size 1 m [m]."""
NECK, CAPE_HEM, CAPE_DROP = 0.1, 0.5, 0.9
"""The same of a cape .."""
OPEN = np.radians(100.0)
""".. and the angle that it leaves open at the front."""


def irregular_sheet(
    cells: tuple[int, int], size: tuple[float, float] = (1.0, 1.0), seed: int = 1, quads: bool = False
) -> tuple[Vertices, Faces]:
    """Make a rectangle in the plane z = 0 of cells that are jittered and cut along random diagonals.

    Args:
        cells: number of cells along x and y [1]; one vertex more each.
        size: along x and y [m]; vertices of the border stay on it, corners where they are.
        seed: of all that is random.
        quads: whether cells stay quadrilaterals.

    Returns:
        Vertices and faces, turned towards z.
    """
    random = np.random.default_rng(seed)
    nx, ny = cells
    place = np.stack(np.meshgrid(np.arange(nx + 1.0), np.arange(ny + 1.0), indexing="ij"), axis=-1)
    inside = (place > 0) & (place < [nx, ny])  # what may move: along x, along y
    place += random.uniform(-JITTER, JITTER, place.shape) * inside
    vertices = np.zeros(((nx + 1) * (ny + 1), 3))
    vertices[:, :2] = (place / cells * size).reshape(-1, 2)
    number = np.arange(len(vertices)).reshape(nx + 1, ny + 1)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    faces = np.stack([corner.ravel() for corner in corners], axis=1)
    if not quads:
        turned = np.where(random.uniform(size=len(faces)) < 0.5, 0, 1)
        faces = np.take_along_axis(faces, (np.arange(4) + turned[:, None]) % 4, axis=1)
        faces = np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
    return shuffled(vertices, faces, random)


def skirt(vertices: int = 2584, size: float = 1.0, seed: int = 1) -> tuple[Vertices, Faces]:
    """Make a cone frustum round the z axis, its waist in the plane z = 0 and its hem below.

    Rings have different numbers of vertices at uneven distances, so that edges differ by a factor of some
    five and no vertex stands below another.

    Args:
        vertices: how many there are in all [1], 64 or more.
        size: 1 m stands for the skirt of a person [m].
        seed: of all that is random.

    Returns:
        Vertices and faces, turned outwards.
    """
    random = np.random.default_rng(seed)
    across = np.pi * (WAIST + HEM)
    counts, down = _rings(vertices, across, np.hypot(DROP, HEM - WAIST), WAIST / HEM, random)
    around, rows, faces = _stitched(counts, down, random, closed=True)
    return shuffled(_cone(2 * np.pi * around, rows, (WAIST, HEM, DROP), size), faces, random)


def cape(vertices: int = 3045, size: float = 1.0, seed: int = 1) -> tuple[Vertices, Faces]:
    """Make a panel round the back: part of a cone frustum round the z axis, its neck in the plane z = 0.

    It is open towards -y. Rows differ as the rings of a `skirt` do.

    Args:
        vertices: how many there are in all [1], 64 or more.
        size: 1 m stands for the cape of a person [m].
        seed: of all that is random.

    Returns:
        Vertices and faces, turned outwards.
    """
    random = np.random.default_rng(seed)
    round_it = 2 * np.pi - OPEN
    across = round_it * (NECK + CAPE_HEM) / 2
    counts, down = _rings(vertices, across, np.hypot(CAPE_DROP, CAPE_HEM - NECK), NECK / CAPE_HEM, random)
    around, rows, faces = _stitched(counts, down, random, closed=False)
    angle = OPEN / 2 - np.pi / 2 + round_it * around
    return shuffled(_cone(angle, rows, (NECK, CAPE_HEM, CAPE_DROP), size), faces, random)


def weighted_net(across: int = 33, size: float = 1.0, seed: int = 1) -> dict[str, Any]:
    """Make the network of a net in the plane z = 0 with a heavy knot here and there.

    Points are jittered, some meshes have a diagonal, and points and links are shuffled. Every twentieth knot,
    about, weighs 10 to 100 times as much as the others.

    Args:
        across: points along a side [1].
        size: length of a side [m].
        seed: of all that is random.

    Returns:
        Fields of the table `network` of a cloth; 0.2 kg/m^2 without the heavy knots.
    """
    random = np.random.default_rng(seed)
    vertices, faces = irregular_sheet((across - 1, across - 1), (size, size), seed, quads=True)
    sides = np.concatenate([faces[:, [a, (a + 1) % 4]] for a in range(4)])
    diagonals = faces[random.uniform(size=len(faces)) < 0.3][:, [0, 2]]
    links = np.unique(np.sort(np.concatenate([sides, diagonals]), axis=1), axis=0)
    mass = np.full(len(vertices), 0.2 * size**2 / len(vertices))
    heavy = random.uniform(size=len(mass)) < 0.05
    mass[heavy] *= 10 ** random.uniform(1, 2, int(heavy.sum()))
    return {
        "points": vertices.tolist(),
        "links": random.permutation(links).tolist(),
        "mass": mass.tolist(),
    }


def shuffled(vertices: Vertices, faces: Faces, random: Random) -> tuple[Vertices, Faces]:
    """Return the same mesh with vertices, faces and the first corners of faces in random order."""
    order = random.permutation(len(vertices))
    number = np.empty(len(vertices), np.int64)
    number[order] = np.arange(len(vertices))
    corners = faces.shape[1]
    turned = (np.arange(corners) + random.integers(corners, size=(len(faces), 1))) % corners
    renamed = np.take_along_axis(number[faces], turned, axis=1)
    return vertices[order], renamed[random.permutation(len(faces))]


def _rings(
    vertices: int, across: float, along: float, narrow: float, random: Random
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Vertices of each row [1], and where the rows lie from 0 (narrow) to 1 (wide), unevenly."""
    if vertices < 64:
        raise ValueError(f"vertices = {vertices}: must be 64 or more")
    rows = max(3, round(np.sqrt(vertices * along / across)))
    down = np.concatenate([[0.0], np.cumsum(random.uniform(0.6, 1.4, rows - 1))])
    down /= down[-1]
    wanted = (narrow + (1 - narrow) * down) * random.uniform(0.8, 1.25, rows)
    least = 4
    wanted *= (vertices - least * rows) / wanted.sum()
    counts = np.floor(wanted).astype(np.int64)
    missing = vertices - least * rows - int(counts.sum())
    counts[np.argsort(counts - wanted)[:missing]] += 1
    return counts + least, down


def _stitched(
    counts: NDArray[np.int64], down: NDArray[np.float64], random: Random, closed: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64], Faces]:
    """Each vertex's place along its row and across the rows, from 0 to 1, and the triangles between rows."""
    along = [_places(int(count), random, closed) for count in counts]
    gaps = np.minimum(np.diff(down, prepend=-1.0), np.diff(down, append=2.0))
    rows = [
        place + gap * random.uniform(-JITTER, JITTER, count)
        for place, gap, count in _inside(down, gaps, counts)
    ]
    rows = [np.zeros(counts[0]), *rows, np.ones(counts[-1])]
    first = np.concatenate([[0], np.cumsum(counts)])
    faces = [
        _strip(along[row], along[row + 1], closed, int(first[row]), int(first[row + 1]))
        for row in range(len(counts) - 1)
    ]
    return np.concatenate(along), np.concatenate(rows), np.concatenate(faces)


def _inside(
    down: NDArray[np.float64], gaps: NDArray[np.float64], counts: NDArray[np.int64]
) -> list[tuple[float, float, int]]:
    """Place, room and number of vertices of the rows that are not on the border."""
    return list(zip(down[1:-1].tolist(), gaps[1:-1].tolist(), counts[1:-1].tolist(), strict=True))


def _places(count: int, random: Random, closed: bool) -> NDArray[np.float64]:
    """Increasing places of vertices along a row from 0 to 1; a closed one ends where it begins."""
    moved = random.uniform(-JITTER, JITTER, count)
    if closed:
        return np.asarray((np.arange(count) + moved) / count)
    moved[[0, -1]] = 0.0
    return np.asarray((np.arange(count) + moved) / (count - 1))


def _strip(
    upper: NDArray[np.float64], lower: NDArray[np.float64], closed: bool, first_up: int, first_low: int
) -> Faces:
    """Triangles between two rows: whichever row has the nearer next vertex goes on."""
    if closed:
        upper, lower = np.append(upper, upper[0] + 1), np.append(lower, lower[0] + 1)
    steps = np.concatenate([upper[1:], lower[1:]])
    of_upper = (np.arange(len(steps)) < len(upper) - 1)[np.argsort(steps, kind="stable")]
    i = np.cumsum(of_upper).astype(np.int64) - of_upper  # before each triangle
    j = np.arange(len(steps)) - i
    ring_up, ring_low = (len(upper) - closed, len(lower) - closed)
    a, b = first_up + i % ring_up, first_low + j % ring_low
    c = np.where(of_upper, first_up + (i + 1) % ring_up, first_low + (j + 1) % ring_low)
    return np.stack([a, b, c], axis=1).astype(np.int64)


def _cone(
    angle: NDArray[np.float64], down: NDArray[np.float64], shape: tuple[float, float, float], size: float
) -> Vertices:
    """Points of a cone frustum round the z axis, its upper end at z = 0."""
    upper, lower, drop = shape
    radius = upper + (lower - upper) * down
    return size * np.stack([radius * np.cos(angle), radius * np.sin(angle), -drop * down], axis=1)
