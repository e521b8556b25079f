"""What intersects at the start comes apart and stays so; the IPC Toolkit says whether it does."""

from typing import Any

import pytest
from taut import Scene, Simulation

from tools.targets.contact.judge import Oracle


def sheet(height: float, cells: int = 14, **fields: Any) -> dict[str, Any]:
    """A sheet of 0.6 m around the z axis."""
    grid = {"size": [0.6, 0.6], "cells": [cells, cells], "axes": ["x", "y"], "origin": [-0.3, -0.3, height]}
    return {"grid": grid, "thickness": 0.004, "strain_limit": 0.05, **fields}


SCENES: dict[str, dict[str, Any]] = {
    "ball": {"cloth": [sheet(0.17)], "body": [{"sphere": {"center": [0.02, 0.01, 0], "radius": 0.2}}]},
    "capsule": {
        "cloth": [sheet(0.08)],
        "body": [{"capsule": {"from": [-0.4, 0, 0], "to": [0.4, 0.1, 0], "radius": 0.1}}],
    },
    "box": {"cloth": [sheet(0.13)], "body": [{"box": {"size": [0.3, 0.3, 0.3], "rotate": [10, 5, 20]}}]},
    "layers": {"cloth": [sheet(0.0), sheet(0.004, 13, rotate=[2, -2, 10], layer=1)], "gravity": [0, 0, 0]},
}


@pytest.mark.parametrize("name", list(SCENES))
def test_it_comes_apart_and_stays_so(name: str) -> None:
    simulation = Simulation(Scene(SCENES[name]))
    assert simulation.intersections()
    left = []
    for _ in range(60):
        report = simulation.step()
        assert report.worst_stretch_in_steps <= 0.05 * (1 + 1e-5)
        left.append(report.penetrations)
    assert left[0] > 0 and left[-20:] == [0] * 20, left
    oracle = Oracle(simulation)
    for _ in range(20):
        simulation.step()
        seen = oracle.look(simulation)
        assert seen.clean, seen


def test_it_stays_as_it_is_where_that_is_asked_for() -> None:
    scene = Scene(SCENES["box"] | {"contact": {"untangle": False}})
    simulation = Simulation(scene)
    assert "contact takes no crossing back" in simulation.warnings[0]
    assert simulation.step().penetrations == 0 and simulation.intersections()
