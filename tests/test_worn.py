"""Garments that are worn: a fold that is stuck between two limbs does not stop cloth, pins and figure."""

from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation
from taut.bench.meshes import skirt
from taut.bench.walker import WAIST, walk, walker

SECONDS, RATE, LIMIT = 2.0, 60, 0.05


def _walking(vertices: int, seed: int, wind: list[float]) -> tuple[Simulation, np.ndarray]:
    """A figure that walks in a skirt, in such a wind [m/s]; and the vertices of its waistband."""
    mesh = skirt(vertices, seed=seed)
    band = np.flatnonzero(mesh[0][:, 2] > -1e-4)
    cloth: dict[str, Any] = {"name": "skirt", "mesh": "skirt", "translate": [0, 0, WAIST], "thickness": 0.002}
    cloth |= {"bending": "fabric", "strain_limit": LIMIT, "density": 0.2, "friction": 0.3}
    cloth |= {"pins": [{"vertices": band.tolist(), "move": walk(SECONDS + 1)}]}
    document = {"fps": RATE, "body": walker(SECONDS + 1), "cloth": [cloth], "wind": {"velocity": wind}}
    return Simulation(Scene(document, {"skirt": mesh}), 2), band


# The wind blows the skirt between the thighs, which shut on up to five layers of it.
@pytest.mark.parametrize(("seed", "wind"), [(2, [-4, 6, -2]), (7, [7, 5, -1])])
def test_a_skirt_between_the_legs_does_not_stop_who_wears_it(seed: int, wind: list[float]) -> None:
    simulation, band = _walking(3000, seed, wind)
    start = simulation.positions[band].astype(float)
    times, places = zip(*([0.0, [0.0, 0.0, 0.0]], *walk(SECONDS + 1)), strict=True)
    cut = 0
    for frame in range(1, round(SECONDS * RATE)):
        report = simulation.run(1)
        assert report.worst_stretch_in_steps <= LIMIT + 1e-5 and report.penetrations == 0
        cut += report.contact_cuts
        way = [np.interp(frame / RATE, times, np.array(places)[:, axis]) for axis in range(3)]
        behind = np.linalg.norm(simulation.positions[band].astype(float) - start - way, axis=1).max()
        assert behind < 0.01, f"{behind} m behind in frame {frame}"
    assert cut <= 10
