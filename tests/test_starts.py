"""What intersects at the start is reported; the IPC Toolkit says whether anything does."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation
from taut.intersections import Intersections
from taut.scene import shipped_scenes
from taut.scene.template import toml

from tools.targets.contact.judge import Oracle

Numbers = NDArray[np.float64]


def sheet(**fields: Any) -> dict[str, Any]:
    """A sheet of 1 m around the origin."""
    grid = {"size": [1, 1], "cells": [14, 14], "axes": ["x", "y"], "origin": [-0.5, -0.5, 0.0]}
    return {"grid": grid, "thickness": 0.004, **fields}


def blob(random: np.random.Generator) -> tuple[Numbers, NDArray[np.int64]]:
    """A closed surface like a crumpled ball."""
    across, up = 12, 7
    turns = np.linspace(0, 2 * np.pi, across, endpoint=False)
    heights = np.linspace(-1, 1, up + 2)[1:-1]
    rings = [
        [(np.cos(t) * np.sqrt(1 - h * h), np.sin(t) * np.sqrt(1 - h * h), h) for t in turns] for h in heights
    ]
    points = np.array([(0.0, 0.0, -1.0), *sum(rings, []), (0.0, 0.0, 1.0)])
    at = lambda ring, turn: 1 + ring * across + turn % across  # noqa: E731
    faces = [(0, at(0, turn + 1), at(0, turn)) for turn in range(across)]
    faces += [(len(points) - 1, at(up - 1, turn), at(up - 1, turn + 1)) for turn in range(across)]
    for ring in range(up - 1):
        for turn in range(across):
            a, b = at(ring, turn), at(ring, turn + 1)
            c, d = at(ring + 1, turn + 1), at(ring + 1, turn)
            faces += [(a, b, c), (a, c, d)]
    return 0.25 * points * random.uniform(0.8, 1.2, (len(points), 1)), np.array(faces)


def test_random_starts_are_judged_as_the_ipc_toolkit_does() -> None:
    judged = []
    for seed in range(30):
        random = np.random.default_rng(seed)
        cloths = [
            sheet(
                rotate=random.uniform(-180, 180, 3).tolist(),
                translate=random.uniform(-0.45, 0.45, 3).tolist(),
            )
            for _ in range(1 + seed % 2)
        ]
        body = {"mesh": "blob", "translate": random.uniform(-0.5, 0.5, 3).tolist()}
        scene = Scene({"cloth": cloths, "body": [body]}, {"blob": blob(random)})
        simulation = Simulation(scene, threads=1)
        found = simulation.intersections()
        crosses = any(place.fault == "crosses" for place in found.places)
        assert crosses == Oracle(simulation).look(simulation).intersects, seed
        assert bool(found) == any(" at the start: " in text for text in simulation.warnings), seed
        judged.append(crosses)
    assert 8 <= sum(judged) <= 22, "some of both"


def test_places_tell_what_is_where() -> None:
    ball = {"name": "ball", "sphere": {"center": [0.2, 0.1, 0.05], "radius": 0.1}}
    floor = {"name": "floor", "plane": {"point": [0, 0, -0.3], "normal": [0, 0, 1]}}
    other = sheet(name="wall", rotate=[90, 0, 0], translate=[0.0, 0.3, 0.0])
    simulation = Simulation(Scene({"cloth": [sheet(name="sheet"), other], "body": [ball, floor]}), threads=1)
    found = simulation.intersections()
    assert found and found.count > len(found.places) > 100
    pairs = {(place.cloth, place.other, place.kind, place.fault) for place in found.places}
    assert pairs == {
        ("sheet", "wall", "cloth", "crosses"),
        ("sheet", "ball", "body", "inside"),
        ("wall", "floor", "body", "inside"),
    }
    for place in found.places:
        assert np.linalg.norm(simulation.positions[place.vertex] - place.position) < 0.1
        first = 0 if place.cloth == "sheet" else 225
        assert first <= place.vertex < first + 225
    depths = {
        name: [place.depth or 0.0 for place in found.places if place.other == name]
        for name in ("floor", "ball")
    }
    assert min(depths["floor"]) > 0 and max(depths["floor"]) == pytest.approx(0.2)
    assert min(depths["ball"]) > 0 and max(depths["ball"]) == pytest.approx(0.05)
    crossings = [place for place in found.places if place.fault == "crosses"]
    assert {place.depth for place in crossings} == {None}
    assert all(abs(place.position[1] - 0.3) < 1e-6 for place in crossings)


def test_a_warning_names_both_things_the_first_place_and_a_remedy() -> None:
    ball = {"name": "ball", "sphere": {"center": [0.0, 0.0, 0.0], "radius": 2.0}}
    (warning,) = Simulation(Scene({"cloth": [sheet(name="sheet")], "body": [ball]}), threads=1).warnings
    for words in (
        "scene.cloth[0] (sheet) is inside of body[0] (ball) at the start: 392 places, the first at [",
        " m near vertex ",
        " m deep; contact brings it apart in the first frames; if that does not end: move one of them away,"
        " or let the body come with `move`",
    ):
        assert words in warning


def test_a_clean_start_says_nothing_and_later_moments_can_be_asked() -> None:
    ball = {"sphere": {"center": [0.0, 0.0, -0.3], "radius": 0.2}}
    simulation = Simulation(Scene({"cloth": [sheet()], "body": [ball]}), threads=1)
    assert simulation.warnings == [] and not simulation.intersections()
    assert simulation.intersections() == Intersections(0, ())
    simulation.run(20)
    assert not simulation.intersections()
    simulation.positions = simulation.positions - np.float32([0.0, 0.0, 0.2])
    assert simulation.intersections().count > 0


@pytest.mark.parametrize("name", [scene.name for scene in shipped_scenes()])
def test_shipped_scenes_start_clean(name: str) -> None:
    simulation = Simulation(Scene.load(name), threads=1)
    assert simulation.warnings == [] and not simulation.intersections()


def test_scenes_without_contact_are_not_looked_at() -> None:
    both = [{**sheet(), "thickness": 0.004}, sheet(rotate=[90, 0, 0])]
    simulation = Simulation(Scene({"cloth": both, "contact": {"self": False}}), threads=1)
    assert simulation.warnings == [] and not simulation.intersections()


@pytest.mark.parametrize("dry", [True, False])
def test_the_command_line_tells_it(taut: Callable[..., Any], tmp_path: Path, dry: bool) -> None:
    path = tmp_path / "bad.toml"
    ball = {"name": "ball", "sphere": {"center": [0.0, 0.0, 0.0], "radius": 0.2}}
    document = {"cloth": [sheet(name="sheet")], "body": [ball]}
    path.write_text("\n".join(f"{name} = {toml(value)}" for name, value in document.items()))
    more = ["--dry-run"] if dry else ["--frames", "2"]
    done = taut("run", str(path), "--out", str(tmp_path / "bad.zarr"), *more)
    assert done.status == 0
    assert "scene.cloth[0] (sheet) is inside of body[0] (ball) at the start" in done.err
