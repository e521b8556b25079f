"""Bodies as a simulation gives them, as caches keep them, and what reports say about contact."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Cache, CacheError, Scene, Simulation, record
from taut.cache import layout, metadata, summarize

NAMES = ["ball", "rod", "crate", "floor"]
UP = 0.3


def scene(**changes: Any) -> Scene:
    """A sheet that falls on a ball, beside a rod that rises, a crate and a floor."""
    grid = {"size": [0.6, 0.6], "cells": [8, 8], "axes": ["x", "y"], "origin": [-0.3, -0.3, 0.42]}
    bodies = [
        {"name": "ball", "sphere": {"center": [0, 0, 0.2], "radius": 0.2}},
        {
            "name": "rod",
            "capsule": {"from": [2, -1, 0.1], "to": [2, 1, 0.1], "radius": 0.1},
            "move": [[1.0, [0, 0, UP]]],
        },
        {"name": "crate", "box": {"center": [-2, 0, 0.5], "size": [1, 2, 1]}},
        {"name": "floor", "plane": {"normal": [0, 0, 2]}},
    ]
    cloth = {"name": "sheet", "grid": grid, "thickness": 0.004}
    return Scene({"title": "Ball", "duration": 0.5, "fps": 30, "cloth": [cloth], "body": bodies} | changes)


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache of that scene; not to be changed."""
    return record(Simulation(scene(), threads=1), tmp_path_factory.mktemp("ball") / "ball.zarr").path


def test_a_simulation_says_where_its_bodies_are() -> None:
    simulation = Simulation(scene(), threads=1)
    bodies = simulation.bodies
    assert list(bodies) == NAMES
    assert [body.shape for body in bodies.values()] == ["sphere", "capsule", "surface", "plane"]
    assert [body.radius for body in bodies.values()] == [0.2, 0.1, 0.0, 0.0]
    assert [body.moves for body in bodies.values()] == [False, True, False, False]
    np.testing.assert_allclose(bodies["ball"].positions, [[0, 0, 0.2]])
    np.testing.assert_allclose(bodies["floor"].positions, [[0, 0, 0], [0, 0, 1]])
    crate = bodies["crate"]
    assert (crate.positions.dtype, crate.triangles.shape, len(crate.positions)) == (np.float64, (12, 3), 8)
    corners = crate.positions[crate.triangles]
    volume = np.linalg.det(corners - crate.positions.mean(axis=0)).sum() / 6
    assert volume == pytest.approx(2.0), "triangles are counter-clockwise seen from outside"
    simulation.run(15)
    np.testing.assert_allclose(simulation.bodies["rod"].positions[:, 2], 0.1 + 0.5 * UP, atol=1e-9)
    np.testing.assert_allclose(bodies["rod"].positions[:, 2], 0.1)
    with pytest.raises(TypeError):
        simulation.bodies["new"] = crate  # type: ignore[index]
    with pytest.raises(AttributeError):
        crate.radius = 1.0  # type: ignore[misc]


def test_without_bodies_there_are_none(recorded: Path, flag: dict[str, Any]) -> None:
    simulation, cache = Simulation(Scene(flag)), Cache.open(recorded)
    simulation.step()
    report = simulation.report
    assert not simulation.bodies and not cache.bodies(0) and not (recorded / "bodies").exists()
    assert "bodies" not in cache.attributes
    assert (report.contacts, report.contact_cuts, report.closest) == (0, 0, np.inf)
    with pytest.raises(IndexError):
        cache.bodies(30)


def test_reports_and_summaries_count_contact(ball: Path, taut: Callable[..., Any]) -> None:
    simulation = Simulation(scene(), threads=1)
    assert simulation.report.closest == np.inf
    seen = []
    simulation.run(14, on_frame=lambda now: seen.append(now.report))
    numbers, summary = Cache.open(ball).diagnostics, summarize(Cache.open(ball))
    for name in ("contacts", "contact_cuts", "closest"):
        np.testing.assert_array_equal(numbers[name][1:], [getattr(report, name) for report in seen])
    assert summary.contacts == sum(report.contacts for report in seen) > 0
    assert summary.closest == min(report.closest for report in seen) < np.inf
    told = json.loads(taut("info", ball, "--json").out)
    assert (told["contacts"], told["closest"]) == (summary.contacts, summary.closest)
    assert "pairs a step" in taut("info", ball).out


