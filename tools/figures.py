"""`make figures`: the tables of docs/methods/filters.md and two figures of the paper, from runs made now.

`taut compare` measures the scenes with each filter as its authors use it, `taut figures` makes the figures of
the paper; here both are put into that page and docs/pictures. A second table gives all filters the same
integrator and the same steps, so that nothing but the filter differs.
"""

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from documents import ROOT, keep, rewrite
from taut import Scene, Simulation, SimulationError
from taut.scene import find_scene

OUT = ROOT / "out" / "figures"
PAGE = ROOT / "docs" / "methods" / "filters.md"
TAUT = Path(sys.executable).with_name("taut")

SCENES = ["flag", "flag-strong", "one-corner", "two-corners", "curtain", "cape"]
METHODS = ["none", "sequential", "sweeps", "coarse_to_fine"]
SHOWN = {"fig5.jpg": "flag", "fig6-7.jpg": "one-corner"}
"""Figures of the paper that documents show, and their names in docs/pictures."""


def measured(scene: str) -> dict[str, Any]:
    """What `taut compare` finds for a scene."""
    out = OUT / scene
    options = ["--filters", ",".join(METHODS), "--no-equal-stretch", "--no-film", "--overwrite"]
    subprocess.run([TAUT, "compare", scene, "--out", out, *options], check=True, cwd=ROOT)
    found: dict[str, Any] = json.loads((out / "compare.json").read_text())
    return found


def in_the_same_steps(name: str) -> tuple[int, list[str]]:
    """Steps a frame that the bare springs need, and a cell for each filter in just those steps."""
    scene = Scene.load(find_scene(name))
    bare = Simulation(scene.with_settings(['solver={ filter = "none", integrator = "euler" }']))
    cells = []
    for method in METHODS:
        settings = f'solver={{ filter = "{method}", integrator = "euler", substeps = {bare.substeps} }}'
        simulation = Simulation(scene.with_settings([settings]))
        worst, ms = -1.0, []
        try:
            for _ in range(scene.frames - 1):
                start = time.perf_counter()
                report = simulation.step(simulation.substeps)
                ms.append(1e3 * (time.perf_counter() - start))
                worst = max(worst, report.worst_stretch)
        except SimulationError:
            cells.append("not finite")
            continue
        cells.append(f"{100 * worst:.2f} %, {np.median(ms):.1f} ms")
    return bare.substeps, cells


def main() -> None:
    """Run, render, rewrite."""
    OUT.mkdir(parents=True, exist_ok=True)
    subprocess.run([TAUT, "figures", "--out", OUT / "paper", "--overwrite"], check=True, cwd=ROOT)
    for picture, name in SHOWN.items():
        keep(OUT / "paper" / "pictures" / picture, name)
    rows = ["| scene | vertices | limit | " + " | ".join(f"`{method}`" for method in METHODS) + " |"]
    rows.append("|---|---|---|" + "---|" * len(METHODS))
    for scene in SCENES:
        found = measured(scene)
        cells = [f"{100 * run['worst_stretch']:.2f} %, {run['ms_per_frame']:.1f} ms" for run in found["runs"]]
        limit = f"{100 * found['scene']['strain_limit']:g} %"
        size = found["scene"]["vertices"]
        rows.append(f"| `{scene}` | {size} | {limit} | " + " | ".join(cells) + " |")
    machine = f"{found['threads']} threads on {found['machine']}"
    rows += [
        "",
        f"Worst stretch of any spring in any frame, and median time to simulate a frame ({machine}).",
    ]
    head = ["scene", "steps a frame", *(f"`{method}`" for method in METHODS)]
    rows += ["", "| " + " | ".join(head) + " |", "|---|---|" + "---|" * len(METHODS)]
    for scene in SCENES:
        steps, cells = in_the_same_steps(scene)
        rows.append(f"| `{scene}` | {steps} | " + " | ".join(cells) + " |")
    rows += [
        "",
        "The same with the same Euler steps for all, as many as the bare springs need to be stable: nothing "
        "but the filter differs. Left to itself `coarse_to_fine` takes fewer steps and divides them inside.",
    ]
    rewrite(PAGE, "figures", "\n".join(rows))


if __name__ == "__main__":
    main()
