"""The reading side of a cache."""

import json
import os
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.storage import LocalStore

from taut import _taut
from taut.cache import layout
from taut.errors import CacheError, did_you_mean
from taut.scene.shipped import is_shipped


class Cache:
    """The frames of a run, as they stood on disk when it was opened.

    A run in progress may be read, too: only whole frames are seen. Open the cache again to see more.
    """

    def __init__(self, path: Path, root: zarr.Group) -> None:
        """Wrap an open group; see :meth:`open`."""
        self._path = path
        self._arrays = _arrays(path, root)
        self._attributes: dict[str, Any] = dict(root.attrs.asdict())
        for name, kind in layout.ATTRIBUTES.items():
            if not isinstance(self._attributes.get(name), kind):
                raise CacheError(
                    f"{path}: the attribute {name} is missing or no {kind.__name__}; run it again"
                )
        shapes = {self._arrays[name].shape[1:] for name in layout.STATE}
        if len(shapes) != 1 or shapes.pop()[1:] != (3,):
            raise CacheError(f"{path}: positions and velocities have unlike shapes; run it again")
        past = [name for name in (layout.PAST, *layout.EXACT) if name in self._arrays]
        self._frames = min(self._arrays[name].shape[0] for name in (*past, *layout.GROWING))
        if self._frames < 1:
            raise CacheError(f"{path}: there is no frame in it; run it again")

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Open a cache for reading.

        Raises:
            CacheError: there is none, or its structure is damaged.
        """
        path = Path(path)
        if not os.path.exists(path):
            raise CacheError(f"there is no cache {path}{_meant(path)}")
        try:
            root = zarr.open_group(LocalStore(path, read_only=True), mode="r", zarr_format=3)
        except (FileNotFoundError, NotADirectoryError):
            raise CacheError(f"{path} is no cache: it is no Zarr group{_meant(path)}") from None
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise CacheError(f"{path}: its zarr.json is damaged ({error}); run it again") from None
        return cls(path, root)

    @property
    def path(self) -> Path:
        """Where it is."""
        return self._path

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the group, see :mod:`taut.cache.layout`."""
        return self._attributes

    @property
    def title(self) -> str:
        """The scene's title, or the cache's name where it has none."""
        return str(self._attributes.get("title") or self._path.stem)

    @property
    def scene(self) -> dict[str, Any]:
        """The resolved scene."""
        scene: dict[str, Any] = self._attributes["scene"]
        return scene

    @property
    def frames(self) -> int:
        """Whole frames, the initial state (frame 0) included [1]."""
        return self._frames

    @property
    def vertices(self) -> int:
        """Vertices in each frame [1]."""
        return int(self._arrays["positions"].shape[1])

    @cached_property
    def time(self) -> NDArray[np.float64]:
        """Time of each frame [s], shape (frames,)."""
        return self._series("time")

    @cached_property
    def faces(self) -> NDArray[np.int32]:
        """Triangles as vertex indices, shape (triangles, 3)."""
        return self._indices("faces")

    @cached_property
    def springs(self) -> NDArray[np.int32]:
        """Springs as pairs of vertex indices, shape (springs, 2)."""
        return self._indices("springs")

    @cached_property
    def pins(self) -> NDArray[np.int32]:
        """Indices of the pinned vertices, shape (pins,)."""
        return self._indices("pins")

    @cached_property
    def spring_kind(self) -> NDArray[np.uint8]:
        """Kind of each spring: 0 structural, 1 shear, 2 flexion; shape (springs,)."""
        return self._read("spring_kind")

    @cached_property
    def rest_length(self) -> NDArray[np.float32]:
        """Rest length of each spring [m], shape (springs,)."""
        return self._read("rest_length")

    @cached_property
    def strain_limit(self) -> NDArray[np.float32]:
        """Largest stretch allowed of each spring [1], infinite where there is none; shape (springs,)."""
        return self._read("strain_limit")

    @cached_property
    def diagnostics(self) -> dict[str, NDArray[Any]]:
        """Numbers for each frame, shape (frames,) each; see :data:`taut.cache.layout.DIAGNOSTICS`."""
        return {name: self._series(f"diagnostics/{name}") for name in layout.DIAGNOSTICS}

    def positions(self, frame: int) -> NDArray[np.float32]:
        """Positions [m], shape (vertices, 3).

        Args:
            frame: from 0; negative numbers count from the end.

        Raises:
            IndexError: there is no such frame.
            CacheError: the frame is damaged.
        """
        return self._state("positions", frame)

    def velocities(self, frame: int) -> NDArray[np.float32]:
        """Velocities of the motion [m/s], shape (vertices, 3); otherwise like :meth:`positions`."""
        return self._state("velocities", frame)

    def past(self, frame: int) -> NDArray[np.float32] | None:
        """What the integrator needs to go on from a frame, :attr:`taut.Simulation.past`."""
        return self._state(layout.PAST, frame) if layout.PAST in self._arrays else None

    def origins(self, frame: int) -> NDArray[np.float64]:
        """Where the coordinates of each cloth begin in a frame [m], shape (cloths, 3)."""
        if layout.ORIGINS not in self._arrays:
            return np.zeros((len(self._attributes["cloths"]), 3))
        return self._state(layout.ORIGINS, frame)

    def local_positions(self, frame: int) -> NDArray[np.float32]:
        """Positions from the origin of each cloth [m], shape (vertices, 3), float32."""
        return self._state(layout.LOCAL if self.origins(frame).any() else "positions", frame)

    def exact_positions(self, frame: int) -> NDArray[np.float64]:
        """Positions in the world [m], shape (vertices, 3), float64, with all their digits."""
        counts = [int(cloth["vertices"]) for cloth in self._attributes["cloths"]]
        local = self.local_positions(frame).astype(np.float64)
        exact: NDArray[np.float64] = local + np.repeat(self.origins(frame), counts, axis=0)
        return exact

    def stretch(self, frame: int) -> NDArray[np.float32]:
        """``|X_uv| / L - 1`` of each spring [1], shape (springs,); otherwise like :meth:`positions`."""
        ends = self.exact_positions(frame)[self.springs]
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        stretch: NDArray[np.float32] = (length / self.rest_length - 1.0).astype(np.float32)
        return stretch

    def is_whole(self, frame: int) -> bool:
        """Whether a frame reads back as it was written: its state has the hash that was stored with it."""
        try:
            state = self.local_positions(frame), self.velocities(frame)
            found = _taut.state_hash(*state, self.past(frame), self.origins(frame))
            return int(found, 16) == int(self.diagnostics["state_hash"][frame])
        except CacheError:
            return False

    def _state(self, name: str, frame: int) -> NDArray[Any]:
        index = frame + self._frames if frame < 0 else frame
        if not 0 <= index < self._frames:
            raise IndexError(
                f"{self._path}: there is no frame {frame}; there are frames 0 to {self._frames - 1}"
            )
        values = self._read(name, index)
        if not np.isfinite(values).all():
            raise CacheError(f"{self._path}: {name} of frame {index} are missing; run it again")
        return values

    def _series(self, name: str) -> NDArray[Any]:
        values = self._read(name, slice(self._frames))
        if values.dtype.kind == "f" and np.isnan(values).any():
            raise CacheError(f"{self._path}: numbers of {name} are missing; run it again")
        return values

    def _indices(self, name: str) -> NDArray[np.int32]:
        values = self._read(name)
        if values.size and not (values.min() >= 0 and values.max() < self.vertices):
            raise CacheError(f"{self._path}: {name} name vertices that are not there; run it again")
        return values

    def _read(self, name: str, selection: Any = slice(None)) -> NDArray[Any]:
        try:
            return np.asarray(self._arrays[name][selection])
        except (OSError, ValueError, RuntimeError, MemoryError) as error:
            raise CacheError(f"{self._path}: {name} is damaged ({error}); run it again") from None


