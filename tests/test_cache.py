import errno
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from taut import Cache, CacheError, CacheWriteError, Report, Scene, Simulation, _taut, record
from taut.cache import CacheWriter, Frame, Header, metadata, summarize
from taut.cache.store import UNFINISHED, DurableFolder


def header(vertices: int = 2, **changes: Any) -> Header:
    attributes: dict[str, Any] = {
        "version": "1.0",
        "scene": {"title": "t", "duration": 1.0, "fps": 60.0, "solver": {"filter": "none"}, "list": [1, 2]},
        "title": "t",
        "warnings": [],
        "cloths": [{"name": "c", "first_vertex": 0, "vertices": vertices}],
        "substeps": 2,
        "step_length": 1 / 120,
        "threads": 1,
        "meshes": {"a.obj": "00"},
    }
    constant = {
        "faces": np.zeros((0, 3)),
        "springs": np.array([[0, 1]]),
        "spring_kind": np.array([0]),
        "rest_length": np.array([1.0]),
        "strain_limit": np.array([np.inf]),
        "pins": np.zeros(0),
    }
    return Header(attributes | changes, constant, vertices)


def frame(index: int, positions: Any = None, vertices: int = 2, **numbers: Any) -> Frame:
    x = np.full((vertices, 3), index, np.float32) if positions is None else np.asarray(positions, np.float32)
    v = np.full((vertices, 3), -index, np.float32)
    report = {
        name: numbers.get(name, index)
        for name in Report.__dataclass_fields__
        if name not in ("time", "worst_spring", "worst_spring_in_steps")
    }
    full = Report(time=index / 60, worst_spring=0, worst_spring_in_steps=0, **report)
    return Frame(x, v, full, ms=float(index), state_hash=_taut.state_hash(x, v))


def write(path: Path, frames: int) -> None:
    with CacheWriter.create(path, header(), frame(0)) as writer:
        for index in range(1, frames):
            writer.append(frame(index))


def flip(path: Path, at: int = 20) -> None:
    data = bytearray(path.read_bytes())
    data[at] ^= 0xFF
    path.write_bytes(data)


def everything_below(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


@pytest.mark.parametrize("consolidated", [True, False])
def test_plain_zarr_reads_what_the_contract_says(recorded: Path, consolidated: bool) -> None:
    root = zarr.open_group(recorded, mode="r", use_consolidated=consolidated)
    positions, springs = np.asarray(root["positions"][...]), np.asarray(root["springs"][...])
    rest_length = np.asarray(root["rest_length"][...])
    assert (positions.shape, positions.dtype) == ((30, 35, 3), np.float32)
    assert root["positions"].chunks == root["velocities"].chunks == (1, 35, 3)
    assert (root["velocities"].shape, root["velocities"].dtype) == ((30, 35, 3), np.float32)
    kinds = {name: (str(root[name].dtype), root[name].ndim) for name in ("time", "faces", "springs", "pins")}
    assert kinds == {
        "time": ("float64", 1),
        "faces": ("int32", 2),
        "springs": ("int32", 2),
        "pins": ("int32", 1),
    }
    np.testing.assert_allclose(root["time"][...], np.arange(30) / 60, atol=1e-12)
    assert root["faces"][...].max() < 35
    assert root["strain_limit"][...] == pytest.approx(0.04)

    ends = positions.astype(np.float64)[:, springs]
    stretch = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2) / rest_length - 1
    diagnostics = root["diagnostics"]
    np.testing.assert_allclose(diagnostics["worst_stretch"][...], stretch.max(axis=1), atol=1e-6)
    where = diagnostics["worst_spring"][...]
    np.testing.assert_allclose(stretch[np.arange(30), where], stretch.max(axis=1), atol=1e-6)
    assert (diagnostics["worst_stretch_in_steps"][1:] >= diagnostics["worst_stretch"][1:]).all()
    assert diagnostics["ms"][0] == 0
    assert (diagnostics["ms"][1:] > 0).all()

    assert (root["past"].shape, root["past"].dtype) == ((30, 36, 3), np.float32)
    hashes = [_taut.state_hash(positions[i], root["velocities"][i], root["past"][i]) for i in range(30)]
    assert [f"{int(value):016x}" for value in diagnostics["state_hash"][...]] == hashes
    attributes = dict(root.attrs)
    assert attributes["state_hash"] == hashes[-1]
    assert attributes["format"] == "taut-cache/4"
    assert attributes["version"] == _taut.__version__
    assert attributes["cloths"] == [{"name": "flag", "first_vertex": 0, "vertices": 35}]
    assert Scene(attributes["scene"]).document == attributes["scene"]