def test_reports_caches_and_info_tell_what_phases_took(ball: Path, taut: Callable[..., Any]) -> None:
    """Wall-clock times: each run has its own, and nothing else depends on them."""
    phases = ("detection_ms", "solve_ms", "certificate_ms")
    cache = Cache.open(ball)
    numbers, summary = cache.diagnostics, summarize(cache)
    took = np.array([numbers[name] for name in phases])
    assert (took[:, 0] == 0).all() and (took[:, 1:] > 0).all()
    assert (took.sum(axis=0)[1:] < numbers["ms"][1:]).all()
    told, table = json.loads(taut("info", ball, "--json").out), taut("info", ball).out
    for name in phases:
        assert told[name] == getattr(summary, name) == pytest.approx(numbers[name].sum())
    assert re.search(r"time of phases +detection [\d.]+, solve [\d.]+, certificate [\d.]+ ms a frame", table)

    first, second = Simulation(scene(), threads=1), Simulation(scene(), threads=1)
    one, other = first.step(8), second.step(8)
    assert one == other and all(getattr(one, name) > 0 for name in phases)
    assert any(getattr(one, name) != getattr(other, name) for name in phases)
    assert first.state_hash == second.state_hash
    assert first.snapshot() == second.snapshot()
    second.restore(first.snapshot())
    assert [getattr(second.report, name) for name in phases] == [0, 0, 0]


def test_without_contact_there_is_only_time_to_solve(recorded: Path, taut: Callable[..., Any]) -> None:
    told = json.loads(taut("info", recorded, "--json").out)
    assert told["solve_ms"] > 0 == told["detection_ms"] == told["certificate_ms"]
    assert re.search(r"time of phases +solve [\d.]+ ms a frame", taut("info", recorded).out)


def test_info_says_nothing_of_contact_where_there_is_none(recorded: Path, taut: Callable[..., Any]) -> None:
    told = json.loads(taut("info", recorded, "--json").out)
    assert (told["contacts"], told["contact_cuts"], told["closest"]) == (0, 0, None)
    assert "contact" not in taut("info", recorded).out


def test_a_cache_gives_the_bodies_of_each_frame(ball: Path) -> None:
    cache, simulation = Cache.open(ball), Simulation(scene(), threads=1)
    for frame in range(cache.frames):
        for own, other in zip(cache.bodies(frame).values(), simulation.bodies.values(), strict=True):
            facts = [(body.name, body.shape, body.radius, body.moves) for body in (own, other)]
            assert facts[0] == facts[1] and own.positions.dtype == np.float32
            np.testing.assert_array_equal(own.positions, other.positions.astype(np.float32))
            np.testing.assert_array_equal(own.triangles, other.triangles)
        simulation.run(1)
    np.testing.assert_array_equal(cache.bodies(-1)["rod"].positions, cache.bodies(14)["rod"].positions)
    # Only what moves is written with every frame.
    assert len(list((ball / "bodies/positions").glob("c.*"))) == cache.frames
    assert len(list((ball / "bodies/rest").glob("c.*"))) == 1


def test_bodies_that_stay_are_written_once(tmp_path: Path) -> None:
    still = scene(body=[{"name": "../ball", "sphere": {"center": [0, 0, 0.2], "radius": 0.2}}])
    path = record(Simulation(still, threads=1), tmp_path / "still.zarr", frames=3).path
    assert not (path / "bodies/positions").exists()
    np.testing.assert_array_equal(Cache.open(path).bodies(2)["../ball"].positions, np.float32([[0, 0, 0.2]]))


def test_a_run_goes_on_beside_its_bodies(ball: Path, tmp_path: Path) -> None:
    path = tmp_path / "half.zarr"
    record(Simulation(scene(), threads=1), path, frames=6)
    record(Simulation(scene(), threads=1), path, existing="resume")
    half, whole = Cache.open(path), Cache.open(ball)
    assert half.attributes["state_hash"] == whole.attributes["state_hash"]
    for frame in range(whole.frames):
        np.testing.assert_array_equal(
            half.bodies(frame)["rod"].positions, whole.bodies(frame)["rod"].positions
        )


