"""`taut compare`: its figures are those of the caches, it refuses what it must, nothing is left half done."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import zarr
from PIL import Image
from taut import Cache, Scene, Simulation, record
from taut.compare import FORMAT, Conditions, Method, Options, choose, compare, known
from taut.compare.measure import energy_kept
from taut.compare.methods import dial_of
from taut.compare.neighbours import one_pass
from taut.errors import CompareError, SimulationError

ROOT = Path(__file__).resolve().parent.parent
Command = Callable[..., Any]

SHEET = """\
title = "Small drop"
duration = 0.5
[[cloth]]
name = "sheet"
grid = { size = [1.0, 1.0], cells = [6, 6], origin = [0, 0, 1.5], axes = ["x", "y"] }
fabric = "cotton"
strain_limit = 0.10
density = 0.2
pins = [{ corner = "bottom-left" }]
"""
FREE = """\
duration = 0.1
[[cloth]]
grid = { size = [0.4, 0.2], cells = [4, 2], axes = ["x", "y"] }
density = 0.2
air_drag = 0.0
"""
FILTERS = ["none", "coarse_to_fine", "provot"]
NO_SPRINGS = "cloth=[{ network = { points = [[0, 0, 0]], links = [], mass = 0.1 } }]"


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A comparison with everything in it; not to be changed."""
    folder = tmp_path_factory.mktemp("compare")
    (folder / "sheet.toml").write_text(SHEET)
    scene = Scene.load(folder / "sheet.toml")
    options = Options(Conditions(threads=1), budget=20.0)
    compare(scene, choose(FILTERS, ["euler"]), folder / "out", options)
    return folder / "out"


def document(folder: Path) -> dict[str, Any]:
    read: dict[str, Any] = json.loads((folder / "compare.json").read_text())
    return read


def stretches(cache: Path) -> np.ndarray:
    """Stretch of every spring in every frame, by NumPy alone."""
    group = zarr.open_group(cache, mode="r")
    u, v = group["springs"][:].T
    x = group["positions"][:].astype(np.float64)
    return np.linalg.norm(x[:, v] - x[:, u], axis=2) / group["rest_length"][:] - 1


def test_the_table_says_what_the_caches_hold(compared: Path) -> None:
    runs = document(compared)["runs"]
    assert [run["filter"] for run in runs if run["settings"] == "usual"] == FILTERS
    for run in runs:
        group = zarr.open_group(compared / run["cache"], mode="r")
        stretch = stretches(compared / run["cache"])
        structural = group["spring_kind"][:] == 0
        assert run["frames"] == len(stretch) == 30
        assert run["worst_stretch"] == pytest.approx(stretch.max(), abs=1e-6)
        assert run["worst_structural"] == pytest.approx(stretch[:, structural].max(), abs=1e-6)
        assert run["p99_stretch"] == pytest.approx(np.percentile(stretch, 99), abs=1e-6)
        assert run["mean_stretch"] == pytest.approx(np.where(stretch > 0, stretch, 0).mean(), abs=1e-6)
        assert run["over_limit"] == pytest.approx((stretch > 0.1 + 1e-5).mean(), abs=2e-3)
        assert run["ms_per_frame"] == pytest.approx(np.median(group["diagnostics/ms"][1:]))
        assert run["ms_per_step"] == pytest.approx(run["ms_per_frame"] / group.attrs["substeps"])
        assert run["rest_time"] is None


def test_motion_is_measured_as_it_is_said(compared: Path) -> None:
    """Masses of a square grid: a quarter of each cell around a particle; all but the pinned corner count."""
    cells = np.outer([1, *[2] * 5, 1], [1, *[2] * 5, 1]).ravel()
    mass = 0.2 * (1 / 6) ** 2 * cells / 4
    for run in document(compared)["runs"]:
        group = zarr.open_group(compared / run["cache"], mode="r")
        x, v = group["positions"][:, 1:].astype(float), group["velocities"][:, 1:].astype(float)
        height = x[:, :, 2] @ mass[1:] / mass[1:].sum()
        assert run["fallen"] == pytest.approx(height[0] - height[-1], abs=1e-5)
        kinetic = 0.5 * (v**2).sum(axis=2) @ mass[1:]
        if (np.diff(height) < 0).all():  # still falling in the last frame
            elastic = group["diagnostics/elastic_energy"][-1]
            given = mass[1:].sum() * 9.81 * (height[0] - height[-1])
            assert run["energy_kept"] == pytest.approx((kinetic[-1] + elastic) / given, rel=1e-4)


