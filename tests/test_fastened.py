"""What pins hold inside of a body, as a flag in its pole, stays there; all else keeps off that body."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation
from taut.bench.meshes import irregular_sheet
from taut.bench.walker import closed

Fields = dict[str, Any]
Points = NDArray[np.float64]
RADIUS, THICKNESS, SKIN, LIMIT = 0.03, 0.002, 0.001, 0.05
FRAMES = 60
POLES = ("capsule", "box", "mesh", "plane")


def _pole(kind: str, meshes: dict[str, Any]) -> Fields:
    """A body round the z axis whose surface is `RADIUS` away from there, on the side of +x at least."""
    if kind == "capsule":
        return {"name": "pole", "capsule": {"from": [0, 0, 0], "to": [0, 0, 2], "radius": RADIUS}}
    if kind == "box":
        return {"name": "pole", "box": {"center": [0, 0, 1], "size": [2 * RADIUS, 2 * RADIUS, 2]}}
    if kind == "plane":
        return {"name": "pole", "plane": {"point": [RADIUS, 0, 0], "normal": [1, 0, 0]}}
    angle = np.arange(32) / 32 * 2 * np.pi
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * RADIUS / np.cos(np.pi / 32)
    heights = np.linspace(0, 2, 12)
    rings = np.array([np.column_stack([ring, np.full(32, height)]) for height in heights])
    meshes["pole"] = closed(rings)
    return {"name": "pole", "mesh": "pole"}


def _flag(kind: str, across: int, mesh: bool) -> tuple[Simulation, Points]:
    """A flag of 0.6 x 0.4 m, pinned along the middle of a pole; how far vertices are from there at rest."""
    meshes: dict[str, Any] = {}
    cells = [across, round(across * 2 / 3)]
    cloth: Fields = {"name": "flag", "thickness": THICKNESS, "strain_limit": LIMIT, "bending": "fabric"}
    if mesh:
        vertices, faces = irregular_sheet((cells[0], cells[1]), (0.6, 0.4), 5)
        places = vertices[:, [0, 2, 1]] + [0, 0, 1.2]
        meshes["flag"] = (places, faces)
        cloth |= {"mesh": "flag", "pins": [{"vertices": np.flatnonzero(places[:, 0] < 1e-9).tolist()}]}
    else:
        grid = {"size": [0.6, 0.4], "cells": cells, "origin": [0, 0, 1.2], "axes": ["x", "z"]}
        cloth |= {"grid": grid, "pins": [{"edge": "left"}]}
    body = _pole(kind, meshes) | {"thickness": SKIN}
    document = {"fps": 60, "body": [body], "cloth": [cloth], "wind": {"velocity": [8, 1, 0]}}
    simulation = Simulation(Scene(document, meshes), 1)
    return simulation, simulation.positions[:, 0].astype(float)


def _depth(kind: str, places: Points) -> Points:
    """How deep places are inside of the pole [m]."""
    x, y = places[:, 0], places[:, 1]
    if kind == "plane":
        return RADIUS - x
    if kind == "box":
        return RADIUS - np.maximum(np.abs(x), np.abs(y))
    return RADIUS - np.hypot(x, y)


@pytest.mark.parametrize("mesh", [False, True])
@pytest.mark.parametrize("across", [16, 40])
@pytest.mark.parametrize("kind", POLES)
def test_a_flag_flies_from_the_middle_of_its_pole(kind: str, across: int, mesh: bool) -> None:
    simulation, rest = _flag(kind, across, mesh)
    start = simulation.positions.astype(float)
    # What can easily be outside with its thickness.
    free = rest > 1.1 * (RADIUS + THICKNESS / 2 + SKIN)
    moved, halved = 0.0, 0
    for _ in range(FRAMES):
        before = simulation.positions.astype(float)
        report = simulation.run(1)
        assert report.penetrations == 0
        assert report.contact_cuts == 0
        halved += report.halved_steps
        assert report.worst_stretch_in_steps <= LIMIT + 1e-5
        now = simulation.positions.astype(float)
        assert _depth(kind, now[free]).max() < 0
        moved = float(np.linalg.norm(now - before, axis=1).max())
    assert moved > 1e-3 and halved <= 3
    assert np.abs(simulation.positions - start)[rest == 0].max() < 1e-6


def test_what_comes_out_of_a_body_is_kept_out_of_it() -> None:
    simulation, rest = _flag("capsule", 24, False)
    pins = np.flatnonzero(rest == 0)
    away = simulation.positions[pins].astype(float) + [0.25, 0, 0]
    simulation.hold(pins.tolist(), away, over=1.0)
    simulation.run(90)
    simulation.wind = {"velocity": [-8.0, 1.0, 0.0]}
    for _ in range(60):
        assert simulation.run(1).penetrations == 0
        assert _depth("capsule", simulation.positions.astype(float)).max() < 0


def test_the_warning_tells_that_it_stays() -> None:
    simulation, _ = _flag("capsule", 16, False)
    assert any("but for what pins hold there" in warning for warning in simulation.warnings)
