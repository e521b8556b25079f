"""Bodies of scenes: their meshes and motions come from files beside the scene, or as arrays."""

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Scene, SceneError, Simulation
from taut.scene.fields import fields, tables
from taut.scene.template import commented

from tests.attack.leaks import leak

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def with_body(**body: Any) -> dict[str, Any]:
    """A small cloth far above a body."""
    grid = {"size": [0.4, 0.4], "cells": [4, 4], "axes": ["x", "y"], "origin": [0.0, 0.0, 9.0]}
    return {"cloth": [{"name": "cloth", "grid": grid, "pins": [{"edge": "left"}]}], "body": [body]}


def walk(frames: int, vertices: int = 4) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Places of so many corners in every frame, each a centimetre further along x."""
    ways = np.array([[0.01 * frame, 0.0, 0.0] for frame in range(frames)])
    return CORNERS[None, :vertices] + ways[:, None]


def holed(frames: int, frame: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """A walk with a number that is none in one of its frames."""
    places = walk(frames)
    places[frame, 2, 0] = np.nan
    return places


def test_what_is_left_out_is_filled_in_and_reads_the_same_again() -> None:
    scene = Scene(with_body(sphere={"center": [0, 0, 1], "radius": 0.5}))
    body = scene.document["body"][0]
    assert (body["name"], body["friction"], body["thickness"]) == ("body0", 0.3, 0.001)
    assert scene.document["contact"] == {"self": False, "untangle": True}
    assert scene.document["cloth"][0]["thickness"] > 0 and scene.document["cloth"][0]["friction"] == 0.3
    assert Scene(json.loads(scene.to_json())).to_json() == scene.to_json()


def test_scenes_without_bodies_say_nothing_of_them() -> None:
    document = with_body()
    del document["body"]
    scene = Scene(document).document
    assert not {"body", "contact"} & scene.keys() and not {"thickness", "friction"} & scene["cloth"][0].keys()


def test_a_body_is_changed_by_name() -> None:
    document = with_body(sphere={"radius": 0.5})
    document["body"].append({"name": "floor", "plane": {"normal": [0, 0, 1]}})
    changed = Scene(document).with_settings(["body.body0.sphere.radius=0.7", "body.floor.friction=0.1"])
    ball, floor = changed.document["body"]
    assert (ball["sphere"]["radius"], floor["friction"]) == (0.7, 0.1)


def test_a_scene_with_bodies_explains_itself() -> None:
    box = {"center": [0, 0, 0], "size": [1, 1, 1], "rotate": [0, 0, 30]}
    document = with_body(name="block", box=box, move=[[1.0, [0.0, 0.0, 0.5]]])
    document["body"].append({"name": "floor", "plane": {"normal": [0, 0, 1]}})
    scene = Scene(document)
    text = commented(scene, document, "blocks")
    assert "[[body]]" in text and "[body.box]" in text
    assert Scene(tomllib.loads(text)).document == scene.document


@pytest.mark.parametrize("kind", ["array", "npy"])
def test_a_mesh_and_its_motion_are_found(kind: str, tmp_path: Path) -> None:
    meshes, paths = None, None
    if kind == "array":
        meshes, paths = {"figure.obj": (CORNERS, FACES)}, {"walk.npy": walk(5)}
    else:
        (tmp_path / "figure.obj").write_text(OBJ)
        np.save(tmp_path / "walk.npy", walk(5))
    document = with_body(mesh="figure.obj", motion="walk.npy")
    simulation = Simulation(Scene(document, meshes, folder=tmp_path, paths=paths), threads=1)
    np.testing.assert_array_equal(simulation.meshes["figure.obj"][0], CORNERS)
    np.testing.assert_array_equal(simulation.paths["walk.npy"][0], walk(5))
    simulation.run(2)
    assert np.isfinite(simulation.positions).all()


def test_a_cloth_and_a_body_may_be_of_one_mesh(tmp_path: Path) -> None:
    (tmp_path / "figure.obj").write_text(OBJ)
    document = with_body(mesh="figure.obj", translate=[0.0, 0.0, -9.0])
    document["cloth"].append({"mesh": "figure.obj", "pins": [{"vertices": [0]}]})
    assert list(Simulation(Scene(document, folder=tmp_path), threads=1).meshes) == ["figure.obj"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("/etc/passwd", "is absolute"),
        ("https://example.org/figure.obj", "is a reference"),
        ("../figure.obj", "leaves the scene's folder"),
        ("inside/../figure.obj", "leaves the scene's folder"),
        ("link.obj", "leaves the scene's folder"),
        ("gone.obj", "there is no file"),
    ],
)
def test_a_sandbox_refuses_hostile_paths(tmp_path: Path, name: str, message: str) -> None:
    folder = tmp_path / "scene"
    (folder / "inside").mkdir(parents=True)
    (tmp_path / "figure.obj").write_text(OBJ)
    (folder / "link.obj").symlink_to(tmp_path / "figure.obj")
    (folder / "own.obj").write_text(OBJ)
    with pytest.raises(SceneError, match=rf"scene.body\[0\].mesh = .*{message}"):
        Simulation(Scene(with_body(mesh=name), folder=folder, sandbox=True))
    motion = name.replace(".obj", ".npy")
    if name == "link.obj":
        np.save(tmp_path / "figure.npy", walk(3))
        (folder / motion).symlink_to(tmp_path / "figure.npy")
    with pytest.raises(SceneError, match=rf"scene.body\[0\].motion = .*{message}"):
        Simulation(Scene(with_body(mesh="own.obj", motion=motion), folder=folder, sandbox=True))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"nonsense", "is cut short, damaged, or holds objects; write it again"),
        (
            np.zeros((3, 5)),
            r"has shape \(3, 5\) and type float64; must be numbers of shape \(frames, vertices, 3\)",
        ),
        (
            walk(3, vertices=3),
            "has places of 3 vertices in every frame, the mesh of .walker. has 4 vertices; give",
        ),
        (walk(3)[:0], "has no frame; give at least one"),
        (walk(3) + 1.0, "a motion begins where the mesh is"),
        (walk(3) * [1.0, 1.0, np.nan], r"vertex 0 at \[.*\] in frame 0; all places must be finite numbers"),
        (holed(9, frame=7), r"vertex 2 at \[NaN, .*\] in frame 7; all places must be finite numbers"),
    ],
)
def test_motions_that_do_not_fit_are_refused(content: Any, words: str, tmp_path: Path) -> None:
    (tmp_path / "figure.obj").write_text(OBJ)
    if isinstance(content, bytes):
        (tmp_path / "walk.npy").write_bytes(content)
    else:
        np.save(tmp_path / "walk.npy", content)
    document = with_body(name="walker", mesh="figure.obj", motion="walk.npy")
    with pytest.raises(SceneError, match=words) as caught:
        Simulation(Scene(document, folder=tmp_path))
    assert "scene.body[0].motion = 'walk.npy'" in str(caught.value).replace('"', "'")
    assert leak(caught.value) is None


@pytest.mark.parametrize("filter_", ["none", "sweeps", "xpbd"])
def test_filters_without_contact_are_refused(filter_: str) -> None:
    document = with_body(sphere={"radius": 0.5}) | {"solver": {"filter": filter_}}
    with pytest.raises(SceneError, match=rf'scene.solver.filter = "{filter_}": knows no contact'):
        Scene(document)


def test_the_fields_are_those_of_the_schema() -> None:
    assert {"Body", "Sphere", "Capsule", "Cuboid", "Plane", "Turn", "Contact"} <= set(tables())
    assert {"box", "move", "motion"} <= {field.name for field in fields("Body")}
    assert [field.name for field in fields("Contact")] == ["self", "untangle"]


@pytest.mark.parametrize("kind", ["outwards", "inwards", "open"])
def test_cloth_stays_on_its_side_of_any_surface(kind: str) -> None:
    corners = np.array([[x, y, z] for z in (0.0, 0.5) for y in (-0.2, 0.2) for x in (-0.2, 0.2)])
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    if kind == "inwards":
        faces = [face[::-1] for face in faces]
    if kind == "open":
        faces = faces[1:2]
    cloth = {
        "grid": {"size": [0.6, 0.6], "cells": [12, 12], "axes": ["x", "y"], "origin": [-0.3, -0.3, 0.52]},
        "thickness": 0.004,
    }
    scene = Scene(
        {"cloth": [cloth], "contact": {"self": False}, "body": [{"mesh": "m"}]}, {"m": (corners, faces)}
    )
    simulation = Simulation(scene, threads=1)
    assert simulation.warnings == []
    inner = np.abs(simulation.positions[:, :2]).max(axis=1) < 0.12
    simulation.run(40)
    assert inner.any() and (simulation.positions[inner, 2] > 0.5).all()
    assert simulation.positions[:, 2].min() < 0.45, "it hangs over the edge"