def test_every_name_in_the_json_stays(compared: Path) -> None:
    found = document(compared)
    assert found["format"] == FORMAT == "taut-comparison/1"
    shape = {
        "": {"version", "machine", "threads", "interrupted", "scene", "rest_speed", "undefined", "format"}
        | {"equal_stretch", "runs", "searches", "refused", "passes", "pictures"},
        "scene": {"title", "vertices", "springs", "strain_limit", "fps"},
        "undefined": {"energy_kept", "momentum_drift"},
        "equal_stretch": {"target", "budget"},
        "runs": {"filter", "integrator", "settings", "changed", "cache", "ended", "frames"}
        | {"steps_per_frame", "worst_stretch", "worst_structural", "p99_stretch", "mean_stretch"}
        | {"over_limit", "ms_per_frame", "ms_per_step", "energy_kept", "momentum_drift", "rest_time"}
        | {"fallen"},
        "searches": {"filter", "integrator", "dial", "factor", "why_not", "trials"},
        "passes": {"filter", "integrator", "over_before", "over_after", "pushed_over", "pushed_neighbours"},
        "pictures": {"name", "caption"},
    }
    assert set(found) == shape.pop("")
    for name, keys in shape.items():
        for item in found[name] if isinstance(found[name], list) else [found[name]]:
            assert set(item) == keys, name
    assert found["scene"] == {
        "title": "Small drop",
        "vertices": 49,
        "springs": 156,
        "strain_limit": 0.1,
        "fps": 60.0,
    }
    assert found["undefined"] == {"energy_kept": None, "momentum_drift": "pins hold the cloth"}


def test_settings_of_equal_stretch_keep_it(compared: Path) -> None:
    found = document(compared)
    target = found["equal_stretch"]["target"]
    assert target == pytest.approx(1.05 * 0.1)
    searches = {search["filter"]: search for search in found["searches"]}
    assert searches["coarse_to_fine"] == {
        "filter": "coarse_to_fine",
        "integrator": "euler",
        "dial": "steps",
        "factor": 1.0,
        "why_not": None,
        "trials": [],
    }
    equal = {run["filter"]: run for run in found["runs"] if run["settings"] == "equal"}
    assert set(equal) == {"none", "provot"}
    for name, run in equal.items():
        assert stretches(compared / run["cache"]).max() <= target + 1e-6
        trials = searches[name]["trials"]
        kept = [trial["factor"] for trial in trials if trial["ended"] is None]
        failed = [trial["factor"] for trial in trials if trial["ended"] is not None]
        assert min(kept) == searches[name]["factor"]
        assert max(failed, default=1.0) < min(kept) <= 2 * max(failed, default=1.0)
        assert all(trial["worst_stretch"] > target for trial in trials if trial["ended"] is not None)
    stiffness = Cache.open(compared / equal["none"]["cache"]).scene["cloth"][0]["stiffness"]
    assert stiffness == pytest.approx(20 * searches["none"]["factor"])
    passes = Cache.open(compared / equal["provot"]["cache"]).scene["solver"]["iterations"]
    assert passes == round(searches["provot"]["factor"])


def test_pictures_tables_and_film_are_there(compared: Path) -> None:
    page = (compared / "compare.md").read_text()
    for picture in document(compared)["pictures"]:
        assert f"]({picture['name']})" in page
        with Image.open(compared / picture["name"]) as image:
            assert np.asarray(image.convert("L")).std() > 5
    assert {path.name for path in compared.iterdir()} == {
        *("compare.md", "compare.json", "film.mp4", "caches", "strip.jpg"),
        *("cost.png", "stretch.png", "distribution.png", "motion.png", "passes.png"),
    }
    rows = [line for line in page.splitlines() if line.startswith("| `none` |")]
    worst = document(compared)["runs"][0]["worst_stretch"]
    assert f" {100 * worst:.2f} % " in rows[0] or f" {100 * worst:.0f} % " in rows[0]
    assert "- Momentum: not defined, since pins hold the cloth." in page


