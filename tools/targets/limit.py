"""Rows about the limit itself, counted by NumPy in double precision from the positions."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import count
from typing import Any

import numpy as np
from taut import Scene, Simulation
from taut.bench import irregular_square
from taut.scene import shipped_scenes

from tools.targets.table import Effort, Row

TOLERANCE = 1e-5  # [1], how far over (1 + lambda) still counts as rounding
CELLS = {
    1: 300,
    2: 300,
    4: 300,
    8: 300,
    16: 300,
    32: 200,
    64: 120,
    128: 80,
    256: 60,
}  # and most steps of a case
MESHES = {8: 300, 24: 200, 48: 100}  # irregular ones, the same
LIMITS = (0.01, 0.02, 0.05, 0.10, 0.15)
RATES = (30.0, 60.0, 120.0, 240.0, 500.0, 1000.0)  # [1/s]
SOLVERS: tuple[dict[str, Any], ...] = ({"substeps": "auto"}, {"substeps": 1, "force_step": True})
"""Steps that the engine chooses, and a single one a frame even where that is too long for springs or air."""
WINDS = (0.0, 40.0, 5.0, 25.0, 12.0)  # [m/s]
PINS: tuple[list[dict[str, Any]], ...] = (
    [{"nearest": [0.0, 0.0, 0.0]}],
    [{"nearest": [0.0, 0.0, 0.0]}, {"nearest": [0.0, 1.0, 0.0]}],
    [{"nearest": [0.3, 0.6, 0.0]}],
    [],
)


@dataclass(slots=True)
class Tally:
    """Springs measured and springs over their limit."""

    measured: int = 0
    over: int = 0
    worst: float = -np.inf
    fastest: float = 0.0

    def add(self, simulation: Simulation) -> None:
        """Measures every spring that has a limit."""
        limit = simulation.strain_limit.astype(np.float64)
        u, v = simulation.springs.T
        x = simulation.exact_positions  # single precision is too coarse where a free cloth has gone far
        stretch = np.linalg.norm(x[v] - x[u], axis=1) / simulation.rest_length - 1
        excess = (stretch - limit)[np.isfinite(limit)]
        self.measured += len(excess)
        self.over += int(np.count_nonzero(~(excess <= TOLERANCE)))
        self.worst = max(self.worst, float(excess.max()))
        self.fastest = max(self.fastest, float(np.linalg.norm(simulation.velocities, axis=1).max()))


def bound(effort: Effort) -> Row:
    """Springs over their limit after any step, over many cases, and in the frames of the shipped scenes."""
    tally, cases = Tally(), 0
    for simulation, steps in _cases(effort):
        cases += 1
        for _ in range(steps):
            simulation.step()
            tally.add(simulation)
    _, shipped = _shipped(effort)
    over, measured = tally.over + shipped.over, tally.measured + shipped.measured
    reached = (
        f"{over} of {measured:.2g} springs measured (every step of {cases} cases, every frame of the "
        f"shipped scenes); worst {max(tally.worst, shipped.worst):+.0e}; no particle faster than "
        f"{tally.fastest:.0f} m/s"
    )
    target = (
        "springs over (1 + λ) by more than 1e-5; 2² to 257² particles, meshes, networks, λ 1 to 15 %, "
        "steps of 1/30 to 1/1000 s and automatic ones, wind 0 to 40 m/s: 0"
    )
    return Row(target, reached, over == 0)


def cuts(effort: Effort) -> Row:
    """Steps that the certificate had to shorten."""
    found, _ = _shipped(effort)
    parts = [f"{scene} {number}" for scene, number in found.items() if number]
    reached = f"{sum(found.values())} in {len(found)} scenes" + (f" ({', '.join(parts)})" if parts else "")
    return Row(
        "steps that the certificate had to cut, default settings, shipped scenes: 0", reached, not parts
    )


@cache
def _shipped(effort: Effort) -> tuple[dict[str, int], Tally]:
    """Cuts of each shipped scene, and the springs in all frames."""
    found, tally = {}, Tally()
    for shipped in shipped_scenes():
        scene = Scene.load(shipped.path)
        simulation = Simulation(scene)
        found[shipped.name] = 0
        for _ in range(scene.frames if effort.divide == 1 else effort.frames):
            found[shipped.name] += simulation.step(simulation.substeps).cuts
            tally.add(simulation)
    return found, tally


def _cases(effort: Effort) -> Iterator[tuple[Simulation, int]]:
    """Simulations at their start, and steps to take; every size meets every limit, rate, wind and pins."""
    number = count()
    for cells, most in CELLS.items():
        grid = {"size": [1.0, 1.0], "cells": [effort.cells(cells)] * 2, "axes": ["x", "y"]}
        for _ in range(30 if cells <= 16 else 10):
            yield from _case({"grid": grid}, None, next(number), most * effort.steps)
    for cells, most in MESHES.items():
        vertices, faces = irregular_square(effort.cells(cells))
        for _ in range(10):
            square = {"square": (vertices, faces)}
            yield from _case({"mesh": "square"}, square, next(number), most * effort.steps)


def _case(shape: dict[str, Any], meshes: Any, number: int, most: float) -> Iterator[tuple[Simulation, int]]:
    rate, wind = RATES[number % len(RATES)], WINDS[number // 2 % len(WINDS)]
    cloth = {
        "density": 0.2,
        "strain_limit": LIMITS[number % len(LIMITS)],
        "pins": PINS[number % len(PINS)],
        **shape,
    }
    for solver in SOLVERS:
        document = {
            "fps": rate,
            "wind": {"velocity": [wind, 0.3 * wind, 0.2 * wind], "gust": {}},
            "cloth": [cloth],
            "solver": solver,
        }
        yield Simulation(Scene(document, meshes)), max(1, round(min(most, rate)))
