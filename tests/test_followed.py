"""Contact goes on where limits, or what is held, change: as one that is made anew."""

from typing import Any

import numpy as np
from taut import Scene, Simulation

FRAMES = 40


def _sheet() -> Simulation:
    """A sheet that falls on a ball while its limit tightens."""
    grid = {"size": [0.6, 0.6], "cells": [20, 20], "origin": [-0.3, -0.3, 0.3], "axes": ["x", "y"]}
    cloth: dict[str, Any] = {"name": "sheet", "grid": grid, "thickness": 0.003, "strain_limit": 0.1}
    cloth["strain_limit_keyframes"] = [[0.5, 0.02]]
    ball = {"name": "ball", "sphere": {"center": [0, 0, 0], "radius": 0.2}}
    return Simulation(Scene({"fps": 60, "cloth": [cloth], "body": [ball]}), 1)


def _run(simulation: Simulation, frames: range) -> None:
    """With a vertex that is held from frame 15 on, and let go in frame 30."""
    for frame in frames:
        if frame == 15:
            simulation.hold([7], simulation.positions[[7]].astype(float) + [0.0, 0.0, 0.05], over=0.1)
        if frame == 30:
            simulation.release([7])
        assert simulation.run(1).penetrations == 0


def test_contact_goes_on_as_one_that_is_made_anew() -> None:
    whole = _sheet()
    _run(whole, range(FRAMES))
    for halfway in (8, 20, 35):
        first, second = _sheet(), _sheet()
        _run(first, range(halfway))
        second.restore(first.snapshot())
        _run(second, range(halfway, FRAMES))
        assert np.array_equal(whole.positions, second.positions)
        assert whole.state_hash == second.state_hash
