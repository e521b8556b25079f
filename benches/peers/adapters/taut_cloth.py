"""taut itself, on one thread, with its defaults but for damping and air drag, which no peer has here either.

settings: strain_limit [1]; any others are fields of a scene's ``solver``.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut import Scene, Simulation

from harness import Job, serve

CORNERS = ("bottom-left", "top-left")
"""The corners that the scenes pin, in the job's order."""


class Grid:
    """The sheet as a grid."""

    def __init__(self, job: Job) -> None:
        """Build the simulation."""
        cells = round(len(job.positions) ** 0.5) - 1
        cloth = {
            "name": "sheet",
            "grid": {"size": [1.0, 1.0], "cells": [cells, cells], "origin": [0, 0, 0], "axes": ["x", "y"]},
            "fabric": "cotton",
            "strain_limit": job.settings["strain_limit"],
            "density": float(job.masses.sum()),
            "damping": 0.0,
            "air_drag": 0.0,
            "pins": [{"corner": corner} for corner in CORNERS[: len(job.pins)]],
        }
        solver = {key: value for key, value in job.settings.items() if key != "strain_limit"}
        scene = Scene({"title": "sheet", "duration": 5.0, "fps": 60, "solver": solver, "cloth": [cloth]})
        self._simulation = Simulation(scene, threads=1)
        if not np.allclose(self._simulation.positions, job.positions, atol=1e-6):
            raise ValueError("taut numbers the grid's vertices differently from the job")

    def frame(self) -> None:
        """Advance by 1/60 s."""
        self._simulation.step(self._simulation.substeps)

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        return self._simulation.positions


if __name__ == "__main__":
    serve(Grid)
