"""Cusick's drape test (BS 5058): a round cloth lies on a smaller disc, and its edge hangs down in folds."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.laboratory.round import disc_mesh, shadow_area
from taut.scene import Scene
from taut.simulation import Simulation

CLOTH, DISC = 0.15, 0.09
"""Radii of the cloth and of the disc [m]."""
AIR_DRAG = 6.0
"""Drag of the air [1/s], far more than real: the cloth comes to rest in seconds."""
STILL = 2e-3
"""Speed of the fastest vertex below which the cloth is at rest [m/s]."""
SECONDS, LONGEST = 0.5, 12.0
"""The cloth is looked at after every so many seconds, and no longer than that [s]."""
WAVES, HEIGHT = range(2, 9), 2e-3
"""No cloth lies quite flat: it starts with random waves, so many round the disc, so high at the edge [m].
From a flat start the waves win that grow fastest, 9 or 10 of them, where laboratories count 4 to 8 folds."""
FPS = 60.0


@dataclass(frozen=True)
class Drape:
    """A cloth that came to rest over the disc."""

    coefficient: float
    """Shadow of the part that hangs, over its area laid flat [%]: 100 is a board, 0 hangs straight down."""
    folds: int
    """Waves of the free edge, as seen from above [1]."""
    seconds: float
    """Time it took to come to rest [s]."""
    speed: float
    """Fastest vertex at the end [m/s]."""
    stretch: float
    """Worst stretch of a spring at the end [1]."""
    positions: NDArray[np.float32]
    """Vertices [m], shape (vertices, 3); the disc lies at z = 0 round the origin."""
    faces: NDArray[np.int64]
    """Triangles, shape (faces, 3)."""


def drape(cloth: Mapping[str, Any], edge: float = 6e-3, seed: int = 1, threads: int | None = None) -> Drape:
    """Drape a round cloth, 30 cm wide, over a disc of 18 cm.

    Args:
        cloth: fields of a cloth's material, as in ``{"fabric": "wool", "bending": "fabric"}``.
        edge: length of the edges of the mesh [m].
        seed: of the mesh and of the waves that the cloth starts with.
        threads: worker threads [1]; all cores when left out.

    Raises:
        SceneError: `cloth` is not the material of a cloth.
        ValueError: `edge` is out of range.
    """
    if not 1e-3 <= edge <= 0.02:
        raise ValueError(f"edge = {edge}: must be 0.001 to 0.02 m; try 0.006")
    vertices, faces, rim = disc_mesh(CLOTH, DISC, edge, seed)
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    loose = radius > rim + 1e-6
    vertices[:, 2] = waves(vertices, rim, seed)
    pins = [{"vertices": np.flatnonzero(~loose)}]
    document = {
        "duration": LONGEST,
        "fps": FPS,
        "cloth": [{"air_drag": AIR_DRAG, **cloth, "mesh": "disc", "pins": pins}],
    }
    simulation = Simulation(Scene(document, meshes={"disc": (vertices, faces)}), threads)
    speed = np.inf
    while speed > STILL and simulation.time < LONGEST:
        simulation.run(round(SECONDS * FPS))
        speed = float(np.linalg.norm(simulation.velocities, axis=1).max())
    positions = simulation.positions.copy()
    shadow = shadow_area(positions, faces, DISC) / (np.pi * (CLOTH**2 - DISC**2))
    return Drape(
        coefficient=100.0 * shadow,
        folds=folds(positions[np.isclose(radius, CLOTH)]),
        seconds=simulation.time,
        speed=speed,
        stretch=simulation.report.worst_stretch,
        positions=positions,
        faces=faces,
    )


def waves(vertices: NDArray[np.float64], rim: float, seed: int) -> NDArray[np.float64]:
    """Random waves that grow from the rim outwards: heights [m], shape (vertices,), whatever the mesh."""
    random = np.random.default_rng(seed)
    radius, angle = np.hypot(vertices[:, 0], vertices[:, 1]), np.arctan2(vertices[:, 1], vertices[:, 0])
    height = np.zeros(len(vertices))
    for count in WAVES:
        size, phase = random.standard_normal(), random.uniform(0.0, 2.0 * np.pi)
        height += HEIGHT / np.sqrt(len(WAVES)) * size * np.cos(count * angle + phase)
    return height * np.clip((radius - rim) / (CLOTH - rim), 0.0, 1.0) ** 2


def folds(edge: NDArray[np.floating[Any]]) -> int:
    """Count the waves of a closed line round the z axis.

    Args:
        edge: its points in order, shape (points, 3).

    A wave is a way out over the mean distance from the axis and back below it, by a tenth of the spread each.
    """
    distance = np.hypot(edge[:, 0], edge[:, 1])
    margin = 0.1 * np.ptp(distance)
    if margin < 1e-4:
        return 0
    from_mean = distance - distance.mean()
    sides = np.sign(from_mean[np.abs(from_mean) > margin])
    return int(np.count_nonzero(sides != np.roll(sides, 1))) // 2