def test_a_frame_whose_bodies_are_damaged_is_simulated_again(ball: Path, tmp_path: Path) -> None:
    path = Path(shutil.copytree(ball, tmp_path / "ball.zarr"))
    (path / "bodies/positions/c.12.0.0").unlink()
    damaged = Cache.open(path)
    with pytest.raises(CacheError, match=r"bodies/positions/c.12.0.0, frame 12, is missing"):
        damaged.bodies(12)
    assert [damaged.is_whole(frame) for frame in (11, 12, 13)] == [True, False, True]
    (path / "bodies/positions/c.14.0.0").unlink()
    assert record(Simulation(scene(), threads=1), path, existing="resume").resumed_at == 14
    assert Cache.open(path).attributes["state_hash"] == Cache.open(ball).attributes["state_hash"]


def without_contact(path: Path, folder: Path) -> Path:
    """A cache as it was before there were bodies in it."""
    old = Path(shutil.copytree(path, folder / "old.zarr"))
    document = json.loads((old / "zarr.json").read_bytes())
    nodes = document["consolidated_metadata"]["metadata"]
    gone = ["bodies", *(f"bodies/{name}" for name in ("rest", "faces", "positions"))]
    gone += [f"diagnostics/{name}" for name in layout.ADDED]
    for name in gone:
        nodes.pop(name, None)
        shutil.rmtree(old / name, ignore_errors=True)
    document["attributes"].pop("bodies", None)
    names = nodes["checksums"]["attributes"]["arrays"]
    nodes["checksums"]["attributes"]["arrays"] = [f"old {name}" if name in gone else name for name in names]
    (old / "zarr.json").write_bytes(metadata.encoded(document))
    return old


def test_caches_from_before_bodies_are_read(ball: Path, tmp_path: Path) -> None:
    cache = Cache.open(without_contact(ball, tmp_path))
    assert not cache.bodies(3) and all(cache.is_whole(frame) for frame in range(cache.frames))
    numbers = cache.diagnostics
    assert not numbers["contacts"].any() and not numbers["contact_cuts"].any()
    assert np.isposinf(numbers["closest"]).all()
    assert summarize(cache).contacts == 0
    assert (summarize(cache).solve_ms, numbers["solve_ms"].any()) == (0, False)


def test_a_run_goes_on_in_a_cache_from_before_contact(
    flag: dict[str, Any], recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "old.zarr"
    with monkeypatch.context() as before:
        for name in ("DIAGNOSTICS", "SERIES"):
            kept = getattr(layout, name).items()
            added = layout.ADDED
            before.setattr(layout, name, {k: kind for k, kind in kept if k.split("/")[-1] not in added})
        before.setattr(layout, "GROWING", (*layout.SERIES, "velocities", "positions"))
        record(Simulation(Scene(flag)), path, frames=10)
    assert not (path / "diagnostics/contacts").exists()
    assert record(Simulation(Scene(flag)), path, existing="resume").resumed_at == 10
    cache = Cache.open(path)
    assert cache.attributes["state_hash"] == Cache.open(recorded).attributes["state_hash"]
    assert all(cache.is_whole(frame) for frame in range(cache.frames))
    assert len(cache.diagnostics["contacts"]) == 30


@pytest.mark.parametrize(
    "change",
    [
        {"shape": "cone"},
        {"radius": -1.0},
        {"first_vertex": -1},
        {"vertices": 99},
        {"triangles": 99},
        {"moves": 1},
        {"moves": True},
        {"other": 0},
    ],
)
def test_bodies_that_cannot_be_are_refused(ball: Path, tmp_path: Path, change: dict[str, Any]) -> None:
    path = Path(shutil.copytree(ball, tmp_path / "ball.zarr"))
    document = json.loads((path / "zarr.json").read_bytes())
    document["attributes"]["bodies"][0].update(change)
    (path / "zarr.json").write_bytes(metadata.encoded(document))
    with pytest.raises(CacheError, match="its bodies are damaged"):
        Cache.open(path).bodies(0)
