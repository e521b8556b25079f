"""Cloth that is displaced while a simulation runs, and simulations that are doubled."""

from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation

AWAY = np.array([3.0, -2.0, 0.5])


@pytest.mark.parametrize("integrator", ["euler", "bdf2"])
def test_displaced_cloth_goes_on_as_if_nothing_had_happened(flag: dict[str, Any], integrator: str) -> None:
    scene = Scene({**flag, "solver": {"integrator": integrator}})
    stays, goes = Simulation(scene, threads=1), Simulation(scene, threads=1)
    stays.run(20)
    goes.run(20)
    assert not goes.translate(AWAY)
    np.testing.assert_allclose(goes.positions, stays.positions + AWAY, atol=1e-6)
    np.testing.assert_array_equal(goes.velocities, stays.velocities)
    stays.run(20)
    report = goes.run(20)
    np.testing.assert_allclose(goes.positions, stays.positions + AWAY, atol=1e-4)
    np.testing.assert_allclose(goes.velocities, stays.velocities, atol=1e-2)
    assert report.worst_stretch <= 0.05 + 1e-5 and report.held_back_pins == 0


def test_what_is_held_goes_along(flag: dict[str, Any]) -> None:
    held = Simulation(Scene(flag), threads=1)
    held.hold(34, held.positions[34], over=0.1)
    held.shift_pins(0, (0, 0.1, 0), speed=1.0)
    held.run(10)
    place = held.exact_positions[34]
    held.translate(AWAY)
    held.run(5)
    np.testing.assert_allclose(held.exact_positions[34], place + AWAY, atol=1e-6)
    np.testing.assert_allclose(held.pin_offset(0), AWAY + [0, 0.1, 0], atol=1e-9)
    assert np.abs(held.velocities).max() < 30


def test_one_of_two_cloths_goes_and_comes_into_a_ball() -> None:
    def sheet(name: str, height: float) -> dict[str, Any]:
        grid = {"size": [0.5, 0.5], "cells": [8, 8], "origin": [-0.25, -0.25, height], "axes": ["x", "y"]}
        return {"name": name, "grid": grid, "thickness": 0.004}

    ball = {"name": "ball", "sphere": {"center": [2, 0, -0.03], "radius": 0.05}}
    scene = Scene({"fps": 60, "gravity": [0, 0, 0], "body": [ball], "cloth": [sheet("a", 0), sheet("b", 1)]})
    two = Simulation(scene, threads=1)
    before = two.positions.copy()
    found = two.translate((2, 0, 0), cloth="a")
    assert found.count > 0 and found.places[0].cloth == "a" and found.places[0].other == "ball"
    np.testing.assert_array_equal(two.positions[81:], before[81:])
    np.testing.assert_allclose(two.positions[:81], before[:81] + np.float32([2, 0, 0]), atol=1e-6)
    two.run(60)
    assert not two.intersections(), "it comes apart, as at a start"
    with pytest.raises(KeyError, match="cloth = 'c': must be one of a, b"):
        two.translate((0, 0, 0), cloth="c")
    for offset in ((0, 0), (0, 0, np.nan), (1e300, 0, 0)):
        with pytest.raises(ValueError, match="offset"):
            two.translate(offset)


def test_a_clone_goes_on_by_itself(flag: dict[str, Any]) -> None:
    first = Simulation(Scene(flag), threads=1)
    first.hold(34, first.positions[34])
    first.run(5)
    first.wind = None
    first.translate(AWAY)
    second = first.clone()
    assert second.state_hash == first.state_hash and second.steps == first.steps
    first.run(5)
    assert second.state_hash != first.state_hash
    second.run(5)
    assert second.state_hash == first.state_hash
    np.testing.assert_array_equal(second.held, [34])