def test_a_pass_of_provot_stretches_the_neighbour_by_half(tmp_path: Path) -> None:
    """A spring at its limit, the next one e beyond: half of e goes into the first (methods/filters.md)."""
    network = {"points": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "links": [[0, 1], [1, 2]], "mass": 0.1}
    cloth = {"network": network, "stiffness": 1e-6, "damping": 0.0, "air_drag": 0.0, "strain_limit": 0.1}
    solver = {"filter": "provot", "substeps": 1}
    scene = Scene({"gravity": [0, 0, 0], "solver": solver, "cloth": [{**cloth, "pins": [{"vertices": [0]}]}]})
    simulation = Simulation(scene)
    simulation.positions = np.array([[0, 0, 0], [1.1, 0, 0], [2.2, 0, 0]])
    simulation.velocities = np.array([[0, 0, 0], [0, 0, 0], [0.04 * 60, 0, 0]])
    record(simulation, tmp_path / "cache.zarr", frames=1)
    one = one_pass(scene, Cache.open(tmp_path / "cache.zarr"))
    np.testing.assert_allclose(one.before, [0.1, 0.14], atol=1e-6)
    np.testing.assert_allclose(one.after, [0.12, 0.1], atol=1e-6)
    assert one.pushed.tolist() == one.near.tolist() == [True, False]
    assert (one.over_before, one.over_after, one.pushed_neighbours) == (0.5, 0.5, 1.0)


def test_energy_kept_of_known_motions() -> None:
    """A pendulum without loss keeps all, a thing that stops in its fall keeps nothing."""
    swing = 0.5 - 0.5 * np.cos(np.linspace(0, 3 * np.pi, 200))
    for share in (1.0, 0.3):
        lossy = SimpleNamespace(
            diagnostics={
                "potential_energy": -swing,
                "kinetic_energy": share * swing,
                "elastic_energy": 0 * swing,
            }
        )
        assert energy_kept(lossy) == pytest.approx(share)
    time = np.linspace(0, 2, 200)
    stopped = {
        "potential_energy": -np.minimum(time, 1.0),
        "kinetic_energy": np.where(time < 1.0, time, 0.0),
        "elastic_energy": 0 * time,
    }
    assert energy_kept(SimpleNamespace(diagnostics=stopped)) == pytest.approx(0.0, abs=0.02)


def test_momentum_of_a_free_cloth(taut: Command, tmp_path: Path) -> None:
    (tmp_path / "free.toml").write_text(FREE)
    done = taut(
        "compare",
        tmp_path / "free.toml",
        *("--out", tmp_path / "out", "--filters", "none,sweeps,tethers", "--no-film", "--budget", 5),
    )
    assert done.status == 0, done.err
    found = document(tmp_path / "out")
    assert found["undefined"]["momentum_drift"] is None
    for run in found["runs"]:
        v = zarr.open_group(tmp_path / "out" / run["cache"], mode="r")["velocities"][:].astype(float)
        fall = 9.81 * np.arange(len(v)) / 60  # all fall alike
        np.testing.assert_allclose(v[:, :, 2], -np.broadcast_to(fall[:, None], v.shape[:2]), atol=1e-4)
        assert 0 <= run["momentum_drift"] < 1e-5
    (refused,) = found["refused"]
    assert refused["filter"] == "tethers"
    assert "pin" in refused["reason"]
    assert f"- `tethers` refuses: {refused['reason']}" in (tmp_path / "out" / "compare.md").read_text()
    assert "tethers  refused: " in done.out


def test_the_dial_of_a_method() -> None:
    grid = {"grid": {"size": [1.0, 1.0], "cells": [2, 2]}}
    springs = Scene({"cloth": [grid]})
    curve = Scene({"cloth": [grid | {"curves": {"tension": [[0, 0], [0.05, 1.0], [0.1, 50.0]]}}]})
    dials = {name: dial_of(Method(name, "euler"), springs).name for name in known("FilterKind")}
    passes = {name for name, dial in dials.items() if dial == "passes"}
    assert (
        passes == {"provot", "sweeps", "rods"} and dials["none"] == "stiffness" and dials["xpbd"] == "steps"
    )
    assert dial_of(Method("none", "euler"), curve).name == "steps"  # a curve has no stiffness to turn up


