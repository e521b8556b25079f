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
