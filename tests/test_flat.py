"""Cloth that is flat, with gravity in its plane, buckles as real cloth does, and is left alone otherwise."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, SceneError, Simulation
from taut.bench.meshes import irregular_sheet

Fields = dict[str, Any]
FLOOR: Fields = {"name": "floor", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
CLOTH: Fields = {"name": "cloth", "bending": "fabric", "density": 0.2, "thickness": 0.003}
LEANS = 1e-5


def _upright(size: tuple[float, float] = (1.0, 0.8), turn: float = 0.0, **more: Any) -> Fields:
    """A grid whose plane is the x-z plane, or one turned about the z axis [degrees]."""
    grid = {"size": list(size), "cells": [round(30 * side) for side in size], "axes": ["x", "z"]}
    return CLOTH | {"grid": grid, "rotate": [0, 0, turn]} | more


def _curtain(turn: float = 0.0, **more: Any) -> Fields:
    """A curtain whose rings are drawn together."""
    way = np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn)), 0.0])
    rings = [
        {"nearest": [*(0.2 * ring * way)[:2], 0.8], "move": [[0.2, [0, 0, 0]], [2, list(-0.1 * ring * way)]]}
        for ring in range(6)
    ]
    return _upright(turn=turn, pins=rings, **more)


def _run(
    document: Fields, frames: int, across: NDArray[np.float64], meshes: Any = None
) -> tuple[Simulation, float]:
    """Runs a scene; how far from where it began cloth is in the end, across its plane, at most [m]."""
    simulation = Simulation(Scene(document, meshes or {}), 1)
    start = simulation.positions @ across
    for _ in range(frames):
        assert simulation.run(1).penetrations == 0
    return simulation, float(np.abs(simulation.positions @ across - start).max())


@pytest.mark.parametrize("turn", [0.0, 30.0, 90.0])
def test_a_curtain_that_is_drawn_falls_in_pleats(turn: float) -> None:
    across = np.array([-np.sin(np.radians(turn)), np.cos(np.radians(turn)), 0.0])
    _, breadth = _run({"cloth": [_curtain(turn)]}, 120, across)
    assert 0.02 < breadth < 0.2


def test_a_flag_in_still_air_hangs_in_folds() -> None:
    """Whether it touches itself or not."""
    pins = [{"edge": "left"}]
    for contact in (True, False):
        document = {"cloth": [_upright(pins=pins)], "contact": {"self": contact}}
        _, breadth = _run(document, 90, np.array([0.0, 1, 0]))
        assert 0.02 < breadth < 0.5


def test_a_mesh_that_falls_on_its_edge_falls_over() -> None:
    vertices, faces = irregular_sheet((16, 16), (0.5, 0.5), 3)
    mesh = (vertices[:, [0, 2, 1]] + [0, 0, 0.4], faces)
    document = {"cloth": [CLOTH | {"mesh": "sheet"}], "body": [FLOOR]}
    simulation, breadth = _run(document, 90, np.array([0.0, 1, 0]), {"sheet": mesh})
    assert breadth > 0.05
    assert simulation.positions[:, 2].max() < 0.1


@pytest.mark.parametrize("links", [8, 30])
def test_an_upright_rope_falls_to_any_side(links: int) -> None:
    points = [[0, 0, 0.02 + 0.6 * link / links] for link in range(links + 1)]
    network = {"points": points, "links": [[link, link + 1] for link in range(links)], "mass": 0.002}
    rope = {"name": "rope", "network": network, "thickness": 0.005, "stiffness": 300.0, "strain_limit": 0.02}
    simulation, breadth = _run({"cloth": [rope], "body": [FLOOR]}, 90, np.array([0.0, 1, 0]))
    assert breadth > 0.02
    assert np.ptp(simulation.positions[:, 0]) > 0.02


def test_without_imperfection_it_stays_in_its_plane() -> None:
    _, breadth = _run({"cloth": [_curtain(imperfection=0.0)]}, 60, np.array([0.0, 1, 0]))
    assert breadth == 0.0


def test_what_hangs_taut_hangs_where_it_did() -> None:
    """In the end it is off its plane by what gravity leans, at most, and still."""
    document = {"cloth": [_upright(pins=[{"edge": "top"}], air_drag=2.0)]}
    simulation, breadth = _run(document, 120, np.array([0.0, 1, 0]))
    assert 0.0 < breadth < LEANS * 0.8
    assert np.abs(simulation.velocities[:, 1]).max() < LEANS


def test_lying_cloth_and_cloth_that_is_not_flat_keep_their_bits() -> None:
    lying = CLOTH | {
        "grid": {"size": [0.5, 0.5], "cells": [12, 12], "axes": ["x", "y"]},
        "pins": [{"edge": "left"}],
    }
    vertices, faces = irregular_sheet((12, 12), (0.5, 0.5), 3)
    bent = CLOTH | {"mesh": "bent", "pins": [{"nearest": [0, 0, 0.2]}]}
    meshes = {"bent": (np.column_stack([vertices[:, 0], 0.1 * vertices[:, 0] ** 2, vertices[:, 1]]), faces)}
    for cloth in (lying, bent):
        hashes = set()
        for imperfection in (0.0, 1e-5, 1e-2):
            scene = Scene({"cloth": [cloth | {"imperfection": imperfection}]}, meshes)
            simulation = Simulation(scene, 1)
            simulation.run(20)
            hashes.add(simulation.positions.tobytes())
        assert len(hashes) == 1


@pytest.mark.parametrize("value", [-1e-6, 0.02, float("nan")])
def test_an_imperfection_has_bounds(value: float) -> None:
    with pytest.raises(SceneError, match=r"cloth\[0\]\.imperfection"):
        Scene({"cloth": [_upright(imperfection=value)]})
