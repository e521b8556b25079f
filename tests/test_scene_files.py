import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from taut import Scene, SceneError, Simulation
from taut.scene.plain import plain
from taut.scene.settings import apply_setting

SQUARE = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"


def with_mesh(name: str) -> dict[str, Any]:
    return {"cloth": [{"name": "shirt", "mesh": name, "pins": [{"vertices": [0]}]}]}


def test_a_file_and_a_dict_give_the_same_scene(flag_file: Path, flag: dict[str, Any]) -> None:
    loaded, made = Scene.load(flag_file), Scene(flag)
    assert loaded.document == made.document
    assert loaded.folder == flag_file.parent
    assert (loaded.title, loaded.fps, loaded.frames) == ("Small flag", 60.0, 30)
    assert json.loads(loaded.to_json()) == loaded.document


def test_a_resolved_scene_resolves_to_itself(flag: dict[str, Any]) -> None:
    document = Scene(flag).document
    assert Scene(document).document == document


def test_a_scene_does_not_change_with_its_document(flag: dict[str, Any]) -> None:
    scene = Scene(flag)
    scene.document["cloth"].clear()
    flag["cloth"].clear()
    assert len(scene.document["cloth"]) == 1
    assert scene.with_settings([]).document == scene.document


def test_numpy_may_stand_for_lists(flag: dict[str, Any]) -> None:
    plain_scene = Scene(flag)
    flag["wind"]["velocity"] = np.array(flag["wind"]["velocity"])
    flag["cloth"][0]["grid"]["cells"] = tuple(np.array([6, 4]))
    flag["fps"] = np.float64(60)
    assert Scene(flag).document == plain_scene.document


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf"), np.float32("nan")])
def test_numbers_must_be_finite(flag: dict[str, Any], number: float) -> None:
    flag["gravity"] = [0, 0, number]
    with pytest.raises(SceneError, match=r"^scene.gravity\[2\] = -?(nan|inf): must be a finite number$"):
        Scene(flag)


def test_numbers_in_arrays_must_be_finite() -> None:
    points = np.zeros((3, 3))
    points[1, 2] = np.nan
    with pytest.raises(SceneError, match=r"^scene.cloth\[0\].network.points\[1\]\[2\] = nan: "):
        Scene({"cloth": [{"network": {"points": points, "links": [[0, 1]]}}]})