def test_the_reader_agrees_with_the_simulation(recorded: Path, flag: dict[str, Any]) -> None:
    cache, simulation = Cache.open(recorded), Simulation(Scene(flag))
    for index in range(5):
        np.testing.assert_array_equal(cache.positions(index), simulation.positions)
        np.testing.assert_array_equal(cache.velocities(index), simulation.velocities)
        assert cache.stretch(index).max(initial=-1) == pytest.approx(
            simulation.report.worst_stretch, abs=1e-6
        )
        simulation.run(1)
    assert (cache.frames, cache.vertices, cache.title, cache.path) == (30, 35, "Small flag", recorded)
    assert set(cache.pins) == set(np.flatnonzero(simulation.pinned))
    np.testing.assert_array_equal(cache.positions(-1), cache.positions(29))
    assert all(cache.is_whole(index) for index in range(30))
    for index in (30, -31):
        with pytest.raises(IndexError, match="there are frames 0 to 29"):
            cache.positions(index)


def test_positions_are_an_array_of_all_frames(recorded: Path) -> None:
    cache = Cache.open(recorded)
    everything = np.stack([cache.positions(frame) for frame in range(30)])
    series = cache.positions
    assert (series.shape, series.dtype, series.ndim, len(series)) == ((30, 35, 3), np.float32, 3, 30)
    np.testing.assert_array_equal(np.asarray(series), everything)
    assert np.asarray(series, np.float64).dtype == np.float64
    np.testing.assert_array_equal(cache.velocities[7], cache.velocities(7))
    keys: list[Any] = [
        3,
        -1,
        (2, 5),
        (np.int64(2), slice(None), 1),
        slice(4, 20, 3),
        (slice(None), 7),
        (slice(None, None, -1), [1, 2], 0),
        [5, 1, -1],
        everything[:, 0, 0] > 0.0,
        ...,
        (..., 2),
    ]
    for key in keys:
        np.testing.assert_array_equal(series[key], everything[key], strict=True)
    for bad in (30, -31, [30], (0, 35), None):
        with pytest.raises(IndexError):
            series[bad]


def test_the_summary_comes_from_the_frames(recorded: Path) -> None:
    cache = Cache.open(recorded)
    summary = summarize(cache)
    worst = [float(cache.stretch(index).max()) for index in range(30)]
    assert summary.worst_stretch == pytest.approx(max(worst), abs=1e-6)
    # Several frames are at the limit, but for rounding.
    assert worst[summary.worst_frame] == pytest.approx(max(worst), abs=1e-6)
    assert tuple(cache.springs[summary.worst_spring]) == summary.worst_vertices
    assert (summary.worst_cloth, summary.limit, summary.frames, summary.vertices) == ("flag", 0.04, 30, 35)
    assert summary.ms_per_frame == pytest.approx(np.median(cache.diagnostics["ms"][1:]))
    assert summary.state_hash == cache.attributes["state_hash"]


@given(
    states=st.lists(
        arrays.arrays(
            np.float32, (2, 3), elements=st.floats(allow_nan=False, allow_infinity=False, width=32)
        ),
        min_size=1,
        max_size=5,
    ),
    number=st.floats(allow_nan=False),
    commits=st.lists(st.booleans(), min_size=5, max_size=5),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=15, deadline=None)
