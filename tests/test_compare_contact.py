"""`taut compare --contact`: the engine with a method, and the folder end to end."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation
from taut.compare import Conditions
from taut.compare.contact import FORMAT, built_in, choose, compare_contact
from taut.compare.contact.bridson import bridson
from taut.compare.contact.filtered import Filtered
from taut.compare.contact.penalty import penalty
from taut.compare.contact.provot import provot
from taut.errors import CompareError

Command = Callable[..., Any]
METHODS = {"bridson": bridson, "provot": provot, "penalty": penalty}
TINY = ["--set", "cloth[0].grid.cells=[5,5]", "--frames", 4, "--no-film", "--threads", 1]


# The engine with a method.


def test_without_touching_a_method_changes_no_bit() -> None:
    free = Scene(
        {
            "gravity": [0, 0, -9.81],
            "cloth": [{"grid": {"size": [0.4, 0.4], "cells": [4, 4]}}],
            "solver": {"filter": "sweeps"},
        }
    )
    plain = Simulation(free, 1)
    touching = free.with_settings(["cloth[0].thickness=0.01", "contact.self=true", "solver={}"])
    simulations = [Filtered(touching, method, 1) for method in METHODS.values()]
    plain.run(10)
    for simulation in simulations:
        simulation.run(10)
        assert simulation.positions.tobytes() == plain.positions.tobytes()
        np.testing.assert_allclose(simulation.places, plain.exact_positions, atol=1e-6)


def test_bodies_go_their_ways_without_the_cloth() -> None:
    move = "body.ball.move=[[0,[0,0,0]],[0.5,[0.5,0,0]]]"
    scene = built_in(["ball"], ["cloth[0].grid.cells=[5,5]", move])["ball"]
    simulation = Filtered(scene, bridson, 1)
    simulation.run(6)
    assert simulation.bodies["ball"].positions[0] == pytest.approx([0.1, 0, 0.3], abs=1e-9)
    ball = simulation.places[simulation.world.cloth + 4 :]
    assert ball.mean(axis=0) == pytest.approx([0.1, 0, 0.3], abs=1e-9)


# The command.


@pytest.mark.slow
def test_the_folder(taut: Command, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = taut("compare", "--contact", "--out", out, "--methods", "all,none", "--scenes", "heap,heap", *TINY)
    assert done.status == 0, done.err
    found = json.loads((out / "compare.json").read_text())
    assert found["format"] == FORMAT and not found["interrupted"]
    assert [scene["name"] for scene in found["scenes"]] == ["heap"]
    names = ["ours", "bridson", "provot", "penalty", "none"]
    page = (out / "compare.md").read_text()
    for scene in found["scenes"]:
        assert [run["method"] for run in scene["runs"]] == names
        assert scene["vertices"] == 36 and scene["strain_limit"] == 0.05
        for run in scene["runs"]:
            assert run["frames"] == 4 == len(run["moments"]["time"])
            assert run["worst_stretch"] == max(run["moments"]["worst_stretch"])
            assert (run["rounds_per_step"] is None) == (run["method"] == "ours")
            assert (out / run["cache"]).is_dir()
            assert (
                f"| `{run['method']}` | {run['steps_per_frame']} | {run['intersecting_frames']} of 4" in page
            )
            assert f"{scene['name']}, {run['method']}" in done.out
    made = {path.name for path in out.iterdir()}
    pictures = {f"contact-heap{kind}" for kind in (".png", "-strip.jpg")}
    assert made == {"compare.md", "compare.json", "caches"} | pictures
    assert taut("compare", "--contact", "--out", out, *TINY).status == 2
    (out / "thesis.txt").write_text("precious")
    assert "holds 'thesis.txt'" in taut("compare", "--contact", "--out", out, "--overwrite", *TINY).err


@pytest.mark.slow
def test_a_scene_of_ones_own(taut: Command, tmp_path: Path) -> None:
    arguments = ["--out", tmp_path / "out", "--methods", "ours,bridson", *TINY]
    done = taut("compare", "ball", "--contact", *arguments)
    assert done.status == 0, done.err
    (scene,) = json.loads((tmp_path / "out" / "compare.json").read_text())["scenes"]
    assert (scene["name"], scene["title"]) == ("ball", "Sheet on a ball")
    assert scene["no_energy"] == "what moves by itself does work on the cloth"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--contact", "--methods", "bridsen"], "did you mean bridson?"),
        (["--contact", "--methods", ","], "methods is empty: name some of ours"),
        (
            ["--contact", "--scenes", "bal"],
            "scenes = 'bal': must be some of ball, heap, layers, twist, or all",
        ),
        (["--contact", "--filters", "none"], "--filters: not together with --contact"),
        (["one-corner", "--methods", "ours"], "--methods: only with --contact"),
        (["ball", "--contact", "--scenes", "heap"], "--scenes: not together with a scene"),
        ([], "no scene is named"),
        (["one-corner", "--contact"], "nothing touches in this scene"),
        (["net-ball", "--contact"], "points without triangles"),
        (["twist", "--contact", "--set", "cloth[0].grid.cells=[120,60]"], "for at most 5000"),
    ],
)
def test_bad_input_is_one_red_line(taut: Command, tmp_path: Path, arguments: list[str], message: str) -> None:
    done = taut("compare", *arguments, "--out", tmp_path / "out", "--no-film", "--frames", 2)
    assert (done.status, done.out) == (2, "")
    assert message in done.err
    assert done.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_whole(tmp_path: Path) -> None:
    scenes = built_in(["ball"], ["cloth[0].grid.cells=[4,4]"])

    def stop_at(name: str) -> Conditions:
        def watch(what: str, done: int, total: int, note: str) -> None:
            if what == name:
                raise KeyboardInterrupt

        return Conditions(frames=3, threads=1, watch=watch)

    methods = choose(["ours", "bridson"])
    with pytest.raises(KeyboardInterrupt):
        compare_contact(scenes, methods, tmp_path / "nothing", stop_at("ball, ours"))
    assert not list(tmp_path.iterdir())
    assert compare_contact(scenes, methods, tmp_path / "part", stop_at("ball, bridson")).interrupted
    found = json.loads((tmp_path / "part" / "compare.json").read_text())
    assert [run["method"] for run in found["scenes"][0]["runs"]] == ["ours"]
    with pytest.raises(CompareError, match="there is no scene"):
        compare_contact({}, methods, tmp_path / "empty")


@pytest.mark.slow
def test_ours_keeps_what_it_promises_and_none_does_not(tmp_path: Path) -> None:
    scenes = built_in(["ball"], ["cloth[0].grid.cells=[10,10]"])
    found = compare_contact(
        scenes, choose(["ours", "none"]), tmp_path / "out", Conditions(frames=20, threads=1)
    )
    ours, none = (run.figures for run in found.scenes[0].runs)
    assert ours.intersecting_frames == 0 and ours.over_limit == 0 and ours.closest > 0
    assert none.intersecting_frames > 5 and none.closest == 0
