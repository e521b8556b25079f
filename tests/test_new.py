"""`taut new`: the scenes that it writes run, explain every field, and say what is so."""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Cache, Scene, Simulation
from taut.scene.fields import describe, fields, tables
from taut.scene.starter import KINDS
from taut.scene.template import commented, toml

Command = Callable[..., Any]

BOX = """\
v 0 0 2
v 0.3 0 2
v 0.3 0 1
v 0 0 1
v 0.1 0.1 0.5
v 0.25 0.1 0.5
f 1 2 3 4
f 4 3 6 5
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_scene_runs_and_moves(taut: Command, here: Path, kind: str) -> None:
    made = taut("new", f"my-{kind}", "--kind", kind)
    assert (made.status, made.err) == (0, "")
    command = made.out.split("next: taut ")[1].split()
    assert taut(*command, "--frames", 10, "--quiet").status == 0
    cache = Cache.open(here / f"my-{kind}.zarr")
    moved = np.linalg.norm(cache.positions(9) - cache.positions(0), axis=1)
    assert 0.01 < moved.max() < 1.0
    assert (moved == 0).sum() == {"flag": 33, "hanging": 2}[kind]  # the pins


@pytest.mark.parametrize("up", ["z", "y"])
def test_a_breeze_is_weaker_than_the_weight_of_cloth(taut: Command, here: Path, up: str) -> None:
    Path("box.obj").write_text(BOX)
    taut("new", "hung", "--mesh", "box.obj", "--up", up)
    document = Scene.load("hung.toml").document
    wind, cloth = document["wind"], document["cloth"][0]
    speed = np.linalg.norm(wind["velocity"]) * (1 + wind["gust"]["strength"])
    pressure = 0.5 * wind["density"] * cloth["drag_coefficient"] * speed**2
    assert 0 < pressure < 9.81 * cloth["density"]
    assert wind["velocity"]["xyz".index(up)] == 0
    assert cloth["bending"] > 0


def test_a_flag_is_the_default(taut: Command, here: Path) -> None:
    taut("new", "banner.toml")
    assert Scene.load("banner.toml").document["cloth"][0]["name"] == "flag"
    assert Scene.load("banner.toml").title == "Banner"


def test_a_name_that_is_taken_by_a_shipped_scene_is_told(taut: Command, here: Path) -> None:
    assert "warning: without .toml, net is the scene that comes with taut" in taut("new", "net").err


@pytest.mark.parametrize("kind", KINDS)
def test_fields_left_out_are_shown_with_the_values_that_they_have(kind: str) -> None:
    document = KINDS[kind]("Anything")
    scene = Scene(document)
    text = commented(scene, document, "anything")
    assert Scene(tomllib.loads(text)).document == scene.document
    shown = re.sub(r"^#(\w+ = )", r"\1", text, flags=re.MULTILINE)
    assert shown != text
    assert Scene(tomllib.loads(shown)).document == scene.document


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_of_every_table_in_use_is_there(kind: str) -> None:
    document = KINDS[kind]("Anything")
    text = commented(Scene(document), document, "anything")
    prose = " ".join(line.removeprefix("#").strip() for line in text.splitlines())
    assert describe("Cloth") in prose
    for table in ("Scene", "Cloth", "Solver", "Grid"):
        for field in fields(table):
            assert field.name == "cloth" or field.description in prose, field.name
    assert '"silk", "cotton", "wool"' in prose  # words that the description does not list
    assert "exactly one of `corner`, `edge`, `vertices`, `box`, `nearest`" in prose


def test_the_fields_are_those_of_the_schema() -> None:
    assert {"Scene", "Cloth", "Grid", "Network", "Pin", "Weight", "Solver", "Wind", "Gust"} <= set(tables())
    solver = {field.name: field for field in fields("Solver")}
    assert "sweeps" in solver["filter"].choices
    assert solver["filter"].default == "coarse_to_fine"
    pins = next(field for field in fields("Cloth") if field.name == "pins")
    assert (pins.table, pins.many) == ("Pin", True)
    gravity = next(field for field in fields() if field.name == "gravity")
    assert (gravity.table, gravity.many) == (None, False)
    assert describe("Gust").startswith("Seeded fluctuations")


def test_values_survive_as_toml() -> None:
    value = {"a": [1, 2.5, -1e-7], "b": {"c": 'quo"ted \\ text, ü', "d": True}, "e": []}
    assert tomllib.loads(f"value = {toml(value)}")["value"] == value


class TestMesh:
    def test_it_is_held_at_the_top(self, taut: Command, here: Path) -> None:
        (here / "meshes").mkdir()
        (here / "meshes" / "box.obj").write_text(BOX)
        assert taut("new", "mine", "--mesh", "meshes/box.obj").status == 0
        simulation = Simulation(Scene.load("mine.toml"))
        assert simulation.pinned.tolist() == [True, True, False, False, False, False]

    def test_up_may_be_y(self, taut: Command, here: Path) -> None:
        (here / "box.obj").write_text(re.sub(r"v (\S+) (\S+) (\S+)", r"v \1 \3 \2", BOX))
        assert taut("new", "mine", "--mesh", "box.obj", "--up", "y").status == 0
        scene = Scene.load("mine.toml")
        assert scene.document["gravity"] == [0, -9.81, 0]
        assert Simulation(scene).pinned.tolist() == [True, True, False, False, False, False]

    def test_a_level_one_is_held_by_two_corners(self, taut: Command, here: Path) -> None:
        (here / "level.obj").write_text("v 0 0 1\nv 2 0 1\nv 2 3 1\nv 0 3 1\nf 1 2 3 4\n")
        assert taut("new", "mine", "--mesh", "level.obj").status == 0
        assert Simulation(Scene.load("mine.toml")).pinned.tolist() == [False, False, True, True]

    def test_a_tiny_one_is_held_too(self, taut: Command, here: Path) -> None:
        small = re.sub(
            r"v (\S+) (\S+) (\S+)", lambda m: "v " + " ".join(f"{float(x) / 1e3}" for x in m.groups()), BOX
        )
        (here / "small.obj").write_text(small)
        assert taut("new", "mine", "--mesh", "small.obj").status == 0
        assert Simulation(Scene.load("mine.toml")).pinned.sum() == 2

    def test_it_may_lie_beside_a_scene_elsewhere(self, taut: Command, here: Path) -> None:
        (here / "there").mkdir()
        (here / "there" / "box.obj").write_text(BOX)
        assert taut("new", "there/mine", "--mesh", "there/box.obj").status == 0
        assert Scene.load("there/mine.toml").document["cloth"][0]["mesh"] == "box.obj"

    def test_it_may_lie_anywhere(self, taut: Command, here: Path) -> None:
        (here / "there").mkdir()
        (here / "box.obj").write_text(BOX)
        for name, given, path in (
            ("relative", Path("box.obj"), "../box.obj"),
            ("absolute", here / "box.obj", str(here / "box.obj")),
        ):
            assert taut("new", f"there/{name}", "--mesh", given).status == 0
            scene = Scene.load(f"there/{name}.toml")
            assert scene.document["cloth"][0]["mesh"] == path
            Simulation(scene)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["taken"], "taken.toml exists already, and nothing is overwritten"),
        (["link"], "link.toml exists already"),
        (["gone/new"], "there is no folder gone to write new.toml to"),
        (["."], "NAME = '.': is no name for a scene"),
        ([""], "is no name for a scene"),
        (["a\nb"], "is no name for a scene"),
        (["new", "--mesh", "box.obj", "--kind", "flag"], "give one of them"),
        (["new", "--up", "y"], "--up y says how a mesh stands"),
        (["new", "--mesh", "gone.obj"], "there is no file"),
        (["new", "--mesh", "../gone.obj"], "there is no file"),
        (["new", "--mesh", "taken.toml"], ".toml is not a mesh format"),
        (["new", "--mesh", "broken.obj"], "broken.obj"),
        (["new", "--kind", "sail"], "'flag', 'hanging'"),
    ],
)
def test_refusals_say_why_and_write_nothing(
    taut: Command, here: Path, arguments: list[str], message: str
) -> None:
    (here / "taken.toml").write_text("mine")
    (here / "link.toml").symlink_to(here / "nowhere")
    (here / "box.obj").write_text(BOX)
    (here / "broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
    before = sorted(here.iterdir())
    refused = taut("new", *arguments)
    assert refused.status == 2
    assert message in " ".join(refused.err.split())
    assert sorted(here.iterdir()) == before
    assert (here / "taken.toml").read_text() == "mine"
