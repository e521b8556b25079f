import json
import multiprocessing
import random
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr
from taut import Cache, CacheError, Scene, Simulation, SimulationError, _taut, record
from taut.cache import metadata
from taut.cli import main
from taut.run import Recording
from taut.scene import find_scene

FRAMES = 1500
KILLS = 30


def run(flag: dict[str, Any], out: Path, frames: int | None = None, resume: bool = True) -> Recording:
    return record(Simulation(Scene(flag)), out, frames, existing="resume" if resume else "refuse")


def test_a_resumed_run_ends_like_an_uninterrupted_one(
    tmp_path: Path, recorded: Path, flag: dict[str, Any]
) -> None:
    out = tmp_path / "out.zarr"
    assert run(flag, out, 7).resumed_at is None
    assert run(flag, out, 8).resumed_at == 7
    done = run(flag, out)
    assert (done.resumed_at, done.frames, done.notes) == (8, 30, [])
    mine, whole = Cache.open(out), Cache.open(recorded)
    for name in ("state_hash", "worst_stretch", "limited_steps", "sweeps", "kinetic_energy"):
        np.testing.assert_array_equal(mine.diagnostics[name], whole.diagnostics[name])
    np.testing.assert_array_equal(mine.time, whole.time)


@pytest.mark.parametrize("frames", [None, 10])
def test_resuming_a_finished_run_changes_nothing(
    copied: Path, flag: dict[str, Any], frames: int | None
) -> None:
    before = {path: path.read_bytes() for path in copied.rglob("*") if path.is_file()}
    done = run(flag, copied, frames)
    assert (done.resumed_at, done.frames) == (30, 30)
    assert {path: path.read_bytes() for path in copied.rglob("*") if path.is_file()} == before


def test_title_duration_and_threads_may_change(copied: Path, flag: dict[str, Any]) -> None:
    flag |= {"title": "Longer", "duration": 0.6}
    done = record(Simulation(Scene(flag), threads=3), copied, existing="resume")
    cache = Cache.open(copied)
    assert (done.frames, cache.title, cache.scene["duration"], cache.attributes["threads"]) == (
        36,
        "Longer",
        0.6,
        3,
    )


def test_another_scene_is_refused(copied: Path, flag: dict[str, Any]) -> None:
    def refused(settings: list[str], difference: str) -> None:
        simulation = Simulation(Scene(flag).with_settings(settings))
        with pytest.raises(CacheError, match=f"belongs to another scene: {difference}; undo that change"):
            record(simulation, copied, existing="resume")

    before = (copied / "zarr.json").read_bytes()
    refused(["solver.filter=none"], r"scene.solver.filter is 'coarse_to_fine' in the cache and 'none' now")
    refused(["wind.velocity=[8.0, 2, 0]"], r"scene.wind.velocity\[1\] is 1.5 in the cache and 2.0 now")
    refused(["cloth.flag.pins=[]"], r"scene.cloth\[0\].pins is \[.*\] in the cache and \[\] now")
    refused(["wind.gust.strength=0.3"], r"scene.wind.gust is not given in the cache and .* now")
    assert (copied / "zarr.json").read_bytes() == before


def test_another_mesh_is_refused(tmp_path: Path) -> None:
    document = {"cloth": [{"mesh": "shirt", "pins": [{"vertices": [0]}]}]}
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    for faces in ([[0, 1, 2, 3]], [[0, 1, 2], [0, 2, 3]]):
        simulation = Simulation(Scene(document, meshes={"shirt": (square, faces)}))
        if len(faces) == 1:
            record(simulation, tmp_path / "out.zarr", 2)
            continue
        with pytest.raises(CacheError, match="the geometry of shirt differs"):
            record(simulation, tmp_path / "out.zarr", 3, existing="resume")


def test_another_version_is_refused(copied: Path, flag: dict[str, Any]) -> None:
    root = json.loads((copied / "zarr.json").read_bytes())
    root["attributes"]["version"] = "0.0.1"
    (copied / "zarr.json").write_bytes(metadata.encoded(root))
    with pytest.raises(CacheError, match=rf"was written by taut 0.0.1; this is {_taut.__version__}"):
        run(flag, copied)


def test_damaged_last_frames_are_simulated_again(copied: Path, recorded: Path, flag: dict[str, Any]) -> None:
    (copied / "positions/c.29.0.0").write_bytes(b"")
    (copied / "velocities/c.28.0.0").unlink()
    (copied / "positions/c.27.0.0").write_bytes((copied / "positions/c.26.0.0").read_bytes())
    done = run(flag, copied)
    assert done.resumed_at == 27
    assert done.notes == [f"{copied}: frames 27 to 29 were damaged and are simulated again"]
    mine, whole = Cache.open(copied), Cache.open(recorded)
    assert all(mine.is_whole(frame) for frame in range(30))
    assert mine.attributes["state_hash"] == whole.attributes["state_hash"]


def test_a_repair_alone_leaves_a_good_cache(copied: Path, flag: dict[str, Any]) -> None:
    (copied / "positions/c.29.0.0").unlink()
    done = run(flag, copied, frames=5)
    cache = Cache.open(copied)
    assert (done.frames, cache.frames) == (29, 29)
    assert int(cache.attributes["state_hash"], 16) == cache.diagnostics["state_hash"][28]


def test_a_cache_without_a_whole_frame_is_refused(copied: Path, flag: dict[str, Any]) -> None:
    for path in copied.glob("positions/c.*"):
        path.unlink()
    with pytest.raises(CacheError, match="no frame in it is whole; run it again"):
        run(flag, copied)


