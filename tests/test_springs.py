"""What springs tell: how far they are stretched, and what they carry."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation, SimulationError

G = 9.81


def chain(points: Any, mass: float = 0.01, **cloth: Any) -> Simulation:
    links = [[k, k + 1] for k in range(len(points) - 1)]
    network = {"points": points, "links": links, "mass": mass}
    given = {"network": network, "pins": [{"vertices": [0]}], "damping": 0.0} | cloth
    return Simulation(Scene({"cloth": [given]}), threads=1)


def pulls(simulation: Simulation, tensions: NDArray[np.float64]) -> NDArray[np.float64]:
    """The force of all springs on each vertex [N]."""
    places, (u, v) = simulation.exact_positions, simulation.springs.T
    ways = places[v] - places[u]
    ways *= (tensions / np.linalg.norm(ways, axis=1))[:, None]
    forces = np.zeros_like(places)
    np.add.at(forces, u, ways)
    np.add.at(forces, v, -ways)
    return forces


@pytest.mark.parametrize("links", [8, 40])
def test_a_link_of_a_chain_carries_what_hangs_below_it(links: int) -> None:
    hanging = chain([[0, 0, -k / links] for k in range(links + 1)], air_drag=0.5)
    hanging.run(240)
    below = G * 0.01 * np.arange(links, 0, -1)
    np.testing.assert_allclose(hanging.spring_tensions, below, atol=0.01 * below[0])
    # Hooke's law alone does not carry that: the limit does.
    assert hanging.spring_stretch.max() == pytest.approx(hanging.report.worst_stretch, abs=1e-6)


@pytest.mark.parametrize("limited", [True, False])
def test_a_pendulum_pulls_with_its_weight_and_its_speed(limited: bool) -> None:
    filters = {"strain_limit": 0.001, "stiffness": 100.0} if limited else {"stiffness": 1e4}
    pendulum = chain([[0, 0, 0], [1, 0, 0]], air_drag=0.0, **filters)
    if not limited:
        pendulum = Simulation(pendulum.scene.with_settings(["solver.filter=none", "solver.substeps=32"]))
    tensions, expected = [], []
    for _ in range(30):
        pendulum.step(pendulum.substeps)
        tensions.append(float(pendulum.spring_tensions[0]))
        # Of energy: m v^2 / L = 2 m g cos, and m g cos of the weight.
        expected.append(3 * 0.01 * G * -float(pendulum.exact_positions[1, 2]))
    assert max(expected) > 0.2
    assert np.abs(np.subtract(tensions, expected)[3:]).max() < 0.05 * max(expected)


@pytest.mark.parametrize("pins", [[{"edge": "top"}], [{"corner": "top-left"}, {"corner": "top-right"}]])
@pytest.mark.parametrize("bending", [0.0, "fabric"])
def test_pins_bear_the_weight_of_a_sheet(pins: Any, bending: Any) -> None:
    grid = {"size": [1, 1], "cells": [12, 12], "axes": ["x", "z"]}
    weights = [{"edge": "bottom", "mass": 0.1}]
    cloth = {"grid": grid, "pins": pins, "weights": weights, "air_drag": 0.5, "bending": bending}
    sheet = Simulation(Scene({"cloth": [cloth]}), threads=1)
    sheet.run(360)
    forces = pulls(sheet, sheet.spring_tensions)
    borne = -forces[sheet.pinned].sum(axis=0)
    weight = G * sheet.mass[~sheet.pinned].sum()
    np.testing.assert_allclose(borne, [0, 0, weight], atol=0.01 * weight)


def test_a_sheet_that_lies_on_a_plane_carries_next_to_nothing() -> None:
    grid = {"size": [1, 1], "cells": [12, 12], "origin": [0, 0, 0.003], "axes": ["x", "y"]}
    floor = {"plane": {"normal": [0, 0, 1]}}
    lying = Simulation(Scene({"body": [floor], "cloth": [{"grid": grid, "thickness": 0.002}]}), threads=1)
    lying.run(60)
    weight = G * float(lying.mass.sum())
    forces = np.linalg.norm(pulls(lying, lying.spring_tensions), axis=1)
    assert forces.max() < 0.01 * weight


def test_tensions_are_those_of_a_step(flag: dict[str, Any]) -> None:
    simulation = Simulation(Scene(flag), threads=1)
    with pytest.raises(SimulationError, match="no|none since the start.*call step"):
        _ = simulation.spring_tensions
    simulation.step(3)
    before, tensions = simulation.state_hash, simulation.spring_tensions
    assert (tensions.shape, tensions.dtype) == ((len(simulation.springs),), np.float64)
    assert simulation.spring_stretch.dtype == np.float32
    np.testing.assert_array_equal(tensions, simulation.spring_tensions)
    assert simulation.state_hash == before
    again = Simulation(Scene(flag), threads=2)
    again.step(3)
    np.testing.assert_array_equal(again.spring_tensions, tensions)
    again.restore(simulation.snapshot())
    with pytest.raises(SimulationError, match="since the state was set"):
        _ = again.spring_tensions
