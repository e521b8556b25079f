"""Cloth that bodies press on each other: the skin of a body gives way where it must, and only there."""

import numpy as np
import pytest
from taut import Scene, Simulation
from taut.bench.shirt import shirt
from taut.bench.walker import squeezer

from tools.targets.contact.judge import Oracle
from tools.targets.contact.scenes import SKIN, Stage, ball, keyframes, sheet

SIDE = 13  # vertices of the plate along a side
DOWN = -0.004  # where the plate goes, below the floor [m]


def plate() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A plate that comes down from 5 cm, stays, and goes up again: places, faces, places in every frame."""
    x, y = np.meshgrid(np.linspace(-0.4, 0.4, SIDE), np.linspace(-0.4, 0.4, SIDE), indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.05)])
    number = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    height = np.interp(np.arange(100), [0, 30, 60, 90], [0.05, DOWN, DOWN, 0.05])
    path = np.repeat(places[None], len(height), axis=0)
    path[:, :, 2] = height[:, None]
    return places, faces, path


def test_a_mesh_is_dented_where_cloth_is_and_goes_on_elsewhere() -> None:
    places, faces, path = plate()
    scene = {
        "fps": 60,
        "cloth": [
            {
                "grid": {
                    "size": [0.2, 0.2],
                    "cells": [10, 10],
                    "origin": [-0.1, -0.1, 0.003],
                    "axes": ["x", "y"],
                },
                "thickness": 0.002,
            }
        ],
        "body": [
            {"name": "floor", "plane": {"normal": [0, 0, 1]}, "thickness": 0.001},
            {"name": "plate", "mesh": "plate", "motion": "down", "thickness": 0.001},
        ],
    }
    simulation = Simulation(Scene(scene, {"plate": (places, faces)}, paths={"down": path}), threads=1)
    simulation.run(frames=50)
    report = simulation.run(frames=1)
    behind = np.linalg.norm(simulation.bodies["plate"].positions - path[51], axis=1)
    from_middle = np.abs(places[:, :2]).max(axis=1)
    assert report.held_back_bodies > 0
    assert behind[from_middle < 0.05].min() > -DOWN  # the cloth is above the floor, the plate above the cloth
    assert behind[from_middle > 0.2].max() < 1e-15  # what the parts of a step round
    assert not simulation.intersections()
    before = simulation.positions.copy()
    simulation.run(frames=1)
    assert np.abs(simulation.positions - before).max() < 1e-3  # nothing is thrown
    simulation.run(frames=45)
    assert simulation.report.held_back_bodies == 0 and simulation.report.pinched == 0
    np.testing.assert_allclose(simulation.bodies["plate"].positions, path[97], atol=1e-12)


def test_an_arm_that_shuts_on_a_shirt_gives_way_at_once() -> None:
    places, faces, path = squeezer(1.0, gap=-0.01)
    made = Stage({"fps": 60}, {"figure": (places, faces)}, {"arm": path})
    made.body({"name": "figure", "mesh": "figure", "motion": "arm"})
    simulation = made.cloth("shirt", mesh=shirt(1200), thickness=0.002).simulation()
    oracle, late, halved = Oracle(simulation), 0.0, 0
    for frame in range(1, 61):
        report = simulation.run(frames=1)
        seen = oracle.look(simulation)
        assert not seen.intersects and not seen.crosses
        late = max(late, float(np.abs(simulation.bodies["figure"].positions - path[frame]).max()))
        halved += report.halved_steps
    # There is no room for two layers: the skin waits for them, and goes on where they do not lie.
    assert 1e-3 < late < 0.02
    # Halves of halves in every frame of the pinch would take ten times as long.
    assert halved <= 4
    np.testing.assert_allclose(simulation.bodies["figure"].positions, path[60], atol=1e-12)


def peak_speed(simulation: Simulation, frames: int) -> float:
    """The greatest speed of any vertex in so many frames, of the motion [m/s]; nothing may intersect."""
    oracle, peak = Oracle(simulation), 0.0
    for _ in range(frames * simulation.substeps):
        simulation.step()
        seen = oracle.look(simulation)
        assert not seen.intersects and not seen.inside
        peak = max(peak, float(np.linalg.norm(simulation.velocities, axis=1).max()))
    return peak


@pytest.mark.parametrize("seed", [2, 5, 8, 11, 46, 245])
def test_cloth_that_grippers_jerk_and_turn_is_not_thrown(seed: int) -> None:
    random = np.random.default_rng(seed)
    scene, thickness, across = Stage({"fps": 60}), 0.002, int(random.integers(12, 26))
    gap = random.uniform(0.2, 0.9) * (2 * SKIN + thickness)
    carried = random.uniform(-0.3, 0.3, 3)
    shapes = random.permutation(["sphere", "capsule", "box"])
    for side, shape in zip((-1, 1), shapes, strict=False):
        radius = float(random.uniform(0.02, 0.05))
        x, y = side * (0.015 + radius), float(random.uniform(-0.05, 0.05))
        inward = np.array([side * (gap / 2 - 0.015), 0.0, 0.0])
        path = [np.zeros(3), inward, inward, inward + carried, inward + carried, carried]
        body = {
            "sphere": {"center": [x, y, 0.05], "radius": radius},
            "capsule": {"from": [x, y - 0.05, 0.05], "to": [x, y + 0.05, 0.05], "radius": radius},
            "box": {"center": [x, y, 0.05], "size": [2 * radius, 0.15, 0.1]},
        }[shape]
        turn = {"axis": [1, 0, 0], "point": [0, 0, 0.05], "angle": [[0.3, 0], [0.7, 60]]}
        move = keyframes([0.1, 0.2, 0.3, 0.6, 0.9, 1.0], path)
        scene.body({"name": f"gripper {side}", shape: body, "friction": 0.6, "move": move, "turn": turn})
    hanging = {"thickness": thickness, "friction": 0.6, "strain_limit": 0.01, "rotate": [90.0, 0.0, 90.0]}
    scene.cloth("sheet", **hanging, **sheet(across, 0.3, mesh=bool(seed % 2)))
    simulation = scene.simulation()
    top = np.flatnonzero(simulation.positions[:, 2] > 0.149)
    simulation.hold(top, simulation.exact_positions[top])
    peak = peak_speed(simulation, 16)
    simulation.release(top)
    # Grippers go at two metres per second at most; a free fall reaches 7 in the end.
    assert max(peak, peak_speed(simulation, 54)) < 12.0


@pytest.mark.parametrize("mesh", [False, True])
def test_a_body_waits_at_what_is_pinned(mesh: bool) -> None:
    scene = Stage({"fps": 60})
    scene.body(ball([-0.2, 0.03, 0.1], 0.08, move=[[0, [0, 0, 0]], [1, [0.6, 0, 0]], [2, [0, 0, 0]]]))
    fields = {"thickness": 0.002, "strain_limit": 0.01, "rotate": [90.0, 0.0, 90.0]}
    pins = [{"nearest": [0, -0.15, 0.15]}, {"nearest": [0, 0.03, 0.1]}, {"nearest": [0, 0.15, 0.15]}]
    simulation = scene.cloth("sheet", pins=pins, **fields, **sheet(16, 0.3, mesh)).simulation()
    assert peak_speed(simulation, 60) < 4.0
    # It stops where the pinned vertex is in its way ..
    assert simulation.report.held_back_bodies >= 1
    assert -0.09 < simulation.bodies["ball"].positions[0, 0] < -0.07
    # .. and goes back along its path.
    assert peak_speed(simulation, 60) < 4.0
    assert simulation.bodies["ball"].positions[0, 0] == pytest.approx(-0.2, abs=1e-6)