def test_what_is_written_is_read(
    tmp_path: Path, states: list[Any], number: float, commits: list[bool]
) -> None:
    path = tmp_path / "out.zarr"
    shutil.rmtree(path, ignore_errors=True)
    frames = [frame(index, state, worst_stretch=number) for index, state in enumerate(states)]
    with CacheWriter.create(path, header(), frames[0]) as writer:
        for item, commit in zip(frames[1:], commits, strict=False):
            writer.append(item)
            if commit:
                writer.commit()
    cache = Cache.open(path)
    assert cache.frames == len(frames)
    for index, item in enumerate(frames):
        assert cache.positions(index).tobytes() == item.positions.tobytes()
        assert cache.velocities(index).tobytes() == item.velocities.tobytes()
        assert cache.diagnostics["worst_stretch"][index] == number
        assert f"{cache.diagnostics['state_hash'][index]:016x}" == item.state_hash


def test_more_frames_than_a_chunk_of_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taut.cache.layout.SERIES_CHUNK", 4)
    write(tmp_path / "out.zarr", 11)
    cache = Cache.open(tmp_path / "out.zarr")
    np.testing.assert_array_equal(cache.diagnostics["sweeps"], np.arange(11))


def test_frames_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    with CacheWriter.create(tmp_path / "out.zarr", header(), frame(0)) as writer:
        with pytest.raises(ValueError, match="finite and of shape"):
            writer.append(frame(1, vertices=1))
        with pytest.raises(ValueError, match="finite and of shape"):
            writer.append(frame(1, [[0, 0, 0], [0, np.nan, 0]]))
    assert Cache.open(tmp_path / "out.zarr").frames == 1


class TestPlace:
    def test_existing_output_is_refused(self, copied: Path) -> None:
        before = everything_below(copied)
        with pytest.raises(CacheError, match="exists already; go on with it .* or take another name"):
            CacheWriter.create(copied, header(), frame(0))
        assert everything_below(copied) == before

    def test_a_cache_is_overwritten_on_demand(self, copied: Path) -> None:
        with CacheWriter.create(copied, header(), frame(0), overwrite=True):
            pass
        assert Cache.open(copied).title == "t"
        assert os.listdir(copied.parent) == [copied.name]

    def test_nothing_but_a_cache_is_overwritten(self, tmp_path: Path) -> None:
        folder = tmp_path / "home"
        folder.mkdir()
        (folder / "letter.txt").write_text("dear")
        for path in (folder, folder / "letter.txt"):
            with pytest.raises(CacheError, match="is no cache, so it is not overwritten"):
                CacheWriter.create(path, header(), frame(0), overwrite=True)
        assert (folder / "letter.txt").read_text() == "dear"

    def test_two_writers_are_refused(self, tmp_path: Path) -> None:
        path = tmp_path / "out.zarr"
        with CacheWriter.create(path, header(), frame(0)) as writer:
            with pytest.raises(CacheError, match="is being written by another run"):
                CacheWriter.resume(path, header())
            with pytest.raises(CacheError, match="is being written by another run"):
                CacheWriter.create(path, header(), frame(0), overwrite=True)
            writer.append(frame(1))
        with CacheWriter.resume(path, header()) as writer:
            assert writer.frames == 2
        assert os.listdir(tmp_path) == ["out.zarr"]

    def test_folders_above_are_made(self, tmp_path: Path) -> None:
        write(tmp_path / "a/b/out.zarr", 1)
        assert Cache.open(tmp_path / "a/b/out.zarr").frames == 1

    def test_a_folder_that_cannot_be_written_is_named(self, tmp_path: Path) -> None:
        (tmp_path / "file").write_text("")
        with pytest.raises(CacheWriteError, match="cannot write .*file.*; .*nothing was left behind"):
            write(tmp_path / "file/out.zarr", 1)


