"""Filters of one's own, which see every step before the built-in one."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation, SimulationError

Array = NDArray[np.float32]


def free(**solver: Any) -> Simulation:
    grid = {"size": [1, 1], "cells": [8, 8], "origin": [0, 0, 2], "axes": ["x", "y"]}
    scene = {"gravity": [0, 0, 0], "cloth": [{"grid": grid, "air_drag": 0.0}], "solver": solver}
    return Simulation(Scene(scene), threads=1)


def test_a_hook_that_changes_nothing_changes_no_bit(flag: dict[str, Any]) -> None:
    bare, hooked = Simulation(Scene(flag), threads=1), Simulation(Scene(flag), threads=2)
    seen = []

    def look(positions: Array, velocities: Array, dt: float) -> None:
        assert positions.shape == velocities.shape == (35, 3)
        seen.append(dt)

    bare.step(10)
    hooked.step(10, hook=look)
    assert hooked.state_hash == bare.state_hash
    assert seen == pytest.approx([bare.step_length] * 10)


@pytest.mark.parametrize("solver", [{}, {"filter": "none"}, {"integrator": "rk4", "filter": "none"}])
def test_what_a_hook_gives_is_what_moves(solver: dict[str, Any]) -> None:
    moved = free(**solver)
    start = moved.positions.copy()
    gain = np.float32([0.5, -0.25, 1.0])

    def push(positions: Array, velocities: Array, dt: float) -> None:
        velocities += gain

    moved.step(1, hook=push)
    np.testing.assert_allclose(moved.velocities, np.broadcast_to(gain, start.shape), atol=1e-4)
    np.testing.assert_allclose(moved.positions, start + gain * np.float32(moved.step_length), atol=1e-6)
    moved.step(9)
    np.testing.assert_allclose(moved.positions, start + 10 * gain * np.float32(moved.step_length), atol=1e-5)


def test_a_floor_of_ones_own_holds_what_falls_and_keeps_the_limit() -> None:
    fallen = free()
    fallen.gravity = (0, 0, -9.81)

    def floor(positions: Array, velocities: Array, dt: float) -> None:
        lowest = (1.8 - positions[:, 2]) / np.float32(dt)
        np.maximum(velocities[:, 2], lowest, out=velocities[:, 2])

    for _ in range(60):
        report = fallen.step(fallen.substeps, hook=floor)
        assert report.worst_stretch_in_steps <= fallen.strain_limit.max() + 1e-5
    assert fallen.positions[:, 2] == pytest.approx(1.8, abs=1e-3)


def test_the_limit_has_the_last_word(flag: dict[str, Any]) -> None:
    pulled = Simulation(Scene(flag), threads=1)
    start = pulled.positions[pulled.pinned].copy()

    def tear(positions: Array, velocities: Array, dt: float) -> None:
        velocities[:, 0] += 50

    assert pulled.step(5, hook=tear).worst_stretch_in_steps <= 0.05 + 1e-5
    np.testing.assert_array_equal(pulled.positions[pulled.pinned], start)


def test_fast_bodies_have_steps_proposed_in_parts() -> None:
    grid = {"size": [0.5, 0.5], "cells": [8, 8], "origin": [-0.25, -0.25, 0.01], "axes": ["x", "y"]}
    ball = {"name": "ball", "sphere": {"center": [0, 0, -0.2], "radius": 0.2}}
    scene = {"fps": 60, "body": [ball], "cloth": [{"grid": grid, "thickness": 0.004}]}
    thrown = Simulation(Scene(scene), threads=1)
    lengths = []

    def look(positions: Array, velocities: Array, dt: float) -> None:
        lengths.append(dt)

    thrown.shift_body("ball", (0, 0, 0.15), over=thrown.step_length)
    thrown.step(1, hook=look)
    assert len(lengths) > 1 and sum(lengths) >= thrown.step_length * (1 - 1e-9)
    assert not thrown.intersections()


@pytest.mark.parametrize("kind", [ValueError, KeyboardInterrupt])
def test_what_a_hook_raises_ends_the_call_without_a_trace(
    flag: dict[str, Any], kind: type[BaseException]
) -> None:
    simulation = Simulation(Scene(flag), threads=2)
    before = simulation.state_hash
    calls = []

    def fail(positions: Array, velocities: Array, dt: float) -> None:
        calls.append(dt)
        velocities += 1
        if len(calls) == 3:
            raise kind("no further")

    with pytest.raises(kind, match="no further"):
        simulation.step(5, hook=fail)
    assert len(calls) == 3 and (simulation.state_hash, simulation.steps) == (before, 0)
    again = Simulation(Scene(flag), threads=1)
    simulation.step(5)
    again.step(5)
    assert simulation.state_hash == again.state_hash


def test_bad_hooks_are_refused(flag: dict[str, Any]) -> None:
    simulation = Simulation(Scene(flag), threads=2)

    def spoil(positions: Array, velocities: Array, dt: float) -> None:
        velocities[3] = np.nan

    def reenter(positions: Array, velocities: Array, dt: float) -> None:
        simulation.step()

    wrong: list[tuple[Any, type[Exception], str]] = [
        (spoil, ValueError, r"velocities\[3\] is not finite after the hook"),
        (lambda *_: 1, TypeError, "the hook returned a int: must return None"),
        (lambda: None, TypeError, "takes 0 positional arguments"),
        (reenter, SimulationError, "a hook.* must not use the simulation"),
        (3, TypeError, "hook is a int: must be a function, or None"),
    ]
    for hook, error, words in wrong:
        with pytest.raises(error, match=words):
            simulation.step(2, hook=hook)
        assert simulation.steps == 0
