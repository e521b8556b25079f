"""Cloth that bodies press on each other: the skin of a body gives way where it must, and only there."""

import numpy as np
from taut import Scene, Simulation

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
    assert behind[from_middle > 0.2].max() == 0.0
    assert not simulation.intersections()
    before = simulation.positions.copy()
    simulation.run(frames=1)
    assert np.abs(simulation.positions - before).max() < 1e-3  # nothing is thrown
    simulation.run(frames=45)
    assert simulation.report.held_back_bodies == 0 and simulation.report.pinched == 0
    np.testing.assert_allclose(simulation.bodies["plate"].positions, path[97], atol=1e-12)
