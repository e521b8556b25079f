"""Scenes that nobody would write: refused by name and in short, or simulated as any other."""

import json
import math
import random
from typing import Any

import numpy as np
import pytest
from taut import Scene, SceneError, Simulation, SimulationError

from tests.attack.scenes import INTEGRATORS, every_mutant, judge, mutant, mutants


def test_a_sample_of_mutants_is_refused_by_name_or_runs_within_its_limits() -> None:
    complaints = [complaint for scene in mutants(seed=1, count=3000) if (complaint := judge(scene).failure)]
    assert not complaints, "\n".join(complaints[:10])


@pytest.mark.slow
def test_every_field_bears_every_value() -> None:
    complaints = [complaint for scene in every_mutant() if (complaint := judge(scene).failure)]
    assert not complaints, "\n".join(complaints[:10])


def test_the_same_seed_gives_the_same_mutants() -> None:
    one, other = ([str(scene) for scene in mutants(7, 50)] for _ in range(2))
    assert one == other and len(set(one)) > 40


def test_a_resolved_scene_reads_the_same_again() -> None:
    dice = random.Random(3)
    for number in (
        3.0999999999999997e-46,
        *(dice.random() * 10.0 ** dice.randint(-300, 1) for _ in range(300)),
    ):
        resolved = Scene(mutant("grid", {("wind", "gust", "strength"): number}).document).to_json()
        assert Scene(json.loads(resolved)).to_json() == resolved


DENSITY, PERIOD, FPS = ("cloth", 0, "density"), ("wind", "gust", "period"), ("fps",)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {("cloth", 0, "stiffness"): 10**400},
            "scene.cloth[0].stiffness: is a whole number of more than 308",
        ),
        (
            {("cloth", 0, "stiffness"): 10**5000},
            "scene.cloth[0].stiffness: is a whole number of more than 308",
        ),
        ({("title",): "a\ud800"}, r"scene.title = 'a\ud800': character 1 is half of a surrogate pair"),
        ({("cloth", 0, "\ud800"): 1}, r"scene.cloth[0]: a field name = '\ud800': character 0 is half"),
        ({("cloth", 0, "x" * 100_000): 1}, f"scene.cloth[0].{'x' * 60}...: no such field; allowed: "),
        ({("cloth", 0, "x" * 100_000): math.nan}, f"scene.cloth[0].{'x' * 60}... = nan: must be a finite"),
        ({("cloth", 0, ""): 1}, 'scene.cloth[0]."": no such field; allowed: '),
        ({FPS: 1e-20}, "scene.fps = 1e-20: must be in [0.001, 100000]; try 60"),
        ({PERIOD: 1e-14}, "scene.wind.gust.period = 1e-14: must be in [0.001, 1000000]; try 2"),
        ({DENSITY: 1e-45}, "scene.cloth[0].density = 1e-45: must be in [1e-9, 10000]; try 0.2"),
        ({("cloth", 0, "grid", "size"): [1e-30, 1e-30]}, "scene.cloth[0].grid.size[0] = 1e-30: must be in "),
        ({("cloth", 0, "grid", "size", 0): 1.4e-45}, "scene.cloth[0].grid.size[0] = 1"),
        ({("cloth", 0, "name"): "n" * 101}, "scene.cloth[0].name = "),
    ],
)
def test_messages_name_the_field_and_are_short(changes: dict[Any, Any], words: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene(mutant("grid", changes).document)
    assert words in str(caught.value) and len(str(caught.value)) < 600


def test_names_of_files_that_no_system_takes_are_refused() -> None:
    for name in ("x" * 300, "x" * 100_000, "d/" * 3000):
        with pytest.raises(SceneError, match=r"cloth\[0\]\.mesh = 'x|cloth\[0\]\.mesh = 'd/") as caught:
            Simulation(Scene({"cloth": [{"mesh": name}]}))
        assert len(str(caught.value)) < 1000


def test_hardly_any_wind_with_gusts_blows() -> None:
    for speed in (1e-15, 1e-40, 1e-7):
        document = mutant("grid", {("wind", "keyframes"): [], ("wind", "elements"): []}).document
        document["wind"] |= {"velocity": [speed, 0, 0], "gust": {}}
        simulation = Simulation(Scene(document), threads=1)
        simulation.step(3)
        assert np.isfinite(simulation.positions).all()


def test_after_a_blow_up_a_restored_state_goes_on_as_if_nothing_had_happened() -> None:
    document = {"cloth": [{"grid": {"size": [1.0, 1.0], "cells": [16, 16]}, "pins": [{"edge": "top"}]}]}
    simulation, undisturbed = (Simulation(Scene(document), threads=1) for _ in range(2))
    snapshot = simulation.snapshot()
    simulation.velocities = np.full_like(simulation.velocities, 1e30)
    with pytest.raises(SimulationError):
        simulation.step()
    simulation.restore(snapshot)
    simulation.step()
    undisturbed.step()
    assert simulation.state_hash == undisturbed.state_hash
    assert simulation.snapshot() == undisturbed.snapshot()


def test_steps_of_no_length_are_refused_and_tiny_ones_taken() -> None:
    for integrator in INTEGRATORS:
        document = mutant("grid", {}, {"integrator": integrator}).document
        simulation = Simulation(Scene(document), threads=1)
        for dt in (1e-300, 1e-45, 1e-20):
            with pytest.raises(ValueError, match=r"dt = .* must be 1e-12 s or more"):
                simulation.step(2, dt=dt)
        simulation.step(2, dt=1e-12)
        assert np.isfinite(simulation.positions).all() and np.isfinite(simulation.velocities).all()


def motion(place: float) -> float:
    """How far a chain of 20 x 1 cm at x = `place` [m] comes within a second [m]."""
    points = [[place + 0.01 * bead, 0.0, 0.0] for bead in range(21)]
    links = [[bead, bead + 1] for bead in range(20)]
    cloth = {"network": {"points": points, "links": links, "mass": 1e-3}, "strain_limit": 0.01}
    simulation = Simulation(Scene({"cloth": [cloth | {"pins": [{"vertices": [0]}]}]}), threads=1)
    start, furthest = simulation.exact_positions, 0.0
    for _ in range(60):
        simulation.run(1)
        furthest = max(furthest, float(np.linalg.norm(simulation.exact_positions - start, axis=1).max()))
    return furthest


@pytest.mark.parametrize("far", [130.0, 99_000.0])
def test_a_chain_far_away_moves_as_at_the_origin(far: float) -> None:
    assert motion(0.0) > 0.2 and motion(far) == pytest.approx(motion(0.0), rel=0.01)
