"""Converged motions of the trials: plain sweeps, many a step and many steps a frame, kept in a file.

`python -m tools.targets.converged` makes `tools/targets/converged.json` again (a few minutes); `--only NAME`
one of them. With twice as many steps peak speeds and paths of those of 33² that were tried change by at most
0.1 %, the paths with moving pins by 0.5 % of the size.
"""

import argparse
import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut.bench.trials import Shape, Trial

from tools.targets.reference import path

FILE = Path(__file__).with_name("converged.json")
SHAPES: tuple[Shape, ...] = ("grid", "mesh")
SOLVER: dict[str, Any] = {"filter": "sweeps", "iterations": 2000, "tolerance": 1e-4}
Path3 = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Centre of mass [m], shape (frames + 1, 3), and its speed [m/s], shape (frames + 1,)."""


@dataclass(frozen=True, slots=True)
class Converged:
    """A motion in the file."""

    trial: Trial
    """What moves."""
    substeps: int = 240
    """Steps a frame of the sweeps [1]."""
    frames: int = 60
    """How many are kept [1]."""


def _tip(mass: float) -> Trial:
    weights = [{"nearest": [1.0, 1.0, 0.0], "mass": mass}]
    return Trial("one-corner", 33**2, 0.1, "grid", cloth={"weights": weights})


def _carried(shape: Shape) -> Trial:
    """A sheet whose corners are carried together and up, faster than it falls."""
    pins = [
        {
            "nearest": [0.0, y, 0.0],
            "move": [[0.0, [0.0, 0.0, 0.0]], [0.5, [0.3, turn, 0.8]], [0.8, [-0.2, 0.0, 0.4]]],
        }
        for y, turn in ((0.0, 0.3), (1.0, -0.3))
    ]
    return Trial("two-corners", 33**2, 0.05, shape, cloth={"pins": pins})


MESHES = {
    f"{scene} {100 * limit:g} %, {across}²": Converged(Trial(scene, across**2, limit), substeps)
    for across, substeps in ((33, 240), (65, 480))
    for scene, limit in (
        ("one-corner", 0.1),
        ("two-corners", 0.1),
        ("one-corner", 0.01),
        ("skirt", 0.05),
        ("cape", 0.05),
    )
}
"""Irregular meshes, for the first second."""
SCALES = {
    f"{name}, {shape}": Converged(
        Trial("one-corner", 33**2, 0.1, shape, size=size), round(240 / size**0.5), round(60 * size**0.5)
    )
    for name, size in (("0.1 m", 0.1), ("20 m", 20.0))
    for shape in SHAPES
}
"""Sheets of other sizes: a second of a sheet of 1 m, scaled by the root of the size."""
TIPS = {f"{mass:g} kg": Converged(_tip(mass), 480) for mass in (0.05, 0.1, 0.2, 0.5)}
"""Weights at the free corner of a sheet of 0.2 kg."""
PENDULUMS = {
    f"pendulum, {shape}": Converged(Trial("pendulum", 33**2, 0.05, shape, cloth={"air_drag": 0.0}), 240, 300)
    for shape in SHAPES
}
"""Sheets that swing from their upper edge, a little."""
PULLED = {
    "net": Converged(Trial("net", 17**2, 0.05), 960),
    "moving pins, grid": Converged(_carried("grid")),
    "moving pins, mesh": Converged(_carried("mesh")),
}
"""What pulls hard at single vertices."""
ALL = MESHES | SCALES | TIPS | PENDULUMS | PULLED


@cache
def converged(name: str) -> Path3:
    """The motion of that name, from the file."""
    found = json.loads(FILE.read_text())[name]
    return np.array(found["centre_of_mass"]), np.array(found["speed"])


def main() -> None:
    """Simulates and writes the file."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m tools.targets.converged")
    parser.add_argument("--only", action="append", choices=ALL, metavar="NAME", help=", ".join(ALL))
    names = parser.parse_args().only or list(ALL)
    kept = json.loads(FILE.read_text()) if FILE.exists() else {}
    for name in names:
        one = ALL[name]
        places, speeds = path(one.trial.simulation(SOLVER | {"substeps": one.substeps}), one.frames)
        print(f"{name}: peak speed {speeds.max():.4f} m/s", flush=True)
        # Six digits of the size, whatever it is.
        digits = 5 - round(np.log10(one.trial.size))
        kept[name] = {
            "substeps": one.substeps,
            "centre_of_mass": places.round(digits).tolist(),
            "speed": speeds.round(digits).tolist(),
        }
    lines = [f"{json.dumps(name)}: {json.dumps(kept[name])}" for name in ALL if name in kept]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
