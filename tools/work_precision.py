"""`make work-precision`: what each integrator's accuracy costs, after Volino & Magnenat-Thalmann 2001.

A sheet that hangs from one edge is pushed and swings, soft and a hundred times as stiff. Every integrator
takes it through a second in more and more steps; the error is the root mean square distance of its vertices
from where the classical Runge-Kutta method leaves them with very short steps. Rewrites the table and the
picture of docs/methods/integrators.md.
"""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import taut
from numpy.typing import NDArray

matplotlib.use("Agg")
from matplotlib import pyplot as plt

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "methods" / "integrators.md"
PICTURE = ROOT / "docs" / "pictures" / "work-precision.png"
BEGIN, END = "<!-- work-precision: begin -->\n", "<!-- work-precision: end -->"

INTEGRATORS = ["forward_euler", "euler", "midpoint", "verlet", "rk4", "implicit_euler", "bdf2"]
SECONDS, CELLS = 1.0, 16
STIFFNESS = {"soft": 4.0, "stiff": 400.0}
"""Membrane stiffness [N/m]."""
STEPS = [round(2 ** (power / 2)) for power in range(6, 27)]
"""Steps in a second [1]."""
REFERENCE_STEPS = 4096
TARGETS = {"1 mm": 1e-3, "50 µm": 5e-5}
"""Errors for the table [m]."""
WORST, FINEST = 0.1, 5e-6
"""Errors beyond which the motion is another one, and below which single precision is seen [m]."""
REPEATS = 2


@dataclass(frozen=True)
class Run:
    """A second of an integrator."""

    steps: int
    """Steps taken [1]."""
    passes: int
    """How often it looked at all springs [1]."""
    milliseconds: float
    """Time of the processor, the least of a few tries [ms]."""
    error: float
    """Root mean square distance from the reference [m]; infinite if it left the room."""


def simulation(integrator: str, stiffness: float, steps: int) -> taut.Simulation:
    """The sheet at the start, to be taken through a second in so many steps."""
    sheet = {
        "grid": {"size": [1.0, 1.0], "cells": [CELLS, CELLS], "origin": [-0.5, 0.0, -1.0]},
        "density": 0.2,
        "stiffness": stiffness,
        "shear_stiffness": 0.5 * stiffness,
        "damping": 0.0005,
        "air_drag": 0.2,
        "bending": 1e-4,
        "strain_limit": 0.5,
        "pins": [{"edge": "top"}],
    }
    solver = {"integrator": integrator, "filter": "none", "substeps": steps, "force_step": True}
    scene = {
        "fps": 1 / SECONDS,
        "duration": SECONDS,
        "gravity": [0, 0, -2.0],
        "cloth": [sheet],
        "solver": solver,
    }
    sheet_at_start = taut.Simulation(taut.Scene(scene), threads=1)
    places = sheet_at_start.positions
    x, depth = places[:, 0], -places[:, 2]
    push = np.stack([np.zeros_like(x), depth * (1.5 + 0.5 * np.sin(2 * x)), np.zeros_like(x)], axis=1)
    sheet_at_start.set_state(places, push.astype(np.float32), 0)
    return sheet_at_start


def measure(integrator: str, stiffness: float, steps: int, reference: NDArray[np.float64]) -> Run:
    """Take the sheet through the second, a few times."""
    times = []
    for _ in range(REPEATS):
        run = simulation(integrator, stiffness, steps)
        start = time.thread_time()
        try:
            passes = run.step(steps).evaluations
        except taut.SimulationError:
            return Run(steps, 0, np.inf, np.inf)
        times.append(1e3 * (time.thread_time() - start))
    apart = run.positions - reference
    error = float(np.sqrt(np.mean(np.sum(apart**2, axis=1))))
    return Run(steps, passes, min(times), error if error < WORST else np.inf)


