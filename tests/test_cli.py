import csv
import io
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import typer
from taut import Cache
from taut.cli.console import make_folder_of

Command = Callable[..., Any]


def test_run_ends_with_a_table(taut: Command, flag_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.zarr"
    done = taut("run", flag_file, "--out", out, "--frames", 12, "--threads", 2)
    assert done.status == 0
    assert "12/12" in done.err
    assert "worst stretch" in done.err
    cache = Cache.open(out)
    table = dict(line.split("  ", 1) for line in done.out.splitlines())
    worst = 100 * cache.diagnostics["worst_stretch"].max()
    assert table["worst stretch"].strip().startswith(f"{worst:.2f} % in flag, vertices ")
    assert "ms a frame" in table["speed"]
    assert "x real time (2 threads)" in table["speed"]
    assert "kinetic" in table["energy at the end"]
    assert f"of {11 * cache.attributes['substeps']}" in table["limited steps"]
    assert table["state hash"].strip() == cache.attributes["state_hash"]


def test_frames_come_from_the_duration(taut: Command, flag_file: Path, tmp_path: Path) -> None:
    done = taut("run", flag_file, "--out", tmp_path / "out.zarr", "--quiet", "--set", "duration=0.1")
    assert (done.status, done.out, done.err) == (0, "", "")
    assert Cache.open(tmp_path / "out.zarr").frames == 6


def test_set_changes_the_scene(taut: Command, flag_file: Path, tmp_path: Path) -> None:
    settings = ["--set", "solver.filter=none", "--set", "cloth.flag.strain_limit=0.1"]
    taut("run", flag_file, "--out", tmp_path / "out.zarr", "--frames", 2, *settings)
    scene = Cache.open(tmp_path / "out.zarr").scene
    assert scene["solver"]["filter"] == "none"
    assert scene["cloth"][0]["strain_limit"] == 0.1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "solver.filtr=none"], "scene.solver.filtr: no such field; did you mean `filter`?"),
        (["--set", "slover.filter=none"], "scene.slover: no such field; did you mean `solver`?"),
        (["--set", "cloth[3].density=1"], "[3] is out of range; there are 1"),
        (["--set", "duration=nan"], "scene.duration = nan: must be a finite number"),
        (["--set", "cloth[0].strain_limit=1.5"], "scene.cloth[0].strain_limit = 1.5: must be"),
        (["--resume", "--overwrite"], "give one of them"),
    ],
)
def test_bad_input_is_one_red_line(
    taut: Command, flag_file: Path, tmp_path: Path, arguments: list[str], message: str
) -> None:
    done = taut("run", flag_file, "--out", tmp_path / "out.zarr", *arguments)
    assert (done.status, done.out) == (2, "")
    assert done.err.startswith("error: ")
    assert message in done.err
    assert done.err.count("\n") == 1
    assert not (tmp_path / "out.zarr").exists()