def test_names_come_from_the_schema() -> None:
    schema = json.loads((ROOT / "docs" / "scene.schema.json").read_text())["$defs"]
    for kind in ("FilterKind", "IntegratorKind"):
        assert list(known(kind)) == [choice["const"] for choice in schema[kind]["oneOf"]]
    assert choose(["none", "all"], ["euler", "euler"]) == [
        Method(name, "euler") for name in known("FilterKind")
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--filters", "none,tether"], "tethers, xpbd, or all; did you mean tethers?"),
        (["--filters", ","], "filters is empty: name some of none"),
        (["--integrators", "leapfrog"], "integrators = 'leapfrog': must be some of euler"),
        (["--set", "cloth[0].density=-1"], "scene.cloth[0].density = -1"),
        (["--set", "cloth[0].pins=[]", "--filters", "tethers"], "none of these methods simulates the scene"),
        (["--set", NO_SPRINGS], "the scene has no springs that could stretch"),
    ],
)
def test_bad_input_is_one_red_line(taut: Command, tmp_path: Path, arguments: list[str], message: str) -> None:
    (tmp_path / "sheet.toml").write_text(SHEET)
    done = taut("compare", tmp_path / "sheet.toml", "--out", tmp_path / "out", "--no-film", *arguments)
    assert (done.status, done.out) == (2, "")
    assert message in done.err
    assert done.err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["sheet.toml"]


def test_a_budget_must_be_positive(tmp_path: Path) -> None:
    (tmp_path / "sheet.toml").write_text(SHEET)
    for budget in (0.0, float("nan"), float("inf")):
        with pytest.raises(CompareError, match="budget = .*: must be above 0 seconds"):
            compare(Scene.load(tmp_path / "sheet.toml"), [], tmp_path / "out", Options(budget=budget))


def test_what_is_there_stays(taut: Command, compared: Path, tmp_path: Path) -> None:
    (tmp_path / "sheet.toml").write_text(SHEET)
    out = Path(shutil.copytree(compared, tmp_path / "out"))
    arguments = ["compare", tmp_path / "sheet.toml", "--out", out, "--filters", "none", "--frames", 3]
    arguments += ["--no-equal-stretch", "--no-film", "--quiet"]
    refused = taut(*arguments)
    assert refused.status == 2
    assert "exists already" in refused.err
    (out / "thesis.txt").write_text("precious")
    assert "holds 'thesis.txt'" in taut(*arguments, "--overwrite").err
    assert document(out) == document(compared)
    (out / "thesis.txt").unlink()
    assert taut(*arguments, "--overwrite").status == 0
    found = document(out)
    assert [run["frames"] for run in found["runs"]] == [3]
    assert found["equal_stretch"] == {"target": None, "budget": None}
    assert not (out / "film.mp4").exists()


def test_ctrl_c_keeps_the_methods_that_are_done(tmp_path: Path) -> None:
    (tmp_path / "sheet.toml").write_text(SHEET)
    scene = Scene.load(tmp_path / "sheet.toml")

    def stop_at(name: str, frame: int) -> Options:
        def watch(what: str, done: int, total: int, note: str) -> None:
            if (what, done) == (name, frame):
                raise KeyboardInterrupt

        return Options(Conditions(frames=4, threads=1, watch=watch), budget=None)

    methods = choose(["none", "sweeps"], ["euler"])
    with pytest.raises(KeyboardInterrupt):
        compare(scene, methods, tmp_path / "nothing", stop_at("none", 3))
    assert [path.name for path in tmp_path.iterdir()] == ["sheet.toml"]
    assert compare(scene, methods, tmp_path / "part", stop_at("sweeps", 3)).interrupted
    found = document(tmp_path / "part")
    assert found["interrupted"]
    assert [run["filter"] for run in found["runs"]] == ["none"]
    assert "Stopped before its end" in (tmp_path / "part" / "compare.md").read_text()


def test_a_method_that_blows_up_is_a_row(
    taut: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    step = Simulation.step

    def fragile(simulation: Simulation, n: int = 1) -> object:
        if simulation.time > 0.04:
            raise SimulationError("vertex 3 is not finite")
        return step(simulation, n)

    monkeypatch.setattr(Simulation, "step", fragile)
    (tmp_path / "free.toml").write_text(FREE)
    arguments = ["--out", tmp_path / "out", "--filters", "none", "--no-film", "--no-equal-stretch"]
    done = taut("compare", tmp_path / "free.toml", *arguments)
    assert done.status == 0, done.err
    (run,) = document(tmp_path / "out")["runs"]
    assert run["frames"] == 4
    assert run["ended"] == "frame 4: vertex 3 is not finite; frames 0 to 3 are kept"
    assert f"- `none` ended early: {run['ended']}" in (tmp_path / "out" / "compare.md").read_text()
