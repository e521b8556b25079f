"""Whatever happens to the files of a cache: it reads as it was written, or says what is wrong with it."""

import itertools
import json
import os
import random
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr
from taut import Cache, CacheError, Scene, Simulation, record
from taut.cache import metadata

FRAMES = 3
FLIPS = {"zarr.json": 400, "chunks": 120}


@pytest.fixture(scope="module")
def caches(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """A cloth at the origin, one far from it, whose frames have places from an origin of their own, and one
    beside bodies, one of which moves."""
    folder = tmp_path_factory.mktemp("caches")
    made = []
    box = {"box": {"center": [0, 2, 0], "size": [1, 1, 1]}}
    bodies = [{"sphere": {"center": [5, 0, 0], "radius": 1}, "move": [[1.0, [0, 0, 1]]]}, box]
    for name, x in (("near", 0), ("far", 90_000), ("bodies", 0)):
        grid = {"size": [1.5, 1.0], "cells": [6, 4], "origin": [x, 0, 1], "axes": ["x", "z"]}
        cloth = {"name": "flag", "grid": grid, "fabric": "nylon", "pins": [{"edge": "left"}]}
        document = {"title": "Small flag", "wind": {"velocity": [8.0, 1.5, 0.0]}, "cloth": [cloth]}
        scene = Scene(document | ({"body": bodies} if name == "bodies" else {}))
        made.append(record(Simulation(scene, threads=1), folder / f"{name}.zarr", FRAMES).path)
    return made


@pytest.fixture(params=["near", "far", "bodies"])
def cache(request: pytest.FixtureRequest, caches: list[Path]) -> Path:
    """Each of them; what is done to it is undone by the tests."""
    return next(path for path in caches if path.stem == request.param)


def everything(path: Path) -> dict[str, Any]:
    """All that a cache says."""
    opened = Cache.open(path)
    found: dict[str, Any] = {"attributes": opened.attributes, "frames": opened.frames, "time": opened.time}
    for name in ("faces", "springs", "spring_kind", "rest_length", "strain_limit", "pins"):
        found[name] = getattr(opened, name)
    found |= opened.diagnostics
    for frame in range(opened.frames):
        for name in ("positions", "velocities", "past", "origins", "local_positions", "exact_positions"):
            found[f"{name} {frame}"] = getattr(opened, name)(frame)
        for name, body in opened.bodies(frame).items():
            found |= {f"{name} {frame}": body.positions, f"{name} {frame} triangles": body.triangles}
    return found


def same(one: dict[str, Any], other: dict[str, Any]) -> bool:
    return one.keys() == other.keys() and all(np.array_equal(one[name], other[name]) for name in one)


def chunks(path: Path) -> list[Path]:
    return sorted(file for file in path.rglob("c.*") if file.is_file())


def is_chunk(file: Path) -> bool:
    return file.name.startswith("c.")


@contextmanager
def damaged(file: Path) -> Iterator[None]:
    """Put a file back as it was at the end."""
    before = file.read_bytes()
    try:
        yield
    finally:
        if file.is_dir() and not file.is_symlink():
            shutil.rmtree(file)
        file.unlink(missing_ok=True)
        file.write_bytes(before)


def seen(path: Path, original: dict[str, Any], file: Path, first: bool = False) -> bool:
    """Whether an error says what is wrong; what is read without one must be what was written.

    Where many damages are tried, the array of the file comes `first`, through which all others read it: its
    error is the same, and only what has none there is looked for in the whole cache.
    """
    try:
        if first and is_chunk(file):
            opened, name = Cache.open(path), str(file.parent.relative_to(path))
            opened.rows(name, 0, opened._arrays[name].shape[0])
        found = everything(path)
    except CacheError as error:
        assert str(file) in str(error) or (file.parent == path and str(path) in str(error)), error
        remedies = "run it again", "see to its disk", "name one", "did you mean"
        assert any(remedy in str(error) for remedy in remedies), error
        return True
    assert same(found, original), f"{file} is damaged, and nobody says so"
    return False


def test_every_chunk_that_is_missing_is_named(cache: Path) -> None:
    original, files = everything(cache), chunks(cache)
    for file in files:
        with damaged(file):
            file.unlink()
            # Far from the origin, positions that are rounded are there for others to read.
            assert seen(cache, original, file), file
    arrays = {str(file.parent.relative_to(cache)) for file in files}
    opened = json.loads((cache / "zarr.json").read_bytes())["consolidated_metadata"]["metadata"]
    without_chunks = {"diagnostics"} | ({"local_positions"} if cache.stem != "far" else set())
    without_chunks |= {"bodies"} if cache.stem == "bodies" else set()
    assert arrays == set(opened) - without_chunks


@pytest.mark.parametrize("which", FLIPS)
def test_flipped_bits_are_seen(cache: Path, which: str) -> None:
    original, dice = everything(cache), random.Random(1)
    files = [cache / "zarr.json"] if which == "zarr.json" else chunks(cache)
    for _ in range(FLIPS[which] // 2):
        file = dice.choice(files)
        with damaged(file):
            data = bytearray(file.read_bytes())
            for _ in range(dice.choice([1, 1, 2, 5])):
                data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
            file.write_bytes(data)
            assert seen(cache, original, file, first=True) or not is_chunk(file), file


def test_a_chunk_in_the_place_of_another_is_seen(cache: Path) -> None:
    original, dice, files = everything(cache), random.Random(2), chunks(cache)
    # Those of one array, and those of arrays of one type, decode without complaint.
    pairs = [pair for pair in itertools.permutations(files, 2) if pair[0].parent == pair[1].parent]
    series = [file for file in files if file.name == "c.0"]
    pairs += dice.sample(list(itertools.permutations(series, 2)), 60)
    pairs += dice.sample(list(itertools.permutations(files, 2)), 60)
    wrong = 0
    for file, other in pairs:
        with damaged(file):
            file.write_bytes(other.read_bytes())
            wrong += seen(cache, original, file, first=True)
    assert wrong > len(pairs) / 2, "few chunks hold the same"


def test_what_is_cut_short_is_seen(cache: Path) -> None:
    original = everything(cache)
    for file in [cache / "zarr.json", *chunks(cache)]:
        whole = file.read_bytes()
        for length in sorted({0, 1, 5, len(whole) // 2, len(whole) - 1}):
            with damaged(file):
                file.write_bytes(whole[:length])
                assert seen(cache, original, file, first=length != 1), (file, length)


def put_folder(file: Path) -> None:
    file.mkdir()
    (file / "x").write_text("x")


@pytest.mark.parametrize(
    "put", [put_folder, lambda file: file.symlink_to(file.with_name("gone")), lambda file: os.mkfifo(file)]
)
def test_what_is_no_file_is_seen(caches: list[Path], put: Callable[[Path], object]) -> None:
    cache = caches[0]
    original = everything(cache)
    names = ("zarr.json", "faces/c.0.0", "pins/c.0", "time/c.0", "diagnostics/cuts/c.0", "positions/c.1.0.0")
    for file in (cache / name for name in names):
        with damaged(file):
            file.unlink()
            put(file)
            assert seen(cache, original, file), file


def test_what_must_not_be_read_is_seen(caches: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    cache = caches[0]
    original, real = everything(cache), Path.open
    for name in ("zarr.json", "springs/c.0.0", "velocities/c.2.0.0"):
        secret = cache / name

        def closed(path: Path, *how: Any, secret: Path = secret, **options: Any) -> Any:
            if path == secret:
                raise PermissionError(13, "Permission denied", str(path))
            return real(path, *how, **options)

        with monkeypatch.context() as patch:
            patch.setattr(Path, "open", closed)
            assert seen(cache, original, secret)
            with pytest.raises(CacheError, match="cannot be read .Permission denied.; see to its disk"):
                everything(cache)


def test_metadata_of_single_arrays_are_not_needed(caches: list[Path]) -> None:
    original = everything(caches[0])
    for file in caches[0].rglob("*/zarr.json"):
        with damaged(file):
            file.unlink()
            assert not seen(caches[0], original, file)


def made_older(path: Path, folder: Path) -> Path:
    """What the format before this one was: no checksum, and chunks of nothing but zeros are not on disk."""
    old = Path(shutil.copytree(path, folder / path.name))
    opened = Cache.open(old)
    zeros = [name for name, numbers in opened.diagnostics.items() if not numbers.any()]
    zeros = [f"diagnostics/{name}" for name in zeros if opened.diagnostics[name].dtype.kind != "f"]
    assert "diagnostics/held_back_pins" in zeros
    for name in zeros:
        for file in (old / name).glob("c.*"):
            file.unlink()
    document = json.loads((old / "zarr.json").read_bytes())
    document["attributes"]["format"] = metadata.TRUSTED
    del document["attributes"]["checksum"]
    nodes = document["consolidated_metadata"]["metadata"]
    del nodes["checksums"]
    shutil.rmtree(old / "checksums")
    for node in nodes.values():
        node["attributes"].pop("checksum", None)
    (old / "zarr.json").write_text(json.dumps(document))
    return old


def test_older_caches_are_read_on_trust(cache: Path, tmp_path: Path) -> None:
    original, old = everything(cache), made_older(cache, tmp_path)
    for attributes in (original["attributes"], (found := everything(old))["attributes"]):
        attributes.pop("checksum", None)
        attributes.pop("format")
    assert same(found, original)
    # What cannot be zero is missed all the same, and damage of any kind is one of taut's own errors.
    for name in ("faces/c.0.0", "springs/c.0.0", "rest_length/c.0", "time/c.0", "positions/c.1.0.0"):
        with damaged(old / name):
            (old / name).unlink()
            with pytest.raises(CacheError, match=f"{name}.* is missing"):
                everything(old)
    for name in ("faces", "springs"):
        with damaged(next((old / name).glob("c.*"))):
            zarr.open_group(old, mode="r+")[name][3] = -1
            with pytest.raises(CacheError, match=f"{name} name vertices that are not there"):
                everything(old)
    dice, file = random.Random(2), old / "zarr.json"
    for _ in range(100):
        with damaged(file):
            data = bytearray(file.read_bytes())
            at = data.index(b'"consolidated_metadata"')
            data[dice.randrange(at, len(data))] ^= 1 << dice.randrange(8)
            file.write_bytes(data)
            with suppress(CacheError):
                everything(old)


def test_a_run_that_goes_on_in_an_older_cache_seals_it(
    copied: Path, flag: dict[str, Any], tmp_path: Path
) -> None:
    document = json.loads((copied / "zarr.json").read_bytes())
    document["attributes"]["format"] = metadata.TRUSTED
    del document["attributes"]["checksum"]
    (copied / "zarr.json").write_text(json.dumps(document))
    (copied / "diagnostics/held_back_pins/c.0").unlink()
    flag["duration"] = 0.6
    assert record(Simulation(Scene(flag)), copied, existing="resume").frames == 36
    opened = Cache.open(copied)
    assert opened.attributes["format"] == metadata.TRUSTED
    assert all(opened.is_whole(frame) for frame in range(36))
    (copied / "zarr.json").write_bytes((copied / "zarr.json").read_bytes().replace(b"Small", b"Tmall"))
    with pytest.raises(CacheError, match="differs from its checksum"):
        Cache.open(copied)
