"""Scenes that come with taut, and how a scene is found: by its path, or by the name of one of them."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

from taut.errors import SceneError, did_you_mean

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


def is_shipped(name: str) -> bool:
    """Whether a scene of this name comes with taut."""
    return name in [scene.name for scene in shipped_scenes()]


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
    if is_shipped(str(scene)):
        return FOLDER / f"{scene}.toml"
    if path.is_dir():
        cache = path.suffix == ".zarr"
        remedy = "it is a cache that a run wrote: taut info reads it" if cache else "name a file in it"
        raise SceneError(f"cannot read the scene {path}: it is a folder; {remedy}")
    if path.name == str(scene) and not path.suffix:
        near = did_you_mean(path.name, [known.name for known in shipped_scenes()] + _beside(path))
        missing = f"there is no scene {path}: neither a file here nor a shipped scene"
        raise SceneError(f"{missing}{near}; `taut scenes` lists those shipped")
    raise SceneError(f"cannot read the scene {path}: No such file or directory{_nearest(path)}")


def _nearest(path: Path) -> str:
    if path.suffix == ".toml" and is_shipped(path.stem):
        return f"; the shipped scene is called {path.stem}, without .toml"
    return did_you_mean(path.name, _beside(path))


def _beside(path: Path) -> list[str]:
    """Names of the scene files in the folder where `path` was looked for."""
    return sorted(file.name for file in path.parent.glob("*.toml"))