def test_a_sandbox_reads_no_mesh_outside_of_the_folder(taut: Command, tmp_path: Path) -> None:
    (tmp_path / "scene").mkdir()
    (tmp_path / "sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    scene = tmp_path / "scene/mine.toml"
    scene.write_text('[[cloth]]\nmesh = "../sheet.obj"\nfabric = "cotton"\n')
    run = ["run", scene, "--frames", 1, "--quiet", "--out"]
    assert taut(*run, tmp_path / "own.zarr").status == 0
    refused = taut(*run, tmp_path / "other.zarr", "--sandbox")
    assert (refused.status, "leaves the scene's folder" in refused.err) == (2, True)


def test_warnings_are_shown(taut: Command, flag_file: Path, tmp_path: Path) -> None:
    heavy = ["--frames", 1, "--set", "cloth[0].fabric=silk", "--set", "cloth[0].density=1"]
    done = taut("run", flag_file, "--out", tmp_path / "a.zarr", *heavy)
    assert done.err.startswith("warning: ")
    assert "density" in done.err
    assert taut("run", flag_file, "--out", tmp_path / "b.zarr", *heavy, "--quiet").err == ""


def test_existing_output(taut: Command, flag_file: Path, copied: Path) -> None:
    refused = taut("run", flag_file, "--out", copied)
    assert refused.status == 2
    assert "exists already; go on with it (--resume), replace it (--overwrite)" in refused.err
    assert taut("run", flag_file, "--out", copied, "--frames", 3, "--overwrite").status == 0
    assert Cache.open(copied).frames == 3
    assert taut("run", flag_file, "--out", copied, "--resume").status == 0
    assert Cache.open(copied).frames == 30
    finished = taut("run", flag_file, "--out", copied, "--resume")
    assert finished.status == 0
    assert "was finished already: it has 30 frames" in finished.out
    other = taut("run", flag_file, "--out", copied, "--resume", "--set", "fps=50")
    assert other.status == 2
    assert "scene.fps is 60.0 in the cache and 50.0 now" in other.err


def test_a_repair_is_told(taut: Command, flag_file: Path, copied: Path) -> None:
    (copied / "positions/c.29.0.0").unlink()
    done = taut("run", flag_file, "--out", copied, "--resume")
    assert done.status == 0
    assert "frames 29 to 29 were damaged and are simulated again" in done.err


def test_a_blow_up_fails_on_the_way(taut: Command, flag_file: Path, tmp_path: Path) -> None:
    stiff = ["solver.substeps=1", "solver.force_step=true", "solver.filter=none", "cloth[0].stiffness=1e6"]
    settings = [part for setting in stiff for part in ("--set", setting)]
    done = taut("run", flag_file, "--out", tmp_path / "out.zarr", *settings, "--quiet")
    assert done.status == 1
    assert done.err.startswith("error: frame ")
    assert json.loads(taut("info", tmp_path / "out.zarr", "--json").out)["frames"] >= 1


def test_a_full_disk_fails_on_the_way(
    taut: Command, flag_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr("os.fsync", full)
    done = taut("run", flag_file, "--out", tmp_path / "out.zarr")
    assert done.status == 1
    assert "No space left on device; free some space or delete some files; no frame is kept" in done.err
    assert os.listdir(tmp_path) == ["flag.toml"]


def test_tracebacks_on_demand(taut: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TAUT_TRACEBACK", "1")
    with pytest.raises(ValueError, match="there is no cache"):
        taut("info", tmp_path / "gone.zarr")


def test_info_as_json(taut: Command, recorded: Path) -> None:
    numbers = json.loads(taut("info", recorded, "--json").out)
    cache = Cache.open(recorded)
    stretch = np.array([cache.stretch(frame) for frame in range(cache.frames)])
    # Several springs are at the limit, but for rounding.
    frame, spring = numbers["worst_frame"], numbers["worst_spring"]
    assert stretch[frame, spring] == pytest.approx(stretch.max(), abs=1e-6)
    assert numbers["worst_stretch"] == pytest.approx(stretch.max(), abs=1e-6)
    assert numbers["worst_vertices"] == cache.springs[spring].tolist()
    assert numbers["worst_stretch_in_steps"] >= numbers["worst_stretch"]
    assert numbers["ms_per_frame"] == pytest.approx(np.median(cache.diagnostics["ms"][1:]))
    assert numbers["limited_steps"] == cache.diagnostics["limited_steps"].sum()
    expected = {
        "frames": 30,
        "vertices": 35,
        "springs": len(cache.springs),
        "limit": 0.04,
        "title": "Small flag",
    }
    assert {name: numbers[name] for name in expected} == expected
    for name in ("state_hash", "threads", "version", "substeps", "step_length"):
        assert numbers[name] == cache.attributes[name]
    assert numbers["duration"] == pytest.approx(29 / 60)


def test_info_as_csv_has_a_line_a_frame(taut: Command, recorded: Path) -> None:
    names, *rows = csv.reader(io.StringIO(taut("info", recorded, "--csv").out))
    cache = Cache.open(recorded)
    assert names == ["frame", "time", *cache.diagnostics]
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    np.testing.assert_array_equal(np.array(columns["frame"], int), np.arange(30))
    np.testing.assert_array_equal(np.array(columns["time"], float), cache.time)
    np.testing.assert_array_equal(
        np.array(columns["worst_stretch"], float), cache.diagnostics["worst_stretch"]
    )
    assert [int(number) for number in columns["state_hash"]] == cache.diagnostics["state_hash"].tolist()
    assert taut("info", recorded, "--csv", "--json").status == 2


def test_a_run_takes_the_name_of_its_scene(
    taut: Command, flag_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    done = taut("run", flag_file, "--frames", 1)
    assert (done.status, done.out.split()[-2:]) == (0, ["written", "flag.zarr"])
    assert Cache.open("flag.zarr").frames == 1
    assert taut("run", "chain", "--frames", 1, "--quiet").status == 0
    assert Cache.open("chain.zarr").frames == 1


@pytest.mark.parametrize(
    "command",
    [
        ["run", "--frames", 1, "--quiet", "flag.toml", "--out", "made/deep/a.zarr"],
        ["export", "flag.zarr", "--to", "obj", "--out", "made/deep/a"],
        ["render", "flag.zarr", "--out", "made/deep/a.png"],
    ],
)
def test_a_folder_that_is_missing_is_not_made_unasked(
    taut: Command, copied: Path, command: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from tests.conftest import FLAG

    monkeypatch.chdir(copied.parent)
    Path("flag.toml").write_text(FLAG)
    done = taut(*command)
    assert done.status == 2
    assert "there is no folder made/deep; make it, or let --yes make it" in done.err
    assert not Path("made").exists()
    if command[0] != "render":
        assert taut(*command, "--yes").status == 0
        assert len(list(Path("made/deep").iterdir())) == 1


@pytest.mark.parametrize("answer", ["y", "n"])
def test_at_a_terminal_a_missing_folder_is_asked_about(
    tmp_path: Path, answer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def confirm(text: str, **options: Any) -> None:
        asked.append(text)
        if answer == "n":
            raise typer.Abort

    monkeypatch.setattr("taut.cli.console.sys.stdin", SimpleNamespace(isatty=lambda: True))
    monkeypatch.setattr("taut.cli.console.sys.stderr", SimpleNamespace(isatty=lambda: True))
    monkeypatch.setattr(typer, "confirm", confirm)
    with nullcontext() if answer == "y" else pytest.raises(typer.Abort):
        make_folder_of(tmp_path / "new" / "a.zarr", yes=False)
    assert asked == [f"There is no folder {tmp_path / 'new'}. Make it?"]
    assert (tmp_path / "new").is_dir() == (answer == "y")


def test_info_of_one_frame_of_a_net(taut: Command, tmp_path: Path) -> None:
    path = tmp_path / "points.toml"
    path.write_text(
        "[[cloth]]\nnetwork = { points = [[0, 0, 0], [1, 0, 0]], links = [[0, 1]], mass = 0.1 }\n"
    )
    assert taut("run", path, "--out", tmp_path / "out.zarr", "--frames", 1).status == 0
    numbers = json.loads(taut("info", tmp_path / "out.zarr", "--json").out)
    assert (numbers["frames"], numbers["springs"], numbers["ms_per_frame"]) == (1, 1, None)
    assert "nothing was simulated" in taut("info", tmp_path / "out.zarr").out


def test_info_as_a_table(taut: Command, recorded: Path) -> None:
    table = taut("info", recorded).out
    for word in ("Small flag", "30, 0.483 s", "35", "4.00 %", "worst stretch", "state hash"):
        assert word in table


@pytest.mark.parametrize("command", ["info", "render", "export"])
def test_a_missing_cache(taut: Command, tmp_path: Path, command: str) -> None:
    more = {"info": [], "render": ["--out", "a.png"], "export": ["--to", "obj", "--out", "a"]}[command]
    done = taut(command, tmp_path / "gone.zarr", *more)
    assert (done.status, done.err) == (2, f"error: there is no cache {tmp_path / 'gone.zarr'}\n")


def test_a_cache_that_is_meant_but_not_there(taut: Command, copied: Path, flag_file: Path) -> None:
    near = taut("info", copied.parent / "falg.zarr")
    assert (near.status, "; did you mean flag.zarr?" in near.err) == (2, True)
    scene = taut("info", flag_file)
    assert f"a scene is run first: taut run {flag_file} --out flag.zarr" in scene.err
    shipped = taut("render", "curtain", "--out", "a.png")
    assert shipped.err == (
        "error: there is no cache curtain; a scene is run first: taut run curtain --out curtain.zarr\n"
    )


def test_export(taut: Command, recorded: Path, tmp_path: Path) -> None:
    for kind in ("obj", "pc2", "ply"):
        out = tmp_path / kind
        assert taut("export", recorded, "--to", kind, "--out", out).status == 0
        assert out.exists()
        again = taut("export", recorded, "--to", kind, "--out", out)
        assert again.status == 2
        assert "exists already" in again.err
        assert taut("export", recorded, "--to", kind, "--out", out, "--overwrite").status == 0
    assert (tmp_path / "pc2").stat().st_size == 32 + 30 * 35 * 12
    assert taut("export", recorded, "--to", "abc", "--out", tmp_path / "x").status == 2


def test_render(taut: Command, recorded: Path, tmp_path: Path) -> None:
    still = tmp_path / "still.png"
    assert taut("render", recorded, recorded, "--out", still, "--frame", 3, "--color", "fabric").status == 0
    assert still.read_bytes().startswith(b"\x89PNG")
    assert taut("render", recorded, "--out", still).status == 2
    assert "out of range" in taut("render", recorded, "--out", tmp_path / "b.png", "--frame", 30).err
    film = taut("render", recorded, "--out", tmp_path / "film.mp4", "--frame", 3)
    assert film.status == 2
    assert "--frame 3 chooses a frame for a still" in film.err


def test_schema(taut: Command) -> None:
    schema = json.loads(taut("schema").out)
    assert {"title", "duration", "fps", "cloth", "solver", "wind"} <= schema["properties"].keys()


def test_help_and_version_are_quick_to_load() -> None:
    heavy = "('zarr', 'pyvista', 'trimesh', 'numpy')"
    code = f"import sys, taut, taut.cli.app; print([name for name in {heavy} if name in sys.modules])"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "[]"
    shown = subprocess.check_output([sys.executable, "-m", "taut", "--help"], text=True)
    assert all(command in shown for command in ("run", "render", "export", "info", "schema"))
    version = subprocess.check_output([sys.executable, "-m", "taut", "--version"], text=True)
    assert version.startswith("taut ")


def test_ctrl_c_keeps_the_frames(flag_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.zarr"
    arguments = ["run", flag_file, "--out", out, "--frames", 100_000]
    process = subprocess.Popen(
        [sys.executable, "-m", "taut", *map(str, arguments)], stderr=subprocess.PIPE, text=True
    )
    limit = time.monotonic() + 60
    while time.monotonic() < limit and (not out.exists() or Cache.open(out).frames < 3):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "has all frames so far: the same command with --resume goes on" in err
    assert "Traceback" not in err
    cache = Cache.open(out)
    assert cache.frames >= 3
    assert cache.is_whole(cache.frames - 1)


STAR = """\
duration = 0.5
[[cloth]]
strain_limit = 0.05
pins = [
    { vertices = [1], move = [[0.4, [0.09, 0, 0]]] },
    { vertices = [2], move = [[0.4, [-0.045, 0.078, 0]]] },
    { vertices = [3], move = [[0.4, [-0.045, -0.078, 0]]] },
]
[cloth.network]
points = [[0, 0, 0], [1, 0, 0], [-0.5, 0.866, 0], [-0.5, -0.866, 0]]
links = [[0, 1], [0, 2], [0, 3]]
"""


def test_pins_that_the_cloth_cannot_follow_are_named_in_the_summary(taut: Command, tmp_path: Path) -> None:
    (tmp_path / "star.toml").write_text(STAR)
    done = taut("run", tmp_path / "star.toml", "--out", tmp_path / "star.zarr")
    held_back = json.loads(taut("info", tmp_path / "star.zarr", "--json").out)["held_back_pins"]
    assert held_back > 10
    assert f"{held_back} shortened by the certificate ({held_back} times with pins held back)" in " ".join(
        done.out.split()
    )