def _meant(path: Path) -> str:
    """The end of the sentence that a path is no cache: what may have been meant."""
    if path.suffix == ".toml" or is_shipped(str(path)):
        return f"; a scene is run first: taut run {path} --out {path.stem}.zarr"
    return did_you_mean(path.name, sorted(cache.name for cache in path.parent.glob("*.zarr")))


def _arrays(path: Path, root: zarr.Group) -> dict[str, zarr.Array[Any]]:
    """Every array of a cache, its type and dimensions checked."""
    found_format = root.attrs.get("format")
    if found_format != layout.FORMAT:
        raise CacheError(
            f"{path} is no cache that this taut reads: its format is {found_format!r}, not {layout.FORMAT!r}"
        )
    kinds = {name: (kind, 1 + len(shape)) for name, (kind, shape) in layout.CONSTANT.items()}
    kinds |= {name: (kind, 1) for name, kind in layout.SERIES.items()}
    kinds |= {name: ("float32", 3) for name in layout.STATE}
    further = {layout.PAST: "float32", layout.LOCAL: "float32", layout.ORIGINS: "float64"}
    kinds |= {name: (kind, 3) for name, kind in further.items() if name in root}
    arrays: dict[str, zarr.Array[Any]] = {}
    for name, (kind, dimensions) in kinds.items():
        try:
            array = root[name]
        except (KeyError, OSError, ValueError, json.JSONDecodeError):
            array = None
        if not isinstance(array, zarr.Array) or (str(array.dtype), array.ndim) != (kind, dimensions):
            raise CacheError(f"{path}: the array {name} is missing or of another type; run it again")
        arrays[name] = array
    return arrays