class TestDamage:
    def test_a_damaged_frame_is_named(self, copied: Path) -> None:
        flip(copied / "positions/c.7.0.0")
        (copied / "velocities/c.8.0.0").unlink()
        cache = Cache.open(copied)
        with pytest.raises(CacheError, match=r"positions/c.7.0.0, frame 7, is damaged \(.*checksum.*; run"):
            cache.positions(7)
        with pytest.raises(CacheError, match=r"velocities/c.8.0.0, frame 8, is missing; run it again"):
            cache.velocities(8)
        assert [cache.is_whole(index) for index in (6, 7, 8, 9)] == [True, False, False, True]

    def test_a_swapped_frame_is_seen(self, copied: Path) -> None:
        shutil.copy(copied / "positions/c.3.0.0", copied / "positions/c.4.0.0")
        assert not Cache.open(copied).is_whole(4)

    def test_missing_numbers_are_seen(self, copied: Path) -> None:
        (copied / "diagnostics/worst_stretch/c.0").unlink()
        with pytest.raises(CacheError, match="worst_stretch/c.0, frames 0 to 29, is missing"):
            _ = Cache.open(copied).diagnostics

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (lambda root: root["attributes"].pop("format"), "its format is None"),
            (
                lambda root: root["attributes"].update(format="taut-cache/9"),
                "'taut-cache/9', not 'taut-cache/4'",
            ),
            (lambda root: root["attributes"].pop("checksum"), "differs from its checksum"),
            (lambda root: root["attributes"].update(title="Large flag"), "differs from its checksum"),
            (lambda root: root["attributes"].pop("scene"), "the attribute scene is missing"),
            (lambda root: root["attributes"].update(cloths=3), "the attribute cloths is missing or no list"),
            (lambda root: root.clear(), "is no cache"),
            (lambda root: root.update(attributes=[]), "is no cache"),
            (lambda root: root.pop("consolidated_metadata"), "does not name its arrays"),
            (lambda root: nodes(root).pop("springs"), "the array springs is missing"),
            (
                lambda root: nodes(root)["springs"].update(data_type="float32"),
                "springs is missing or of another",
            ),
            (lambda root: nodes(root)["positions"].update(shape=[30, 35]), "damaged|of another type"),
            (lambda root: nodes(root)["velocities"].update(shape=[30, 34, 3]), "unlike shapes"),
            (lambda root: nodes(root)["time"].update(shape=[0]), "there is no frame"),
        ],
    )
    def test_damaged_structure_is_one_clear_error(
        self, copied: Path, change: Callable[[dict[str, Any]], object], message: str
    ) -> None:
        root = json.loads((copied / "zarr.json").read_bytes())
        change(root)
        sealed = "differs" not in message and root.get("attributes")
        (copied / "zarr.json").write_bytes(metadata.encoded(root) if sealed else json.dumps(root).encode())
        with pytest.raises(CacheError, match=message):
            Cache.open(copied)

    def test_other_indices_are_seen(self, copied: Path) -> None:
        root = zarr.open_group(copied, mode="r+")
        root["springs"][3] = [0, 35]
        root["faces"][3] = [0, 1, -1]
        cache = Cache.open(copied)
        for name in ("springs", "faces"):
            with pytest.raises(CacheError, match=f"{name}/c.* differs from its checksum"):
                getattr(cache, name)

    def test_what_is_no_cache(self, tmp_path: Path) -> None:
        with pytest.raises(CacheError, match="there is no cache"):
            Cache.open(tmp_path / "gone.zarr")
        with pytest.raises(CacheError, match="is no Zarr group"):
            Cache.open(tmp_path)
        (tmp_path / "file").write_text("x")
        with pytest.raises(CacheError, match="is no Zarr group"):
            Cache.open(tmp_path / "file")
        (tmp_path / "zarr.json").write_text("{")
        with pytest.raises(CacheError, match="zarr.json is damaged"):
            Cache.open(tmp_path)


