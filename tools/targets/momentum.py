"""The row about momentum: what no force acts on keeps it."""

from typing import Any

import numpy as np
from taut import Scene, Simulation

from tools.targets.table import Effort, Row

FREE: dict[str, dict[str, Any]] = {
    "dumbbell": {"network": {"mass": 0.1, "points": [[0, 0, 0], [1, 0, 0]], "links": [[0, 1]]}},
    "sheet": {"grid": {"size": [1.0, 1.0], "cells": [32, 32], "axes": ["x", "y"]}, "density": 0.2},
}
SOFT = {"stiffness": 1.0, "damping": 0.0, "air_drag": 0.0, "strain_limit": 0.05}
"""So soft and turning so fast that the limit has to hold the cloth together all the time."""
SPIN = 4.0  # [1/s]
SECONDS = 10


RAW = 1e-5
"""Momentum that rounding may take in ten seconds, before it is given back [1]."""


def drift(effort: Effort) -> Row:
    """Largest drift of the momentum, relative to what it was."""
    target = "free dumbbell and free sheet, 10 s: momentum drifts by ≤ 1e-6"
    return _row(effort, target, 1e-6, repaired=True)


def raw(effort: Effort) -> Row:
    """The same without what the engine gives back."""
    target = f"the same before what rounding took is given back: ≤ {RAW:.0e}"
    return _row(effort, target, RAW, repaired=False)


def _row(effort: Effort, target: str, most: float, repaired: bool) -> Row:
    parts, worst = [], 0.0
    for name, fields in FREE.items():
        simulation = Simulation(Scene({"gravity": [0.0, 0.0, 0.0], "cloth": [SOFT | fields]}))
        x, y, _ = (simulation.positions - simulation.positions.mean(axis=0)).T
        wave = 0.3 * np.sin(0.7 * np.arange(len(x)))
        simulation.velocities = np.column_stack([1 - SPIN * y, SPIN * x, wave])
        mass = simulation.mass.astype(np.float64)
        before = mass @ simulation.velocities
        off, limited, given = 0.0, 0, np.zeros(3)
        for _ in range(SECONDS * 60 if effort.divide == 1 else effort.frames):
            report = simulation.step(simulation.substeps)
            limited += report.limited_steps
            given += 0 if repaired else report.repaired_momentum
            off = max(off, float(np.linalg.norm(mass @ simulation.velocities - given - before)))
        worst = max(worst, off / float(np.linalg.norm(before)))
        parts.append(
            f"{name} {off / np.linalg.norm(before):.1e} ({limited} of {simulation.steps} steps limited)"
        )
    return Row(target, "; ".join(parts), worst <= most)
