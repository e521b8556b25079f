"""Motions of bodies and paths of pins in OBJ files, one for each frame."""

import json
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Cache, Scene, SceneError, Simulation, record
from taut.formats import export
from taut.scene.template import commented

from tests.attack.leaks import leak

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FACES = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
FRAMES = 12


def document(motion: Any, **pins: Any) -> dict[str, Any]:
    """A small cloth far above a body."""
    grid = {"size": [0.4, 0.4], "cells": [4, 4], "axes": ["x", "y"], "origin": [0.0, 0.0, 9.0]}
    body = {"name": "walker", "mesh": "figure.obj", "motion": motion}
    return {"cloth": [{"grid": grid, "pins": [{"edge": "left", **pins}]}], "body": [body]}


def walk(frames: int = FRAMES) -> NDArray[np.float64]:
    """Places in every frame, each a centimetre further along x, with figures that a decimal number keeps."""
    return CORNERS + 0.01 * np.arange(frames)[:, None, None] * np.array([1.0, 0.0, 0.0])


def write_obj(path: Path, places: NDArray[np.float64], faces: str = FACES) -> str:
    path.parent.mkdir(exist_ok=True, parents=True)
    path.write_text("".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in places.tolist()) + faces)
    return path.name


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A figure, and what it does as one file a frame, their numbers without zeros before them."""
    write_obj(tmp_path / "figure.obj", CORNERS)
    for frame, places in enumerate(walk()):
        write_obj(tmp_path / f"walk_{frame}.obj", places)
    return tmp_path


def listed() -> list[str]:
    return [f"walk_{frame}.obj" for frame in range(FRAMES)]


def paths(scene: Scene) -> dict[str, NDArray[np.float64]]:
    return {name: places for name, (places, _) in scene.read_paths().items()}


@pytest.mark.parametrize("motion", [listed(), "walk_*.obj"], ids=["list", "pattern"])
def test_files_move_a_body_as_an_array_does(motion: Any, folder: Path) -> None:
    np.save(folder / "walk.npy", walk())
    ways: list[list[NDArray[np.float64]]] = []
    for files in (motion, "walk.npy"):
        scene = Scene(document(files), folder=folder)
        assert scene.document["body"][0]["motion"] == files
        simulation = Simulation(scene, threads=1)
        ways.append([])
        for _ in range(FRAMES + 2):
            simulation.run(1)
            ways[-1].append(simulation.bodies["walker"].positions.copy())
    np.testing.assert_array_equal(ways[0], ways[1])
    np.testing.assert_allclose(ways[0][FRAMES + 1], walk()[-1], atol=1e-12)
    assert np.ptp([places[0, 0] for places in ways[0]]) == pytest.approx(0.01 * (FRAMES - 1) - 0.01)


def test_a_pattern_counts_and_begins_anywhere(tmp_path: Path) -> None:
    """Numbers, not letters, order the files: 9 before 10, with zeros or without."""
    write_obj(tmp_path / "figure.obj", CORNERS)
    names = ["8", "09", "010", "11"]
    for name, places in zip(names, walk(4), strict=True):
        write_obj(tmp_path / "poses" / f"a+b_{name}.OBJ", places, faces="")
    for other in ("a+b_12.obj", "a+b_last.OBJ", "aab_1.OBJ", "a+b_7.OBJ.bak", "a+b_.OBJ", "a+b_٣.OBJ"):
        (tmp_path / "poses" / other).write_text("nonsense")
    (found,) = paths(Scene(document("poses/a+b_*.OBJ"), folder=tmp_path)).values()
    np.testing.assert_array_equal(found, walk(4))


def test_a_pose_may_be_held(folder: Path) -> None:
    names = [f"walk_{frame}.obj" for frame in (0, 0, 3, 3, 1)]
    (found,) = paths(Scene(document(names), folder=folder)).values()
    np.testing.assert_array_equal(found, walk()[[0, 0, 3, 3, 1]])


def test_pins_follow_files_with_nothing_but_vertices(folder: Path) -> None:
    simulation = Simulation(Scene(document(listed()), folder=folder), threads=1)
    home = simulation.positions[simulation.pinned].astype(np.float64)
    lifted = home + 0.002 * np.arange(5)[:, None, None] * np.array([0.0, 0.0, 1.0])
    names = [write_obj(folder / f"hem_{frame}.obj", places, faces="") for frame, places in enumerate(lifted)]
    for follow in (names, "hem_*.obj"):
        scene = Scene(document("walk_*.obj", follow=follow), folder=folder)
        simulation = Simulation(scene, threads=1)
        simulation.run(4)
        np.testing.assert_allclose(simulation.positions[simulation.pinned], lifted[4], atol=1e-6)


def test_what_taut_exports_moves_bodies(tmp_path: Path) -> None:
    """A cloth that was simulated becomes the body of another scene."""
    cloth = {"grid": {"size": [0.4, 0.4], "cells": [4, 4]}, "pins": [{"edge": "top"}]}
    cache = Cache.open(record(Simulation(Scene({"cloth": [cloth]})), tmp_path / "a.zarr", frames=6).path)
    export(cache, "obj", tmp_path / "frames")
    (pattern,) = {re.sub(r"\d+", "*", path.name) for path in (tmp_path / "frames").glob("*.obj")}
    (tmp_path / "figure.obj").write_bytes(sorted((tmp_path / "frames").glob("*.obj"))[0].read_bytes())
    (found,) = paths(Scene(document(f"frames/{pattern}"), folder=tmp_path)).values()
    np.testing.assert_array_equal(found.astype(np.float32), [cache.positions(frame) for frame in range(6)])


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        (
            "walk_7.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n",
            "'walk_7.obj': has 3 vertices in frame 7, but frame 0, 'walk_0.obj', has 4; all frames must have "
            "the same vertices in the same order: export",
        ),
        (
            "walk_7.obj",
            "v 0 0 0\nv nan 0 0\n",
            r"'walk_7.obj', frame 7: .*walk_7.obj:2: vertex nan 0.0 0.0 is not finite",
        ),
        ("walk_7.obj", "v 0 0 0\nv 1 inf 0\n", r"frame 7: .*walk_7.obj:2: vertex 1.0 inf 0.0 is not finite"),
        ("walk_7.obj", "v 0 0\n", "frame 7: .*walk_7.obj:1: a vertex needs 3 coordinates, this line has 2"),
        ("walk_7.obj", "v 0 0 zero\n", "frame 7: .*walk_7.obj:1: not a vertex: .* must be numbers"),
        ("walk_7.obj", "", "frame 7: .*walk_7.obj: is empty"),
        ("walk_7.obj", "f 1 2 3\n", "frame 7: .*walk_7.obj: holds no vertices"),
        ("walk_7.obj", "v\0", "frame 7: .*walk_7.obj: is no text file"),
    ],
)
def test_frames_that_do_not_fit_are_refused(name: str, content: str, words: str, folder: Path) -> None:
    (folder / name).write_text(content)
    for motion, field in ((listed(), r"motion\[7\]"), ("walk_*.obj", "motion")):
        with pytest.raises(SceneError, match=rf"scene.body\[0\].{field} = .*{words}") as caught:
            Simulation(Scene(document(motion), folder=folder))
        assert leak(caught.value) is None


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ([], r"motion = \[\]: must be the path of an .npy or .pc2 file, or a list of .obj files"),
        (["walk_0.obj", ""], r'motion = \["walk_0.obj",""\]: must be the path'),
        (3, "motion.*a path or a list of paths"),
        ([3], "motion.*a path or a list of paths"),
        (["walk_0.obj", "gone.obj"], r"motion\[1\] = 'gone.obj': there is no file"),
        (["walk_0.obj", "walk.npy"], r"motion\[1\] = 'walk.npy': must be an .obj file, which holds one"),
        ("walk_0.obj", "motion = 'walk_0.obj': must be an .npy or .pc2 file; of .obj files, one for each"),
        ("gone_*.obj", r"motion = 'gone_\*.obj': there is no such file in .*; the \* stands for the number"),
        ("gone/walk_*.obj", r"motion = 'gone/walk_\*.obj': there is no such file in"),
        ("w*lk_*.obj", r"motion = .*must have one \* in the file's name"),
        ("*/walk_0.obj", r"motion = .*must have one \* in the file's name"),
        (["walk_*.obj"], r"motion\[0\] = 'walk_\*.obj': there is no file"),
    ],
)
def test_files_that_are_not_there_are_refused(motion: Any, words: str, folder: Path) -> None:
    np.save(folder / "walk.npy", walk())
    with pytest.raises(SceneError, match=rf"scene.body\[0\].{words}") as caught:
        Simulation(Scene(document(motion), folder=folder))
    assert leak(caught.value) is None


def test_numbers_leave_no_gap_and_are_there_once(folder: Path) -> None:
    scene = Scene(document("walk_*.obj"), folder=folder)
    (folder / "walk_07.obj").write_bytes((folder / "walk_7.obj").read_bytes())
    with pytest.raises(SceneError, match=r"'walk_07.obj' and 'walk_7.obj' have the same number; remove one"):
        scene.read_paths()
    (folder / "walk_07.obj").unlink()
    (folder / "walk_7.obj").unlink()
    gap = "there is no number 7 between 'walk_0.obj' and 'walk_11.obj'; numbers must leave no gap"
    with pytest.raises(SceneError, match=gap):
        scene.read_paths()
    with pytest.raises(SceneError, match=r"motion\[7\] = 'walk_7.obj': there is no file"):
        Scene(document(listed()), folder=folder).read_paths()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("{outside}/walk_*.obj", "is absolute"),
        ("../walk_*.obj", "leaves the scene's folder"),
        ("link/walk_*.obj", "leaves the scene's folder"),
        ("own_*.obj", "leaves the scene's folder"),
        ("https://example.org/walk_*.obj", "is a reference"),
    ],
)
def test_a_sandbox_refuses_what_leads_out_of_it(name: str, message: str, folder: Path) -> None:
    """Folders outside are not even looked at."""
    scenes = folder / "scenes"
    write_obj(scenes / "figure.obj", CORNERS)
    (scenes / "link").symlink_to(folder)
    (scenes / "own_0.obj").symlink_to(folder / "walk_0.obj")
    name = name.format(outside=folder)
    for motion in (name, [name.replace("*", "0")]):
        with pytest.raises(SceneError, match=rf"scene.body\[0\].motion.*{message}"):
            Scene(document(motion), folder=scenes, sandbox=True).read_paths()
    trusted = Scene(document("../walk_*.obj"), folder=scenes)
    assert len(paths(trusted)["../walk_*.obj"]) == FRAMES


def test_names_of_any_letters_reach_the_engine(folder: Path) -> None:
    """The engine asks for a list by its JSON, which both sides must write alike."""
    names = ['a "b" \\ c.obj', "schürze.obj", "tab\t.obj", "\x7f\x1f.obj", "🏃.obj", "a/b.obj"]
    for name, places in zip(names, walk(len(names)), strict=True):
        write_obj(folder / name, places)
    simulation = Simulation(Scene(document(names), folder=folder), threads=1)
    simulation.run(len(names) - 1)
    np.testing.assert_allclose(simulation.bodies["walker"].positions, walk(len(names))[-1], atol=1e-12)


def test_a_scene_with_a_list_explains_itself_and_is_changed_by_settings(folder: Path) -> None:
    scene = Scene(document(listed()), folder=folder)
    text = commented(scene, document(listed()), "walks")
    assert Scene(tomllib.loads(text)).document == scene.document
    assert Scene(json.loads(scene.to_json())).to_json() == scene.to_json()
    shorter = scene.with_settings(['body.walker.motion=["walk_0.obj","walk_1.obj"]'])
    assert [len(places) for places in paths(shorter).values()] == [2]


def test_a_run_beside_files_goes_on(folder: Path, taut: Callable[..., Any]) -> None:
    path = folder / "half.zarr"
    scene = Scene(document(listed()), folder=folder)
    record(Simulation(scene, threads=1), path, frames=4)
    record(Simulation(scene, threads=1), path, frames=8, existing="resume")
    record(Simulation(scene, threads=1), folder / "whole.zarr", frames=8)
    half, whole = Cache.open(path), Cache.open(folder / "whole.zarr")
    assert half.attributes["state_hash"] == whole.attributes["state_hash"]
    assert half.attributes["meshes"] == whole.attributes["meshes"]
    write_obj(folder / "walk_3.obj", walk()[4])
    with pytest.raises(Exception, match="another scene|mesh"):
        record(Simulation(scene, threads=1), path, frames=9, existing="resume")