def measure_all(stiffness: float) -> dict[str, list[Run]]:
    """All integrators on one sheet, as far as they follow the motion and single precision can tell."""
    finest = simulation("rk4", stiffness, REFERENCE_STEPS)
    finest.step(REFERENCE_STEPS)
    reference = finest.positions.astype(np.float64)
    found: dict[str, list[Run]] = {}
    for integrator in INTEGRATORS:
        found[integrator] = []
        for steps in STEPS:
            run = measure(integrator, stiffness, steps, reference)
            if np.isfinite(run.error):
                found[integrator].append(run)
            if run.error < FINEST:
                break
        print(integrator, *(f"{run.steps}: {run.error:.1e}" for run in found[integrator]), flush=True)
    return found


def passes_for(runs: list[Run], error: float) -> int | None:
    """Passes that reach an error [m], between two runs by a power law; nothing if none does."""
    for coarse, fine in zip(runs, runs[1:], strict=False):
        if fine.error <= error < coarse.error:
            part = np.log(coarse.error / error) / np.log(coarse.error / fine.error)
            return round(coarse.passes * (fine.passes / coarse.passes) ** part)
    return runs[0].passes if runs and runs[0].error <= error else None


def order(runs: list[Run]) -> float:
    """Mean slope of error over steps where the error is below 1 mm and above what rounding leaves."""
    kept = [run for run in runs if 2 * FINEST < run.error < 2e-3]
    if len(kept) < 2:
        return float("nan")
    return float(-np.polyfit(np.log([run.steps for run in kept]), np.log([run.error for run in kept]), 1)[0])


def table(results: dict[str, dict[str, list[Run]]]) -> str:
    """One row an integrator, one column a sheet and an error."""
    heads = [f"{sheet}, {name}" for sheet in results for name in TARGETS]
    longest = [f"longest step, {sheet}" for sheet in results]
    lines = [
        "| integrator | order | " + " | ".join(heads + longest) + " |",
        "|---" * (2 + len(heads + longest)) + "|",
    ]
    for integrator in INTEGRATORS:
        numbers = [
            passes_for(results[sheet][integrator], error) for sheet in results for error in TARGETS.values()
        ]
        cells = ["–" if number is None else f"{number}" for number in numbers]
        firsts = [results[sheet][integrator][:1] for sheet in results]
        cells += [f"{1e3 * SECONDS / first[0].steps:.3g} ms" if first else "–" for first in firsts]
        slope = order(results["soft"][integrator])
        lines.append(
            f"| `{integrator}` | {'–' if np.isnan(slope) else f'{slope:.2f}'} | " + " | ".join(cells) + " |"
        )
    return "\n".join(lines) + "\n"


def draw(results: dict[str, dict[str, list[Run]]]) -> None:
    """Error over passes and over time, a row a sheet."""
    figure, rows = plt.subplots(len(results), 2, figsize=(10, 8.4), sharey=True, layout="constrained")
    quantities: list[tuple[str, str]] = [
        ("passes", "passes over all springs"),
        ("milliseconds", "processor time [ms]"),
    ]
    for row, (sheet, found) in zip(rows, results.items(), strict=True):
        for axes, (quantity, label) in zip(row, quantities, strict=True):
            for number, integrator in enumerate(INTEGRATORS):
                runs: list[Any] = found[integrator]
                values = [getattr(run, quantity) for run in runs]
                style = "--" if "implicit" in integrator or integrator == "bdf2" else "-"
                errors = [run.error for run in runs]
                axes.loglog(values, errors, style, marker="osD^v<>"[number], markersize=4, label=integrator)
            axes.axhspan(1e-6, FINEST, color="0.9")
            axes.set(title=f"{sheet} sheet, {STIFFNESS[sheet]:g} N/m", xlabel=label, ylim=(1e-6, WORST))
            axes.grid(alpha=0.3)
        row[0].set_ylabel("error [m]")
    figure.legend(*rows[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=len(INTEGRATORS))
    figure.savefig(PICTURE, dpi=90)


def main() -> None:
    """Measure, rewrite the page, draw."""
    results = {sheet: measure_all(stiffness) for sheet, stiffness in STIFFNESS.items()}
    head, rest = PAGE.read_text().split(BEGIN)
    PAGE.write_text(head + BEGIN + table(results) + END + rest.split(END)[1])
    draw(results)


if __name__ == "__main__":
    main()