def nodes(root: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = root["consolidated_metadata"]["metadata"]
    return found


class Killed(BaseException):
    """Stands for the end of the process: nothing is written or cleaned up any more."""


def write_until(path: Path, failure: BaseException, writes: int, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Write four frames, each committed; after some writes all others fail. Whether it was finished."""
    real, count = DurableFolder.write, 0

    def failing(store: DurableFolder, key: str, value: bytes) -> None:
        nonlocal count
        count += 1
        if count > writes:
            if isinstance(failure, Killed):
                (store.root / f".half{UNFINISHED}").write_bytes(value[: len(value) // 2])
            raise failure
        real(store, key, value)

    with monkeypatch.context() as patch:
        patch.setattr(DurableFolder, "write", failing)
        if isinstance(failure, Killed):
            clear = shutil.rmtree
            patch.setattr(
                shutil, "rmtree", lambda path, **how: None if count > writes else clear(path, **how)
            )
        try:
            with CacheWriter.create(path, header(), frame(0)) as writer:
                for index in range(1, 4):
                    writer.append(frame(index))
                    writer.commit()
        except (Killed, CacheWriteError) as error:
            assert "to -1" not in str(error)
            assert str(error) == str(
                failure
            ) or "No space left on device; free some space or delete some files; " in str(error)
            return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize("failure", [Killed(), OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))])
def test_failing_at_any_write_leaves_whole_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failure: BaseException
) -> None:
    monkeypatch.setattr(os, "fsync", lambda _: None)  # a kill does not lose what was written
    path, writes, seen = tmp_path / "out.zarr", 0, set()
    while not write_until(path, failure, writes, monkeypatch):
        writes += 7
        if not path.exists():
            if not isinstance(failure, Killed):
                assert os.listdir(tmp_path) == []
            continue
        for consolidated in (True, False):
            root = zarr.open_group(path, mode="r", use_consolidated=consolidated)
            for index, state in enumerate(np.asarray(root["positions"][...])):
                np.testing.assert_array_equal(state, frame(index).positions)
                np.testing.assert_array_equal(root["velocities"][index], frame(index).velocities)
                assert root["diagnostics/sweeps"][index] == index
        cache = Cache.open(path)
        seen.add(cache.frames)
        assert all(cache.is_whole(index) for index in range(cache.frames))
        assert cache.attributes["state_hash"] == frame(cache.frames - 1).state_hash
        with CacheWriter.resume(path, header()) as writer:
            assert writer.frames == cache.frames
            assert writer.notes == []
            for index in range(cache.frames, 4):
                writer.append(frame(index))
        assert not any(name.endswith(UNFINISHED) for name in everything_below(path))
        again = Cache.open(path)
        assert [again.is_whole(index) for index in range(again.frames)] == 4 * [True]
        shutil.rmtree(path)
    assert seen == {1, 2, 3}
    assert os.listdir(tmp_path) == ["out.zarr"]


@pytest.mark.parametrize("name", ["fsync", "replace"])
def test_a_failing_disk_is_one_clear_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def failing(*_: object, **__: object) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    path = tmp_path / "out.zarr"
    with pytest.raises(CacheWriteError, match=r"cannot write .*: Input/output error; frames 0 to 1 are kept"):  # noqa: SIM117
        with CacheWriter.create(path, header(), frame(0)) as writer:
            writer.append(frame(1))
            writer.commit()
            monkeypatch.setattr(os if name == "fsync" else Path, name, failing)
            writer.append(frame(2))
    assert Cache.open(path).frames == 2
    assert not any(name.endswith(UNFINISHED) for name in everything_below(path))


def test_record_from_python(tmp_path: Path, flag: dict[str, Any]) -> None:
    simulation = Simulation(Scene(flag))
    seen: list[int] = []
    done = record(simulation, tmp_path / "out.zarr", frames=4, on_frame=lambda now: seen.append(now.frame))
    assert (done.frames, done.resumed_at, done.notes, seen) == (4, None, [], [1, 2, 3])
    assert Cache.open(done.path).attributes["state_hash"] == simulation.state_hash
    with pytest.raises(ValueError, match="a cache starts at t = 0"):
        record(simulation, tmp_path / "other.zarr")
    with pytest.raises(ValueError, match="frames = 0: must be 1 or more"):
        record(Simulation(Scene(flag)), tmp_path / "other.zarr", frames=0)
    with pytest.raises(ValueError, match="must be one of refuse, resume, overwrite"):
        record(Simulation(Scene(flag)), tmp_path / "other.zarr", existing="keep")  # type: ignore[arg-type]
    assert os.listdir(tmp_path) == ["out.zarr"]
