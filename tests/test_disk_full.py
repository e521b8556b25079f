"""A disk that is full, in bytes or in files: one clear line, and what is whole stays whole."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from taut import Cache

FLAG = """\
title = "Small flag"
duration = 20
[[cloth]]
name = "flag"
grid = { size = [1.5, 1.0], cells = [40, 30], origin = [0, 0, 1], axes = ["x", "z"] }
pins = [{ edge = "left" }]
"""

Disk = Callable[[str], Path]


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Disk]:
    """Makes a small disk; where that is not allowed the test is skipped."""
    mounted: list[Path] = []

    def mount(options: str) -> Path:
        place = tmp_path / f"disk{len(mounted)}"
        place.mkdir()
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(place)]
        try:
            subprocess.run(command, check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            pytest.skip("to make a small disk takes the right to mount one, which root has")
        mounted.append(place)
        return place

    yield mount
    for place in mounted:
        subprocess.run(["umount", str(place)], check=True)


def failing(*arguments: str | Path) -> str:
    """What a command says that fails on the way."""
    command = [sys.executable, "-m", "taut", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "")
    return done.stderr


def run(folder: Path, out: Path) -> str:
    (folder / "flag.toml").write_text(FLAG)
    return failing("run", folder / "flag.toml", "--out", out, "--quiet")


@pytest.mark.parametrize("options", ["size=700k", "size=100m,nr_inodes=130"])
def test_a_full_disk_is_one_line_and_keeps_the_frames(disk: Disk, tmp_path: Path, options: str) -> None:
    out = disk(options) / "flag.zarr"
    said = run(tmp_path, out)
    assert said.startswith("error: cannot write ") and said.count("\n") == 1, said
    opened = Cache.open(out)
    kept = f"frames 0 to {opened.frames - 1} are kept: go on with --resume"
    assert f"No space left on device; free some space or delete some files; {kept}" in said
    assert all(opened.is_whole(frame) for frame in range(opened.frames))


@pytest.mark.parametrize("files", [3, 20, 60, 75])
def test_where_no_frame_fits_nothing_is_kept(disk: Disk, tmp_path: Path, files: int) -> None:
    place = disk(f"size=100m,nr_inodes={files}")
    said = run(tmp_path, place / "flag.zarr")
    assert said.endswith("; no frame is kept, nothing was left behind\n") and said.count("\n") == 1, said
    assert list(place.iterdir()) == []


@pytest.mark.parametrize("options", ["size=4k", "size=100m,nr_inodes=2"])
@pytest.mark.parametrize(
    "command", [["new", "x.toml"], ["export", "--to", "obj", "--out", "x"], ["render", "--out", "x.png"]]
)
def test_no_command_leaves_a_part_of_a_file(
    disk: Disk, recorded: Path, options: str, command: list[str]
) -> None:
    place = disk(options)
    (place / "full").write_bytes(bytes(4096))
    name, *further = command
    cache = [] if name == "new" else [recorded]
    said = failing(name, *cache, *(str(place / word) if word.startswith("x") else word for word in further))
    lines = [line for line in said.splitlines() if line.startswith("error: ")]
    assert len(lines) == 1 and "Traceback" not in said, said
    assert "No space left on device; free some space or choose another disk (nothing was left" in said
    assert [path.name for path in place.iterdir()] == ["full"]
