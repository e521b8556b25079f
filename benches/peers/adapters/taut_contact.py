"""taut itself with contact, on one thread; no bending, damping or air, which no peer has here either.

settings: strain_limit [1]; any others are fields of a scene's ``solver``, and ``finer`` divides its steps.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut import Scene, Simulation

from harness import FPS, Job, serve


class Grid:
    """The sheet as a grid among bodies."""

    def __init__(self, job: Job) -> None:
        """Build the simulation."""
        cells = round(len(job.positions) ** 0.5) - 1
        grid = {"size": [1.0, 1.0], "cells": [cells] * 2, "origin": job.grid["origin"], "axes": ["x", "y"]}
        cloth = {
            "name": "sheet",
            "grid": grid,
            "rotate": [*job.grid["turned"], 0.0],
            "translate": job.grid["moved"],
            "fabric": "cotton",
            "strain_limit": job.settings["strain_limit"],
            "density": float(job.masses.sum()),
            "damping": 0.0,
            "air_drag": 0.0,
            "thickness": job.thickness,
            "friction": job.friction,
        }
        own = ("strain_limit", "finer")
        scene: dict[str, Any] = {"title": "sheet", "duration": 5.0, "fps": FPS, "cloth": [cloth]}
        scene["solver"] = {key: value for key, value in job.settings.items() if key not in own}
        scene["body"] = [body_of(body) | {"friction": job.friction} for body in job.bodies]
        if "finer" in job.settings:
            usual = Simulation(Scene(scene), threads=1).substeps
            scene["solver"]["substeps"] = usual * int(job.settings["finer"])
        self._simulation = Simulation(Scene(scene), threads=1)
        if not np.allclose(self._simulation.positions, job.positions, atol=1e-6):
            raise ValueError("taut numbers the grid's vertices differently from the job")

    def frame(self) -> None:
        """Advance by 1/60 s."""
        self._simulation.step(self._simulation.substeps)

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        return self._simulation.exact_positions


def body_of(body: dict[str, Any]) -> dict[str, Any]:
    """A body of a job as a body of a scene."""
    if body["kind"] == "floor":
        return {"name": "floor", "plane": {"point": [0.0, 0.0, body["height"]], "normal": [0, 0, 1]}}
    if body["kind"] == "ball":
        return {"name": "ball", "sphere": {"center": body["centre"], "radius": body["radius"]}}
    size = [2 * half for half in body["half"]]
    return {"name": "box", "box": {"center": body["centre"], "size": size, "rotate": [*body["turned"], 0.0]}}


if __name__ == "__main__":
    serve(Grid)
