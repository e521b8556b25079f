"""Nothing passes through anything: frames and the ways between them, judged by the IPC Toolkit.

Spheres and capsules are no meshes: NumPy measures how far whole triangles are from them.
"""

from typing import Any

import ipctk
import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation
from taut.scene import find_scene

Points = NDArray[np.float64]


def world(simulation: Simulation) -> tuple[Points, NDArray[np.int32]]:
    """Places and triangles of all cloths and of the bodies that have triangles."""
    places: list[Points] = [simulation.positions.astype(np.float64)]
    faces = [triangles(simulation)]
    for body in simulation.bodies.values():
        if len(body.triangles):
            faces.append(body.triangles + sum(map(len, places)))
            places.append(np.asarray(body.positions, dtype=np.float64))
    return np.concatenate(places), np.concatenate(faces).astype(np.int32)


def triangles(simulation: Simulation) -> NDArray[np.int32]:
    return np.asarray(simulation.faces, dtype=np.int32)


def distance_from_point(corners: Points, point: Points) -> float:
    """The least distance of triangles, shape (n, 3, 3), from a point."""
    return float(
        np.sqrt(
            min(ipctk.point_triangle_distance(point, *corner) for corner in corners[_near(corners, point)])
        )
    )


def _near(corners: Points, point: Points) -> NDArray[np.intp]:
    """The triangles among which the nearest one must be."""
    middles = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middles[:, None], axis=2).max()
    away = np.linalg.norm(middles - point, axis=1)
    return np.flatnonzero(away <= away.min() + 2 * reach)


class Oracle:
    """Looks at a simulation again and again."""

    def __init__(self, simulation: Simulation) -> None:
        places, faces = world(simulation)
        self._mesh = ipctk.CollisionMesh(places, ipctk.edges(faces), faces)
        self._before = places

    def look(self, simulation: Simulation) -> None:
        """Refuse intersections now, and crossings on the straight way since the last look."""
        places, _ = world(simulation)
        assert not ipctk.has_intersections(self._mesh, places)
        assert ipctk.is_step_collision_free(self._mesh, self._before, places)
        self._before = places
        corners = simulation.positions.astype(np.float64)[triangles(simulation)]
        for body in simulation.bodies.values():
            if body.shape == "sphere":
                assert distance_from_point(corners, body.positions[0]) > body.radius
            if body.shape == "plane":
                point, tip = body.positions
                assert ((simulation.positions - point) @ (tip - point) > 0).all()


def watched(scene: dict[str, Any] | Scene, steps: int) -> Simulation:
    """A simulation in which every step has been looked at."""
    simulation = Simulation(scene if isinstance(scene, Scene) else Scene(scene))
    oracle = Oracle(simulation)
    for _ in range(steps):
        report = simulation.step()
        assert report.worst_stretch <= 0.05 * (1 + 1e-5)
        oracle.look(simulation)
    return simulation


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ball", "table-cloth", "stack"])
def test_every_step_of_a_shipped_scene_is_free_of_crossings(name: str) -> None:
    watched(Scene.load(find_scene(name)), 90)


CLOTH: dict[str, Any] = {
    "grid": {"size": [0.5, 0.5], "cells": [14, 14], "axes": ["x", "z"], "origin": [-0.25, 0, 0.05]},
    "strain_limit": 0.05,
    "thickness": 0.004,
}
FLOOR = {"name": "floor", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}


def test_cloth_that_falls_on_its_edge_heaps_without_crossings() -> None:
    wavy = {**CLOTH, "rotate": [4.0, 3.0, 0.0]}
    wavy["translate"] = [0.0, 0.0, 0.03]
    simulation = watched({"cloth": [wavy], "body": [FLOOR]}, 70)
    assert simulation.positions[:, 2].max() < 0.3


def test_a_thrown_box_sweeps_two_cloths_along() -> None:
    pins = [{"box": [[-1, -1, 0.549], [1, 1, 0.6]]}]
    behind = {**CLOTH, "grid": {**CLOTH["grid"], "origin": [-0.25, 0.03, 0.05]}, "pins": pins}
    box = {
        "name": "box",
        "box": {"center": [0.02, -0.3, 0.3], "size": [0.12, 0.12, 0.12], "rotate": [20, 30, 10]},
        "move": [[0.1, [0, 0, 0]], [0.3, [0, 0.45, 0]]],
        "turn": {"axis": [0, 1, 0], "point": [0, 0, 0.3], "angle": [[0.6, 60]]},
    }
    scene = {"cloth": [{**CLOTH, "pins": pins}, behind], "body": [box]}
    simulation = Simulation(Scene(scene))
    oracle = Oracle(simulation)
    for _ in range(40):
        simulation.step()
        places, _ = world(simulation)
        assert not ipctk.has_intersections(oracle._mesh, places)
    assert simulation.positions[:, 1].max() > 0.15


def test_what_is_reported() -> None:
    scene = Scene(
        {
            "cloth": [{**CLOTH, "grid": {**CLOTH["grid"], "axes": ["x", "y"], "origin": [0, 0, 0.01]}}],
            "body": [FLOOR],
        }
    )
    simulation = Simulation(scene)
    first = simulation.step()
    assert (first.contacts, first.contact_cuts) == (0, 0)
    for _ in range(20):
        report = simulation.step()
    assert report.contacts == 225
    assert report.closest == pytest.approx(0.003, rel=0.05)
    lowest = simulation.positions[:, 2].min()
    assert lowest == pytest.approx(0.003, rel=0.05), "half of the thickness and the skin of the floor"
