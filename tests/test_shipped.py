"""Scenes that come with taut: they are listed, run by name, and are offered by the shells."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from taut import Cache, Scene, SceneError
from taut.cli.arguments import complete_scene
from taut.scene import find_scene, shipped_scenes

Command = Callable[..., Any]
TAUT = Path(sys.executable).with_name("taut")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_all_are_listed_with_what_they_show(taut: Command) -> None:
    listed = " ".join(taut("scenes").out.split())
    assert len(shipped_scenes()) >= 9
    for scene in shipped_scenes():
        assert scene.description.endswith(".") and len(scene.description) > 30
        assert f"{scene.name} {scene.description}" in listed


def test_one_is_printed(taut: Command) -> None:
    assert taut("scenes", "flag").out == find_scene("flag").read_text()
    wrong = taut("scenes", "flg")
    assert wrong.status == 2
    assert "did you mean flag?" in wrong.err


def test_one_runs_by_name_with_its_mesh(taut: Command, here: Path) -> None:
    assert taut("run", "cape", "--out", "cape.zarr", "--frames", 2, "--quiet").status == 0
    assert len(Cache.open("cape.zarr").positions(1)) == 3045


def test_a_file_comes_before_a_shipped_scene(here: Path, flag_file: Path) -> None:
    assert flag_file == here / "flag.toml"
    assert Scene.load("flag").title == "Flag in the wind"
    assert Scene.load("flag.toml").title == "Small flag"
    (here / "net").mkdir()
    assert find_scene("net").name == "net.toml"  # a folder is no scene
    (here / "cape").write_text(flag_file.read_text())
    assert Scene.load("cape").title == "Small flag"


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ("falg", "there is no scene falg: neither a file here nor a shipped scene; did you mean flag?"),
        ("mine", "did you mean mine.toml?"),
        ("xyzzy", "shipped scene; `taut scenes` lists those shipped"),
        ("flag.toml", "the shipped scene is called flag, without .toml"),
        (
            "sub/mien.toml",
            "cannot read the scene sub/mien.toml: No such file or directory; did you mean mine.toml?",
        ),
        ("sub", "it is a folder; name a file in it"),
        ("run.zarr", "it is a cache that a run wrote"),
        ("x" * 5000, "File name too long"),
    ],
)
def test_a_scene_that_is_not_there(here: Path, scene: str, message: str) -> None:
    for folder in ("sub", "run.zarr"):
        (here / folder).mkdir()
    for file in ("mine.toml", "sub/mine.toml"):
        (here / file).write_text("")
    with pytest.raises(SceneError, match=re.escape(message)):
        Scene.load(scene)


def test_a_misspelt_command_is_named(taut: Command) -> None:
    wrong = taut("rnu", "flag")
    assert wrong.status == 2
    assert "Did you mean 'run'?" in wrong.err


def completed(shell: str, words: list[str], folder: Path) -> str:
    """What taut answers when a shell asks how the last of these words may go on."""
    variables = {
        "bash": {"COMP_WORDS": "\n".join(words), "COMP_CWORD": str(len(words) - 1)},
        "zsh": {"_TYPER_COMPLETE_ARGS": " ".join(words)},
        "fish": {"_TYPER_COMPLETE_ARGS": " ".join(words), "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
    }[shell]
    asked = os.environ | variables | {"_TAUT_COMPLETE": f"complete_{shell}"}
    return subprocess.run([TAUT], env=asked, cwd=folder, capture_output=True, text=True).stdout


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_offer_commands_options_and_scenes(shell: str, here: Path, flag_file: Path) -> None:
    (here / "more").mkdir()
    (here / "more" / "deep.toml").write_text("")
    assert "render" in completed(shell, ["taut", "re"], here)
    offered = completed(shell, ["taut", "run", "fl"], here)
    assert "flag-strong" in offered and "flag.toml" in offered and "cape" not in offered
    assert "more/deep.toml" in completed(shell, ["taut", "run", "more/d"], here)


def test_folders_are_offered_on_the_way_to_a_scene(here: Path) -> None:
    for folder in ("more", ".hidden", "run.zarr"):
        (here / folder).mkdir()
    (here / "more" / "deep.toml").write_text("")
    offered = [name for name, _ in complete_scene("")]
    assert "more/" in offered and "curtain" in offered
    assert not {".hidden/", "run.zarr/"} & set(offered)
    assert complete_scene("more/") == [("more/deep.toml", "scene file")]
    assert complete_scene("gone/") == []
    assert (f"{here}/more/", "folder") in complete_scene(f"{here}/m")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_for_a_shell_is_one_that_it_reads(shell: str, tmp_path: Path) -> None:
    asked = os.environ | {"_TAUT_COMPLETE": f"source_{shell}"}
    script = subprocess.run([TAUT], env=asked, capture_output=True, text=True, check=True).stdout
    assert f"complete_{shell}" in script
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed here")
    subprocess.run([shell, "-n", "/dev/stdin"], input=script, text=True, check=True)
