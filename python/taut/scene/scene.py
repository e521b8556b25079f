"""The scene as Python sees it; the engine holds the definition of every field."""

import copy
import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from taut import _taut
from taut.errors import SceneError
from taut.scene.meshes import Mesh, check_arrays, read_meshes
from taut.scene.needs import Needs
from taut.scene.paths import FollowedPath, check_path, read_paths
from taut.scene.plain import plain
from taut.scene.settings import apply_setting
from taut.scene.shipped import find_scene


class Scene:
    """A checked scene with every default filled in. Does not change."""

    def __init__(
        self,
        document: Mapping[str, Any],
        meshes: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
        folder: str | Path | None = None,
        sandbox: bool = False,
        paths: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Check a scene given as a dict; :meth:`load` reads a file.

        Args:
            document: the scene's fields as in a TOML file; NumPy arrays may stand for lists.
            meshes: geometry for the ``mesh`` names of cloths and bodies, so that no file is read: for each
                name a pair of vertices [m], shape (vertices, 3), and faces, shape (faces, 3) or (faces, 4),
                from 0.
            folder: where mesh paths start; the current folder when left out.
            sandbox: for documents from elsewhere: no mesh or path outside that folder is read.
            paths: arrays for the ``follow`` names of pins and the ``motion`` names of bodies, so that no file
                is read: for each name places [m], shape (frames, vertices, 3).

        Raises:
            SceneError: a field is unknown, misspelt, of the wrong type or out of range.
        """
        checked = {name: check_arrays(name, mesh) for name, mesh in (meshes or {}).items()}
        self._sandbox = sandbox
        self._paths = {
            name: (check_path(f"paths[{name!r}]", path), None) for name, path in (paths or {}).items()
        }
        self._resolve(plain(document), checked, Path.cwd() if folder is None else Path(folder))

    def _resolve(self, given: dict[str, Any], meshes: Mapping[str, Mesh], folder: Path) -> None:
        resolved, warnings = _taut.resolve_scene(json.dumps(given, allow_nan=False))
        self._given = given
        self._meshes = meshes
        self._folder = folder
        self._document: dict[str, Any] = json.loads(resolved)
        self._warnings = list(warnings)

    @classmethod
    def load(cls, path: str | Path, sandbox: bool = False) -> Self:
        """Read a TOML file; mesh paths in it start at its folder, and may be absolute.

        Args:
            path: the file, or the name of a shipped scene, as in ``Scene.load("flag")``.
            sandbox: for a scene from elsewhere: absolute paths of meshes, ``..`` and links that lead out of
                the scene's folder are refused.

        Raises:
            SceneError: the file cannot be read, is not TOML (line and column are named) or is not a scene.
        """
        try:
            path = find_scene(path)
            with path.open("rb") as file:
                document = tomllib.load(file)
        except OSError as error:
            raise SceneError(f"cannot read the scene {path}: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise SceneError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None
        except tomllib.TOMLDecodeError as error:
            raise SceneError(f"{path}: is not TOML: {error}") from None
        except RecursionError:
            raise SceneError(f"{path}: is nested too deeply; no field of a scene is") from None
        return cls(document, folder=path.parent, sandbox=sandbox)

    @classmethod
    def from_arrays(
        cls,
        positions: ArrayLike,
        faces: ArrayLike,
        *,
        pins: ArrayLike | Sequence[Mapping[str, Any]] = (),
        scene: Mapping[str, Any] | None = None,
        meshes: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
        **cloth: Any,
    ) -> Self:
        """A scene of one cloth that is given as arrays; they are checked like a mesh file.

        ``Scene.from_arrays(positions, faces, pins=[0, 1], fabric="denim", thickness=0.002)``

        Args:
            positions: where the cloth lies before it moves, without any strain [m], shape (vertices, 3).
            faces: triangles or quads, shape (faces, 3) or (faces, 4), from 0.
            pins: the vertices that are held, shape (n,); or pins as a scene has them, a mapping each.
            scene: the other fields of the scene: ``{"wind": .., "body": [..], "solver": ..}``.
            meshes: arrays for bodies of `scene`, as in :class:`Scene`.
            cloth: the other fields of a cloth: ``fabric``, ``thickness``, ``strain_limit``, ``density``, ..

        Raises:
            SceneError: as :class:`Scene`; of the arrays as of ``meshes["cloth"]``, or of the ``name`` given.
        """
        scene = dict(scene or {})
        if "cloth" in scene:
            raise SceneError("scene.cloth: must be left out, the arrays are the cloth; or make a taut.Scene")
        if "mesh" in cloth:
            raise SceneError("mesh: must be left out, the arrays are the mesh")
        held = np.atleast_1d(np.asarray(pins, object)).tolist()
        given = held if held and isinstance(held[0], Mapping) else [{"vertices": held}] if held else []
        name = cloth.setdefault("name", "cloth")
        arrays = {**(meshes or {}), name: (positions, faces)}
        return cls({**scene, "cloth": [{**cloth, "mesh": name, "pins": given}]}, arrays)

    def with_settings(self, settings: Iterable[str]) -> Self:
        """Return this scene with some values changed.

        Args:
            settings: ``path=value`` each, as in ``solver.filter=none``, ``cloth[0].strain_limit=0.1``,
                ``cloth.flag.strain_limit=0.1`` (a cloth or a body by its name), ``wind.velocity=[12, 0, 0]``.
                Values are written as in TOML; a bare word is text.

        Raises:
            SceneError: a setting cannot be read, leads nowhere, or the changed scene is not valid.
        """
        given = copy.deepcopy(self._given)
        for kind in ("cloth", "body"):
            for one, resolved in zip(given.get(kind, ()), self._document.get(kind, ()), strict=True):
                one.setdefault("name", resolved["name"])  # so that it answers to its default name, too
        for setting in settings:
            apply_setting(given, setting)
        changed = copy.copy(self)
        changed._resolve(plain(given), self._meshes, self._folder)
        return changed

    @property
    def document(self) -> dict[str, Any]:
        """The resolved scene, every default filled in; a copy."""
        return copy.deepcopy(self._document)

    @property
    def warnings(self) -> list[str]:
        """What is allowed but looks like a mistake, one sentence each."""
        return list(self._warnings)

    @property
    def folder(self) -> Path:
        """Where the paths of meshes start."""
        return self._folder

    @property
    def title(self) -> str:
        """Shown above pictures and in reports."""
        return str(self._document["title"])

    @property
    def fps(self) -> float:
        """Frames per second [1/s]."""
        return float(self._document["fps"])

    @property
    def frames(self) -> int:
        """Frames in the scene's duration, the initial one included [1]."""
        return max(1, round(float(self._document["duration"]) * self.fps))

    def to_json(self) -> str:
        """The resolved scene as JSON."""
        return json.dumps(self._document, allow_nan=False)

    def needs(self, frames: int | None = None) -> Needs:
        """What it takes to simulate and to record this scene; nothing of it is built.

        Args:
            frames: of the cache; those of the scene when left out [1].

        Raises:
            SceneError: a mesh is missing or cannot be read.
        """
        meshes, _ = self.read_meshes()
        vertices, springs, memory, frame = _taut.footprint(self.to_json(), meshes)
        return Needs.of(vertices, springs, memory, frame * (self.frames if frames is None else frames))

    def read_meshes(self) -> tuple[dict[str, Mesh], list[str]]:
        """Geometry of every mesh that the scene names, and what was repaired in it.

        Raises:
            SceneError: a mesh is missing or cannot be read; in a sandbox it lies outside the scene's folder.
        """
        return read_meshes(self._document, self._folder, self._meshes, self._sandbox)

    def read_paths(self) -> dict[str, FollowedPath]:
        """Places of every array that pins or bodies follow [m]; frames per second, if not the scene's.

        Raises:
            SceneError: a file is missing or no such array; in a sandbox it lies outside the scene's folder.
        """
        return read_paths(self._document, self._folder, self._paths, self._sandbox)