@pytest.mark.parametrize("text", ["nan", "inf", "1e999"])
def test_numbers_in_files_must_be_finite(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(f"duration = {text}\n")
    with pytest.raises(SceneError, match=r"^scene.duration = (nan|inf): must be a finite number$"):
        Scene.load(path)


def test_values_that_json_lacks_are_named(flag: dict[str, Any]) -> None:
    flag["title"] = {1, 2}
    with pytest.raises(SceneError, match="^scene.title = .* is a set; must be a number, text"):
        Scene(flag)
    with pytest.raises(SceneError, match="the field name 3 is a int; must be text"):
        Scene({3: "x"})  # type: ignore[dict-item]


def test_deep_nesting_is_refused(tmp_path: Path) -> None:
    deep: list[Any] = []
    for _ in range(10_000):
        deep = [deep]
    with pytest.raises(SceneError, match="nested more than"):
        Scene({"title": deep})
    path = tmp_path / "deep.toml"
    path.write_text("title = " + 100_000 * "[")
    with pytest.raises(SceneError, match="nested too deeply|is not TOML"):
        Scene.load(path)


def test_toml_errors_name_file_line_and_reason(tmp_path: Path) -> None:
    path = tmp_path / "broken.toml"
    path.write_text("fps = 60\nduration = = 3\n")
    with pytest.raises(SceneError, match=r"broken.toml: is not TOML: .*line 2, column 12"):
        Scene.load(path)
    path.write_bytes(b'title = "\xff"\n')
    with pytest.raises(SceneError, match=r"broken.toml: is not UTF-8 text \(byte 9\)"):
        Scene.load(path)
    with pytest.raises(SceneError, match=r"cannot read the scene .*gone.toml: No such file"):
        Scene.load(tmp_path / "gone.toml")


def test_misspelt_fields_get_a_suggestion(flag: dict[str, Any]) -> None:
    flag["cloth"][0]["strainlimit"] = 0.1
    with pytest.raises(SceneError, match=r"scene.cloth\[0\].strainlimit: .*did you mean `strain_limit`"):
        Scene(flag)


def test_heavy_silk_is_warned_of(flag: dict[str, Any]) -> None:
    flag["cloth"][0] |= {"fabric": "silk", "density": 1.0}
    assert any("density" in warning for warning in Scene(flag).warnings)


class TestSettings:
    def test_values(self, flag: dict[str, Any]) -> None:
        settings = [
            "solver.filter=none",
            "cloth[0].strain_limit = 0.1",
            "wind.velocity=[12, 0, 0.5]",
            "title=Flag, without limit",
            "solver.force_step=true",
            'cloth[0].pins[0].edge = "top"',
        ]
        changed = Scene(flag).with_settings(settings).document
        assert changed["solver"]["filter"] == "none"
        assert changed["cloth"][0]["strain_limit"] == 0.1
        assert changed["wind"]["velocity"] == [12, 0, 0.5]
        assert changed["title"] == "Flag, without limit"
        assert changed["solver"]["force_step"] is True
        assert changed["cloth"][0]["pins"][0]["edge"] == "top"

    def test_tables_come_into_being(self, flag: dict[str, Any]) -> None:
        del flag["wind"]
        changed = Scene(flag).with_settings(["wind.gust.strength=0.3"])
        assert changed.document["wind"]["gust"]["strength"] == 0.3

    def test_a_cloth_by_name(self, flag: dict[str, Any]) -> None:
        second = dict(flag["cloth"][0], grid=dict(flag["cloth"][0]["grid"], origin=[0, 3, 1]))
        del second["name"]
        flag["cloth"].append(second)
        changed = Scene(flag).with_settings(["cloth.flag.strain_limit=0.2", "cloth.cloth1.strain_limit=0.3"])
        assert [cloth["strain_limit"] for cloth in changed.document["cloth"]] == [0.2, 0.3]
        with pytest.raises(SceneError, match=r"'falg' must be a number, .* one of the names: flag, cloth1"):
            Scene(flag).with_settings(["cloth.falg.strain_limit=0.2"])

    def test_a_fabric_brings_its_values(self, flag: dict[str, Any]) -> None:
        denim = dict(flag, cloth=[dict(flag["cloth"][0], fabric="denim")])
        assert Scene(flag).with_settings(["cloth.flag.fabric=denim"]).document == Scene(denim).document

    @pytest.mark.parametrize(
        ("setting", "message"),
        [
            ("solver.filter", "must read path=value"),
            ("=3", "the path is empty"),
            ("solver..filter=none", "cannot read the path at '..filter'"),
            (".solver=3", "cannot read the path"),
            ("[0]=3", "cannot read the path"),
            ("cloth[0]strain_limit=3", "cannot read the path at 'strain_limit'"),
            ("cloth[7].name=x", r"\[7\] is out of range; there are 1"),
            ("cloth[-1].name=x", "cannot read the path"),
            ("fps.x=3", "lies below a single value"),
            ("fps=[1,", "is not a value"),
            ("fps=3 m", "is not a value"),
            ("fps=1\nduration=2", "is not a value"),
            ("fps=", "is not a value"),
            ("fps=nan", "scene.fps = nan: must be a finite number"),
            ("solver.filtre=none", "did you mean `filter`"),
            ("solver.filter=swebs", "did you mean `sweeps`"),
            ("slover.filter=none", "did you mean `solver`"),
        ],
    )
    def test_mistakes_are_named(self, flag: dict[str, Any], setting: str, message: str) -> None:
        with pytest.raises(SceneError, match=message):
            Scene(flag).with_settings([setting])

    @given(
        path=st.lists(st.from_regex(r"[A-Za-z_-][A-Za-z0-9_-]*", fullmatch=True), min_size=1, max_size=5),
        value=st.one_of(
            st.booleans(),
            st.integers(-(2**53), 2**53),
            st.floats(allow_nan=False, allow_infinity=False),
            st.lists(st.integers(0, 9), max_size=3),
            st.text(st.characters(codec="ascii", exclude_categories=["C"]), max_size=20),
        ),
    )
    def test_what_is_set_is_there(self, path: list[str], value: Any) -> None:
        document: dict[str, Any] = {}
        apply_setting(document, f"{'.'.join(path)}={json.dumps(value)}")
        for name in path:
            document = document[name]
        assert document == value


class TestMeshes:
    def test_a_file_beside_the_scene(self, tmp_path: Path) -> None:
        (tmp_path / "meshes").mkdir()
        (tmp_path / "meshes/shirt.obj").write_text(OBJ)
        scene = Scene(with_mesh("meshes/../meshes/shirt.obj"), folder=tmp_path)
        simulation = Simulation(scene)
        np.testing.assert_array_equal(simulation.positions, SQUARE)

    def test_arrays(self) -> None:
        scene = Scene(with_mesh("shirt"), meshes={"shirt": (SQUARE, [[0, 1, 2, 3]])})
        simulation = Simulation(scene)
        assert len(simulation.faces) == 2
        np.testing.assert_array_equal(simulation.positions, SQUARE)
        assert Simulation(scene.with_settings(["fps=30"])).mass.sum() == simulation.mass.sum()

    def test_a_scene_of_arrays_is_that_of_a_file(self, tmp_path: Path) -> None:
        (tmp_path / "shirt.obj").write_text(OBJ)
        cloth = {"name": "shirt", "mesh": "shirt.obj", "fabric": "denim", "pins": [{"vertices": [0, 3]}]}
        filed = Simulation(Scene({"fps": 30, "cloth": [cloth]}, folder=tmp_path))
        faces = [[0, 1, 2, 3]]
        for pins in ([0, 3], np.array([0, 3]), [{"vertices": [0, 3]}]):
            scene = Scene.from_arrays(
                SQUARE, faces, pins=pins, scene={"fps": 30}, name="shirt", fabric="denim"
            )
            made = Simulation(scene)
            np.testing.assert_array_equal(made.faces, filed.faces)
            made.step(20)
        filed.step(20)
        assert made.state_hash == filed.state_hash
        assert not Simulation(Scene.from_arrays(SQUARE, faces)).pinned.any()

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"positions": np.zeros((4, 2))}, r"meshes\['cloth'\] vertices: has shape"),
            ({"faces": [[0, 1, 9]]}, r"meshes\['cloth'\] faces\[0\].*indices must be from 0 to 3"),
            ({"pins": [0.5]}, r"cloth\[0\].pins\[0\].vertices"),
            ({"fabirc": "silk"}, "did you mean `fabric`"),
            ({"mesh": "shirt.obj"}, "the arrays are the mesh"),
            ({"scene": {"cloth": []}}, "the arrays are the cloth"),
        ],
    )
    def test_bad_parts_of_a_scene_of_arrays_are_named(self, given: dict[str, Any], message: str) -> None:
        with pytest.raises(SceneError, match=message):
            Scene.from_arrays(**{"positions": SQUARE, "faces": [[0, 1, 2, 3]]} | given)

    @pytest.mark.parametrize(
        ("name", "message"),
        [
            ("/etc/passwd", "is absolute"),
            ("C:\\shirt.obj", "is absolute|is a reference"),
            ("\\\\host\\share\\shirt.obj", "is absolute"),
            ("file:shirt.obj", "is a reference"),
            ("file:///home/shirt.obj", "is a reference"),
            ("https://example.org/shirt.obj", "is a reference"),
            ("../shirt.obj", "leaves the scene's folder"),
            ("inside/../../shirt.obj", "leaves the scene's folder"),
            ("inside/../shirt.obj", "leaves the scene's folder"),
            ("inside\\..\\shirt.obj", "leaves the scene's folder"),
            ("link.obj", "leaves the scene's folder"),
            ("gone.obj", "there is no file"),
            ("inside", "there is no file"),
            ("a\0b.obj", "is no file name"),
        ],
    )
    def test_a_sandbox_refuses_hostile_paths(self, tmp_path: Path, name: str, message: str) -> None:
        folder = tmp_path / "scene"
        (folder / "inside").mkdir(parents=True)
        (tmp_path / "shirt.obj").write_text(OBJ)
        (folder / "link.obj").symlink_to(tmp_path / "shirt.obj")
        scene = Scene(with_mesh(name), folder=folder, sandbox=True)
        for hostile in (scene, scene.with_settings(["fps=30"])):
            with pytest.raises(SceneError, match=rf"scene.cloth\[0\].mesh.*({message})"):
                Simulation(hostile)

    def test_ones_own_meshes_lie_anywhere(self, tmp_path: Path) -> None:
        folder = tmp_path / "scene"
        folder.mkdir()
        (tmp_path / "shirt.obj").write_text(OBJ)
        (folder / "link.obj").symlink_to(tmp_path / "shirt.obj")
        for name in ("../shirt.obj", "link.obj", str(tmp_path / "shirt.obj")):
            np.testing.assert_array_equal(Simulation(Scene(with_mesh(name), folder=folder)).positions, SQUARE)
        for name in ("https://example.org/shirt.obj", "gone.obj", str(tmp_path), "a\0b.obj"):
            with pytest.raises(SceneError, match=r"scene.cloth\[0\].mesh.*(is a reference|no file)"):
                Simulation(Scene(with_mesh(name), folder=folder))

    @pytest.mark.parametrize(
        ("vertices", "faces", "message"),
        [
            (np.zeros((4, 2)), [[0, 1, 2]], r"vertices: has shape \(4, 2\)"),
            (np.zeros((4, 3), complex), [[0, 1, 2]], "type complex128"),
            ("abc", [[0, 1, 2]], "must be numbers"),
            ([[0, 0, 0], [1, 2]], [[0, 1, 2]], "is no array of numbers"),
            (SQUARE, [0, 1, 2], r"faces: has shape \(3,\)"),
            (SQUARE, [[0.0, 1.0, 2.0]], "faces: .* must be integers"),
            (SQUARE, [[0, 1, 2, 3, 0]], r"or \(faces, 4\)"),
            (SQUARE, [[0, 1, 2], [0, 1, 4]], r"faces\[1\] = \[0, 1, 4\]: indices must be from 0 to 3"),
            (SQUARE, [[0, 1, -1]], "indices must be from 0 to 3"),
            ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]], r"vertices\[1\] = .*: must be finite"),
        ],
    )
    def test_bad_arrays_are_refused(self, vertices: Any, faces: Any, message: str) -> None:
        with pytest.raises(SceneError, match=rf"^meshes\['shirt'\] .*{message}"):
            Scene(with_mesh("shirt"), meshes={"shirt": (vertices, faces)})


def values(leaves: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.recursive(
        leaves, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4)
    )


@given(values(st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text()))
def test_plain_values_stay_as_they_are(value: Any) -> None:
    assert plain(value) == value
    assert json.loads(json.dumps(plain(value), allow_nan=False)) == value


@given(
    st.dictionaries(st.text(), values(st.none() | st.booleans() | st.integers() | st.floats() | st.text()))
)
def test_any_document_gives_a_scene_or_a_scene_error(document: dict[str, Any]) -> None:
    try:
        Scene(document)
    except SceneError as error:
        assert str(error)