def test_damaged_constants_are_refused(copied: Path, flag: dict[str, Any]) -> None:
    root = zarr.open_group(copied, mode="r+")
    root["springs"][3] = [0, 1]
    with pytest.raises(CacheError, match="springs/c.* differs from its checksum"):
        run(flag, copied)
    (copied / "springs/c.0.0").unlink()
    with pytest.raises(CacheError, match=r"springs/c.0.0 is missing; run it again \(--overwrite\)"):
        run(flag, copied)


@pytest.mark.parametrize("name", ["diagnostics/sweeps", "diagnostics/state_hash", "time", "origins"])
def test_damaged_numbers_are_not_written_over(copied: Path, flag: dict[str, Any], name: str) -> None:
    flag["duration"] = 0.6
    chunk = next((copied / name).glob("c.*"))
    chunk.unlink()
    with pytest.raises(CacheError, match="is missing; run it again|no frame in it is whole"):
        run(flag, copied)
    assert not chunk.exists()


def test_the_metadata_of_single_arrays_are_written_anew(copied: Path, flag: dict[str, Any]) -> None:
    file = copied / "velocities/zarr.json"
    before = json.loads(file.read_bytes())
    file.write_text("{")
    flag["duration"] = 0.6
    assert run(flag, copied).frames == 36
    assert json.loads(file.read_bytes()) == before | {"shape": [36, 35, 3]}


def test_what_is_no_cache_is_not_resumed(tmp_path: Path, flag: dict[str, Any]) -> None:
    with pytest.raises(CacheError, match="is no Zarr group"):
        run(flag, tmp_path)


def test_a_blow_up_keeps_the_frames_before_it(tmp_path: Path, flag: dict[str, Any]) -> None:
    flag["solver"] = {"substeps": 1, "force_step": True, "filter": "none"}
    flag["cloth"][0]["stiffness"] = 1e6
    with pytest.raises(SimulationError, match=r"^frame \d+: .*; frames 0 to \d+ are kept$") as error:
        run(flag, tmp_path / "out.zarr")
    cache = Cache.open(tmp_path / "out.zarr")
    assert str(error.value).startswith(f"frame {cache.frames}: ")
    assert all(cache.is_whole(frame) for frame in range(cache.frames))


def test_an_exception_of_the_watcher_loses_no_frame(tmp_path: Path, flag: dict[str, Any]) -> None:
    def stop(now: Any) -> None:
        if now.frame == 9:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        record(Simulation(Scene(flag)), tmp_path / "out.zarr", on_frame=stop)
    assert Cache.open(tmp_path / "out.zarr").frames == 10


def command(scene: Path, out: Path, frames: int = FRAMES) -> list[str]:
    arguments = ["run", scene, "--out", out, "--frames", frames, "--resume", "--quiet"]
    return [sys.executable, "-m", "taut", *map(str, arguments)]


def whole_frames(out: Path) -> int:
    """Frames that plain Zarr sees, each checked against its hash; both ways to open a group."""
    counts = []
    for consolidated in (True, False):
        root = zarr.open_group(out, mode="r", use_consolidated=consolidated)
        positions, velocities, past = (
            np.asarray(root[name][...]) for name in ("positions", "velocities", "past")
        )
        hashes = root["diagnostics/state_hash"][...]
        for index, state in enumerate(positions):
            assert int(_taut.state_hash(state, velocities[index], past[index]), 16) == hashes[index]
        if consolidated:
            assert int(root.attrs["state_hash"], 16) == hashes[len(positions) - 1]
        counts.append(len(positions))
    return counts[0]


@pytest.mark.slow
def test_killed_thirty_times_it_ends_the_same(
    tmp_path: Path, flag_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, seen, moments = tmp_path / "killed.zarr", 0, random.Random(1)
    # Runs are forked from a process that has loaded what they need: so kills strike runs and not imports.
    server = multiprocessing.get_context("forkserver")
    server.set_forkserver_preload(["taut.cli.app", "taut.run"])
    monkeypatch.setattr(sys, "argv", command(flag_file, out)[2:])
    for kill in range(KILLS):
        process = server.Process(target=main)
        process.start()
        # Half of the kills strike at any time from the start, half once the run has written again.
        before, limit = seen, time.monotonic() + 30
        while kill % 2 and seen == before and process.is_alive() and time.monotonic() < limit:
            time.sleep(0.01)
            seen = Cache.open(out).frames if out.exists() else 0
        time.sleep(moments.uniform(0.0, 0.3))
        process.kill()
        process.join()
        if out.exists():
            found = whole_frames(out)
            assert found >= seen
            seen = found
    assert 1 < seen < FRAMES, "the kills must strike a run in progress"
    straight, frames = tmp_path / "straight.zarr", seen + 30
    assert subprocess.run(command(flag_file, out, frames)).returncode == 0
    assert whole_frames(out) == frames
    assert subprocess.run(command(flag_file, straight, frames)).returncode == 0
    mine, whole = Cache.open(out), Cache.open(straight)
    np.testing.assert_array_equal(mine.diagnostics["state_hash"], whole.diagnostics["state_hash"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["flag.toml", "killed.zarr", "straight.zarr"]
    assert {path.name for path in out.rglob("*.partial")} == set()


def test_a_past_of_another_version_is_refused_with_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene.load(find_scene("ball"))
    record(Simulation(scene), tmp_path / "out.zarr", 2)
    monkeypatch.setattr(Simulation, "past", np.zeros((7, 3), np.float32))
    with pytest.raises(CacheError, match="past, this version needs 7: .*start anew with --overwrite"):
        record(Simulation(scene), tmp_path / "out.zarr", 4, existing="resume")
    assert Cache.open(tmp_path / "out.zarr").frames == 2
