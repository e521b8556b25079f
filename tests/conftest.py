import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from taut.view.live import LiveShow

FLAG = """\
title = "Small flag"
duration = 0.5
fps = 60
[wind]
velocity = [8.0, 1.5, 0.0]
[[cloth]]
name = "flag"
grid = { size = [1.5, 1.0], cells = [6, 4], origin = [0, 0, 1], axes = ["x", "z"] }
fabric = "nylon"
pins = [{ edge = "left" }]
"""


def pytest_configure() -> None:
    """Each of several workers has one core: threads that two keep awake would only wait for each other."""
    worker = os.environ.get("PYTEST_XDIST_WORKER")
    if worker and hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {cores[int(worker.removeprefix("gw")) % len(cores)]})


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files that take long come first, so that no worker waits for another one at the end."""
    long = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in long)


@pytest.fixture
def flag() -> dict[str, Any]:
    """A flag of 35 vertices in the wind."""
    grid = {"size": [1.5, 1.0], "cells": [6, 4], "origin": [0, 0, 1], "axes": ["x", "z"]}
    cloth = {"name": "flag", "grid": grid, "fabric": "nylon", "pins": [{"edge": "left"}]}
    wind = {"velocity": [8.0, 1.5, 0.0]}
    return {"title": "Small flag", "duration": 0.5, "fps": 60, "wind": wind, "cloth": [cloth]}


@pytest.fixture
def flag_file(tmp_path: Path) -> Path:
    """The same flag as a file."""
    path = tmp_path / "flag.toml"
    path.write_text(FLAG)
    return path


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished cache of the flag, 30 frames; not to be changed."""
    from taut import Scene, Simulation, record

    folder = tmp_path_factory.mktemp("recorded")
    (folder / "flag.toml").write_text(FLAG)
    record(Simulation(Scene.load(folder / "flag.toml")), folder / "flag.zarr")
    return folder / "flag.zarr"


@pytest.fixture
def copied(recorded: Path, tmp_path: Path) -> Path:
    """A copy of that cache, to be changed."""
    import shutil

    return Path(shutil.copytree(recorded, tmp_path / "flag.zarr"))


@pytest.fixture
def show(flag: dict[str, Any]) -> "LiveShow":
    """The flag behind a viewer; nothing moves before it is started or turned."""
    from taut import Scene
    from taut.view.live import LiveShow

    return LiveShow(Scene(flag), threads=1)


class Outcome:
    """What a command did."""

    def __init__(self, status: int, out: str, err: str) -> None:
        self.status, self.out, self.err = status, out, err


@pytest.fixture
def taut(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Outcome]:
    """Run ``taut`` with these arguments, in this process."""
    from taut.cli.app import app
    from typer.testing import CliRunner

    monkeypatch.delenv("TAUT_TRACEBACK", raising=False)

    def run(*arguments: str | os.PathLike[str]) -> Outcome:
        result = CliRunner().invoke(app, [str(argument) for argument in arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return Outcome(result.exit_code, result.stdout, result.stderr)

    return run
