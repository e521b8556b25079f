"""The converged motion that the filter is compared with: plain sweeps, many a step and many steps a frame.

`python -m tools.targets.reference` makes `tools/targets/reference.json` again (about ten minutes). Sweeps
damp a swing as exp(-h w^2 t), so short steps matter as much as many sweeps; and they need fewer of them.
Peak speeds of the two sizes differ by about 0.1 %: larger sheets can be compared with them.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut import Simulation
from taut.bench import Case

FILE = Path(__file__).with_name("reference.json")
SCENES = ("one-corner", "two-corners")
SHAPES = ("heavy-tip",)
"""Of these the shape is kept as well."""
SHAPE_EVERY = 6  # [frames]
SHAPE_ACROSS = 9  # particles of it along a side
STEPS_PER_FRAME = {32: 480, 64: 960}  # of each size, cells along a side
STRAIN_LIMIT = 0.1
FRAMES = 60
SOLVER: dict[str, Any] = {"filter": "sweeps", "iterations": 2000, "tolerance": 1e-4}


def path(simulation: Simulation, frames: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centre of mass [m], shape (frames + 1, 3), and its speed [m/s], shape (frames + 1,), frame by frame."""
    share = simulation.mass.astype(np.float64) / simulation.mass.sum(dtype=np.float64)
    places, speeds = [share @ simulation.positions], [float(np.linalg.norm(share @ simulation.velocities))]
    for _ in range(frames):
        simulation.step(simulation.substeps)
        places.append(share @ simulation.positions)
        speeds.append(float(np.linalg.norm(share @ simulation.velocities)))
    return np.array(places), np.array(speeds)


def shapes(
    simulation: Simulation, cells: int, frames: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centre of mass [m] of each frame; some particles of a square grid [m], shape (shapes, particles, 3)."""
    across = np.arange(SHAPE_ACROSS) * (cells // (SHAPE_ACROSS - 1))
    chosen = (across[:, None] * (cells + 1) + across).ravel()
    share = simulation.mass.astype(np.float64) / simulation.mass.sum(dtype=np.float64)
    places, found = [share @ simulation.positions], [simulation.positions[chosen]]
    for frame in range(1, frames + 1):
        simulation.step(simulation.substeps)
        places.append(share @ simulation.positions)
        if frame % SHAPE_EVERY == 0:
            found.append(simulation.positions[chosen])
    return np.array(places), np.array(found, dtype=np.float64)


def reference_shapes(scene: str, cells: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The same of the converged motion, from the file."""
    found = json.loads(FILE.read_text())["paths"][f"{scene} {cells}"]
    return np.array(found["centre_of_mass"]), np.array(found["shapes"])


@cache
def reference(scene: str, cells: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The same of the converged motion, from the file; that of the largest sheet in it for larger ones."""
    found = json.loads(FILE.read_text())["paths"][f"{scene} {min(cells, max(STEPS_PER_FRAME))}"]
    return np.array(found["centre_of_mass"]), np.array(found["speed"])


def main() -> None:
    """Simulates and writes the file."""
    paths = {}
    for cells, substeps in STEPS_PER_FRAME.items():
        for scene in SCENES:
            simulation = Case(scene, cells, STRAIN_LIMIT).simulation(SOLVER | {"substeps": substeps})
            places, speeds = path(simulation, FRAMES)
            print(f"{scene} {cells}: peak speed {speeds.max():.4f} m/s", flush=True)
            rows = {"centre_of_mass": places.round(5).tolist(), "speed": speeds.round(5).tolist()}
            paths[f"{scene} {cells}"] = rows
        for scene in SHAPES:
            simulation = Case(scene, cells, STRAIN_LIMIT).simulation(SOLVER | {"substeps": substeps})
            places, found = shapes(simulation, cells, FRAMES)
            print(f"{scene} {cells}: done", flush=True)
            rows = {"centre_of_mass": places.round(5).tolist(), "shapes": found.round(4).tolist()}
            paths[f"{scene} {cells}"] = rows
    settings = {
        "solver": SOLVER,
        "substeps": STEPS_PER_FRAME,
        "strain_limit": STRAIN_LIMIT,
        "fps": 60,
        "frames": FRAMES,
    }
    FILE.write_text(json.dumps({"settings": settings, "paths": paths}) + "\n")


if __name__ == "__main__":
    main()
