"""Scenes that come with taut, and how a scene is found: by its path, or by the name of one of them."""

import tomllib
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from taut.errors import SceneError

FOLDER = Path(__file__).resolve().parent.parent / "scenes"
"""Where they lie, in the installed package too."""


@dataclass(frozen=True, slots=True)
class ShippedScene:
    """A scene that comes with taut."""

    path: Path
    """Its file."""

    @property
    def name(self) -> str:
        """What it is called: ``flag``."""
        return self.path.stem

    @property
    def text(self) -> str:
        """The file as it stands."""
        return self.path.read_text(encoding="utf-8")

    @property
    def title(self) -> str:
        """Its title."""
        return str(tomllib.loads(self.text)["title"])

    @property
    def description(self) -> str:
        """What it shows: the comment at the head of its file, in one line."""
        lines = self.text.splitlines()
        end = next(number for number, line in enumerate(lines) if not line.startswith("#"))
        return " ".join(line.removeprefix("#").strip() for line in lines[:end])


def shipped_scenes() -> list[ShippedScene]:
    """The scenes that come with taut, by name."""
    return [ShippedScene(path) for path in sorted(FOLDER.glob("*.toml"))]


def find_scene(scene: str | Path) -> Path:
    """Return the file of a scene.

    Args:
        scene: path of a file, or the name of a shipped scene; a file of that name comes first.

    Raises:
        SceneError: there is neither; the nearest names are suggested.
    """
    path = Path(scene)
    if path.exists() and not path.is_dir():
        return path
    names = [known.name for known in shipped_scenes()]
    if str(scene) in names:
        return FOLDER / f"{scene}.toml"
    if path.is_dir():
        cache = path.suffix == ".zarr"
        remedy = "it is a cache that a run wrote" if cache else "name a file in it"
        raise SceneError(f"cannot read the scene {path}: it is a folder; {remedy}")
    if path.name == str(scene) and not path.suffix:
        raise SceneError(
            f"there is no scene {path}: neither a file here nor a shipped scene"
            f"{_did_you_mean(path.name, [*names, *_beside(path)])}; `taut scenes` lists those shipped"
        )
    raise SceneError(f"cannot read the scene {path}: No such file or directory{_nearest(path, names)}")


def _nearest(path: Path, names: list[str]) -> str:
    if path.suffix == ".toml" and path.stem in names:
        return f"; the shipped scene is called {path.stem}, without .toml"
    return _did_you_mean(path.name, _beside(path))


def _beside(path: Path) -> list[str]:
    """Names of the scene files in the folder where `path` was looked for."""
    return sorted(file.name for file in path.parent.glob("*.toml"))


def _did_you_mean(word: str, known: list[str]) -> str:
    near = get_close_matches(word, known, n=1)
    return f"; did you mean {near[0]}?" if near else ""
