"""Tensile test of a strip: the force that it takes to lengthen cloth (Fig. 2 of the paper)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.scene import Scene
from taut.simulation import Simulation

WIDTH, LENGTH = 0.2, 0.05
"""The strip [m], as in the Kawabata system: wide and short, so that its sides matter little."""
CELLS = (24, 6)
SECONDS = 2.0
"""Time to pull it to the furthest [s]: slow against its vibrations."""
AIR_DRAG = 40.0
"""Drag of the air [1/s]: takes them away."""
FPS = 60.0


@dataclass(frozen=True)
class Pull:
    """What a strip did while it was pulled."""

    strain: NDArray[np.float64]
    """Lengthening over the length [1], shape (samples,)."""
    force: NDArray[np.float64]
    """Force per width [N/m], shape (samples,): the slope of the stored energy."""
    limit: float | None
    """Strain at which the strain limit stops it, whatever the force [1]; None if that was not reached."""


def pull(cloth: Mapping[str, Any], furthest: float = 0.1, filter: str = "coarse_to_fine") -> Pull:
    """Pull one end of a strip of cloth along its warp while the other one is held.

    Args:
        cloth: fields of a cloth's material: ``{"fabric": "wool"}``, ``{"curves": {"tension": [..]}}``.
        furthest: strain to pull it to [1]; a limit stops it before.
        filter: the strain limit, a value of ``solver.filter``.

    Raises:
        SceneError: `cloth` is not the material of a cloth, or `filter` is unknown.
        ValueError: `furthest` is out of range.
    """
    if not 0.0 < furthest <= 1.0:
        raise ValueError(f"furthest = {furthest}: must be in (0, 1]; try 0.1")
    strip = {
        "air_drag": AIR_DRAG,
        **cloth,
        "grid": {"size": [WIDTH, LENGTH], "cells": list(CELLS), "axes": ["x", "y"]},
    }
    if filter == "none":
        strip["strain_limit"] = 1.0
    scene = Scene({"gravity": [0, 0, 0], "cloth": [strip], "solver": {"filter": filter}})
    limit = float(scene.document["cloth"][0]["strain_limit"])
    stopped = furthest >= limit
    # Close to the limit it is the filter that carries the load, and no energy tells its share.
    end = 0.999 * limit if stopped else furthest
    moved = [[0.0, [0, 0, 0]], [SECONDS, [0, end * LENGTH, 0]]]
    strip["pins"] = [{"edge": "bottom"}, {"edge": "top", "move": moved}]
    document = scene.document | {"fps": FPS, "duration": SECONDS, "cloth": [strip]}
    simulation = Simulation(Scene(document))
    energies = [simulation.report.elastic_energy]
    for _ in range(round(SECONDS * FPS)):
        simulation.run(1)
        energies.append(simulation.report.elastic_energy)
    strain = np.linspace(0.0, end, len(energies))
    force = np.diff(energies) / np.diff(strain) / (WIDTH * LENGTH)
    return Pull(0.5 * (strain[1:] + strain[:-1]), force, limit if stopped else None)
