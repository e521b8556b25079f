"""Every integrator on a flag, a drop, a net and an imported mesh; its caches; what is refused."""

from typing import Any

import numpy as np
import pytest
from taut import Cache, Scene, SceneError, Simulation, record

INTEGRATORS = ["euler", "forward_euler", "midpoint", "rk4", "verlet", "implicit_euler", "bdf2"]
PASSES = {"euler": 1, "forward_euler": 1, "midpoint": 2, "rk4": 4, "verlet": 2}
"""How often an explicit method looks at all springs in a step."""


def simulation(scene: str, *settings: str) -> Simulation:
    return Simulation(Scene.load(scene).with_settings(settings))


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("scene", ["flag", "one-corner", "cape", "net"])
def test_the_shipped_scenes_run(scene, integrator):
    run = simulation(scene, f"solver.integrator={integrator}")
    start, limit = run.positions.copy(), run.strain_limit.min()
    for _ in range(3):
        report = run.step(run.substeps)
        assert report.worst_stretch_in_steps < limit + 1e-5
    moved = np.linalg.norm(run.positions - start, axis=1).max()
    assert 0.005 < moved < 0.3  # [m], in 1/20 s
    if integrator in ("implicit_euler", "bdf2"):
        assert report.evaluations > run.substeps  # a pass of the linear solver counts, too
    elif integrator != "euler":  # which follows springs in several parts of a step
        assert report.evaluations == PASSES[integrator] * run.substeps


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_resumed_run_ends_like_an_uninterrupted_one(tmp_path, flag, integrator):
    flag["solver"] = {"integrator": integrator}
    flag["cloth"][0] |= {"stiffness": 5.0, "bending": 1e-5}
    whole = record(Simulation(Scene(flag)), tmp_path / "whole.zarr", 12).path
    for frames in (5, 12):
        record(Simulation(Scene(flag), threads=2), tmp_path / "parts.zarr", frames, existing="resume")
    one, other = Cache.open(whole), Cache.open(tmp_path / "parts.zarr")
    np.testing.assert_array_equal(one.diagnostics["state_hash"], other.diagnostics["state_hash"])
    assert all(other.is_whole(frame) for frame in range(12))
    rows = {"implicit_euler": 0, "bdf2": 3}.get(integrator, 1)  # its own velocities, and what bdf2 remembers
    assert len(other.past(11)) == rows * other.vertices + 1  # how calm its cloth is


def test_a_cache_whose_past_is_damaged_goes_back_to_the_last_whole_frame(tmp_path, flag):
    flag["solver"] = {"integrator": "bdf2"}
    path = record(Simulation(Scene(flag)), tmp_path / "flag.zarr", 8).path
    before = Cache.open(path).attributes["state_hash"]
    (path / "past/c.7.0.0").unlink()
    done = record(Simulation(Scene(flag)), path, 8, existing="resume")
    assert done.notes == [f"{path}: frames 7 to 7 were damaged and are simulated again"]
    assert Cache.open(path).attributes["state_hash"] == before


def test_a_state_that_is_set_without_its_past_starts_anew(flag):
    flag["solver"] = {"integrator": "bdf2"}
    run, again = Simulation(Scene(flag)), Simulation(Scene(flag))
    run.step(20)
    assert run.past.shape == (3 * len(run.positions) + 1, 3)
    snapshot = run.snapshot()
    again.set_state(run.positions, run.velocities, run.steps, run.past)
    assert again.state_hash == run.state_hash
    again.step(5)
    run.step(5)
    assert again.state_hash == run.state_hash
    again.restore(snapshot)
    again.velocities = again.velocities.copy()
    count = len(again.positions)
    own, remembered, calm = again.past[:count], again.past[count:-1], again.past[-1]
    np.testing.assert_array_equal(own, again.velocities)
    assert not remembered.any()
    np.testing.assert_array_equal(calm, [0, 1, 0])
    again.step(5)
    assert again.state_hash != run.state_hash
    np.testing.assert_allclose(again.positions, run.positions, atol=1e-2)  # [m]
    with pytest.raises(ValueError, match=r"past must have shape \(106, 3\)"):
        again.set_state(run.positions, run.velocities, 0, run.past[:3])


def refusal(document: dict[str, Any]) -> str:
    with pytest.raises(SceneError) as error:
        Simulation(Scene(document))
    return str(error.value)


def test_what_is_refused_says_why_and_what_to_do(flag):
    flag["solver"] = {"integrator": "rk5"}
    text = refusal(flag)
    assert "solver.integrator" in text and "rk4" in text and "bdf2" in text
    flag["solver"] = {"integrator": "verlet", "filter": "sequential"}
    assert 'solver.integrator = "verlet": "sequential" is the paper\'s filter' in refusal(flag)
    flag["solver"] = {"integrator": "forward_euler", "substeps": 2}
    text = refusal(flag)
    assert "over the stability bound" in text and 'a factor e in 10 s: "rk4", "verlet" or "euler"' in text
    flag["solver"] = {"integrator": "forward_euler", "filter": "none"}
    flag["cloth"][0] |= {"damping": 0.0, "air_drag": 0.0, "stiffness": 1e4}
    assert '"auto" would need' in refusal(flag) and "lets undamped vibrations grow" in refusal(flag)


def test_integrators_that_let_vibrations_grow_are_warned_of(flag):
    for integrator in INTEGRATORS:
        flag["solver"] = {"integrator": integrator}
        warned = any("grow" in text for text in Simulation(Scene(flag)).warnings)
        assert warned == (integrator in ("forward_euler", "midpoint"))
