"""`make local-correction`: what `solver.local_correction` saves, for docs/methods/filters.md.

Two scenes are run with `sweeps` on one thread, with and without it; all frames must agree to the last bit.
"""

import time
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut import Scene, Simulation

from tools.documents import ROOT, rewrite

SCENES = {"flag": "a flag in the wind", "two-corners": "a sheet that falls and hangs from two corners"}
FRAMES = 60


def frames(scene: str, local: bool) -> tuple[list[float], list[NDArray[np.float32]]]:
    """Times of the frames [s], and positions [m]."""
    switch = f"solver.local_correction={str(local).lower()}"
    simulation = Simulation(Scene.load(scene).with_settings(["solver.filter=sweeps", switch]), 1)
    times, positions = [], []
    for _ in range(FRAMES):
        start = time.perf_counter()
        simulation.step(simulation.substeps)
        times.append(time.perf_counter() - start)
        positions.append(simulation.positions.copy())
    return times, positions


def row(scene: str, meaning: str) -> str:
    """One line of the table."""
    found: dict[bool, Any] = {local: frames(scene, local) for local in (False, True)}
    if any((a != b).any() for a, b in zip(found[False][1], found[True][1], strict=True)):
        raise SystemExit(f"{scene}: local correction changed the result")
    every, local = (1e3 * median(found[local][0]) for local in (False, True))
    return f"| `{scene}`: {meaning} | {every:.1f} ms | {local:.1f} ms | {every / local:.1f} x |"


def main() -> None:
    """Measure and rewrite the table."""
    lines = ["| scene | every spring in every pass | local correction | saved |", "|---|---|---|---|"]
    lines += [row(scene, meaning) for scene, meaning in SCENES.items()]
    text = "\n".join([*lines, "", f"Median time of a frame, {FRAMES} frames, one thread."])
    print(text)
    rewrite(ROOT / "docs" / "methods" / "filters.md", "local-correction", text)


if __name__ == "__main__":
    main()
