"""Nets and ropes pass through nothing: the IPC Toolkit and NumPy judge frames and the ways between them."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation

from tools.targets.contact.judge import Oracle, distance_of_links, links_of

Points = NDArray[np.float64]


def net(cells: int, size: float, height: float) -> dict[str, Any]:
    """A level net around the z axis."""
    at = np.linspace(-0.5, 0.5, cells + 1) * size
    x, y = np.meshgrid(at, at)
    points = np.stack([x.ravel(), y.ravel(), np.full(x.size, height)], axis=1)
    number = np.arange(x.size).reshape(x.shape)
    along = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    up = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    return made_of(points, np.concatenate([along, up]), 0.1)


def rope(points: Points) -> dict[str, Any]:
    """A rope along some points."""
    number = np.arange(len(points))
    return made_of(points, np.stack([number[:-1], number[1:]], axis=1), 0.05)


def made_of(points: Points, links: NDArray[np.int64], mass: float) -> dict[str, Any]:
    network = {"points": points.tolist(), "links": links.tolist(), "mass": mass / len(points)}
    return {"network": network, "stiffness": 200.0, "strain_limit": 0.03, "thickness": 0.006, "air_drag": 0.5}


FLOOR = {"name": "floor", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
BALL = {"name": "ball", "sphere": {"center": [0.02, 0.01, 0.25], "radius": 0.12}, "friction": 0.4}
ROD = {
    "name": "rod",
    "capsule": {"from": [-0.3, 0.04, 0.2], "to": [0.3, 0, 0.25], "radius": 0.04},
    "friction": 0.4,
}
BLOCK = {
    "name": "block",
    "box": {"center": [0.02, 0.01, 0.22], "size": [0.2, 0.2, 0.2], "rotate": [45, 35.264, 0]},
}
SHEET = {
    "grid": {"size": [0.5, 0.5], "cells": [12, 12], "axes": ["x", "y"], "origin": [-0.24, -0.26, 0.52]},
    "strain_limit": 0.05,
    "thickness": 0.004,
}
WAVE = np.linspace(-0.5, 0.5, 31)


@pytest.mark.parametrize(
    "scene",
    [
        {"cloth": [net(7, 0.6, 0.42)], "body": [FLOOR, BALL]},
        {"cloth": [net(12, 0.6, 0.44), SHEET], "body": [FLOOR, BLOCK]},
        {"cloth": [net(7, 0.6, 0.54), SHEET], "body": [FLOOR, ROD]},
        {
            "cloth": [
                rope(np.stack([0.04 * np.sin(9 * WAVE), WAVE, 0 * WAVE + 0.3], axis=1)),
                rope(np.stack([WAVE + 0.013, 0.05 * np.cos(7 * WAVE), 0 * WAVE + 0.35], axis=1)),
            ],
            "body": [FLOOR, ROD],
        },
    ],
    ids=["ball", "block under a sheet", "over a sheet", "ropes"],
)
def test_every_step_is_free_of_crossings(scene: dict[str, Any]) -> None:
    simulation = Simulation(Scene(scene))
    oracle = Oracle(simulation)
    touched = 0
    for _ in range(80):
        report = simulation.step()
        assert report.worst_stretch <= simulation.strain_limit.max() * (1 + 1e-5)
        seen = oracle.look(simulation)
        assert seen.clean, seen
        touched += report.contacts
    assert touched > 100
    links = simulation.exact_positions[links_of(simulation)]
    assert len(links) > 20
    for body in simulation.bodies.values():
        if body.shape in ("sphere", "capsule"):
            gap = distance_of_links(links, np.asarray(body.positions)) - body.radius
            assert 0.5 * 0.004 < gap < 1.2 * 0.004, "half of the thickness of a link and the skin of the body"


def test_what_is_wrong_is_seen() -> None:
    level = {**SHEET, "translate": [0, 0, -0.1]}
    simulation = Simulation(Scene({"cloth": [net(7, 0.6, 0.52), level], "body": [BALL]}))
    oracle = Oracle(simulation)
    assert oracle.look(simulation).clean
    start = simulation.exact_positions
    net_alone = (np.arange(len(start)) < 64)[:, None]
    for shift, expected in ((-0.12, (False, True, ())), (-0.16, (False, False, ("ball",)))):
        simulation.positions = start + np.where(net_alone, [0, 0, shift], 0)
        seen = oracle.look(simulation)
        assert (seen.intersects, seen.crosses, seen.inside) == expected
    leaning = start.copy()
    leaning[:64, 2] += np.linspace(-0.12, -0.07, 64)
    simulation.positions = leaning
    assert oracle.look(simulation).intersects
