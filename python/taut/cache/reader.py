"""The reading side of a cache."""

import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, Self, cast

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.storage import LocalStore, StorePath

from taut import _taut
from taut.arrays import stretches
from taut.bodies import Body, BodyRange, bodies_at
from taut.cache import layout, metadata
from taut.cache.series import Series
from taut.errors import CacheError, did_you_mean
from taut.scene.shipped import is_shipped


class Cache:
    """The frames of a run, as they stood on disk when it was opened.

    A run in progress may be read, too: only whole frames are seen. Open the cache again to see more.

    Damage is always seen: metadata have a checksum, which is checked here, and chunks and rows have one each,
    which is checked when they are read. A chunk that is missing, or stands where another one should, is an
    error that names its file and its frames.

    Caches of the format before this one (``taut-cache/3``) are read on trust. Their metadata have no
    checksum. Chunks of nothing but zeros were not written, so that a missing one of `pins`, `spring_kind` or
    whole numbers in `diagnostics` reads as zeros. A run that goes on in one keeps its format and
    adds the checksum. To be sure of an old cache, run its scene again.
    """

    def __init__(self, path: Path, document: dict[str, Any]) -> None:
        """Wrap the metadata of a group; see :meth:`open`."""
        self._path = path
        self._arrays = _arrays(path, document)
        self._attributes: dict[str, Any] = document["attributes"]
        for name, kind in layout.ATTRIBUTES.items():
            if not isinstance(self._attributes.get(name), kind):
                raise CacheError(
                    f"{path}: the attribute {name} is missing or no {kind.__name__}; run it again"
                )
        shapes = {self._arrays[name].shape[1:] for name in layout.STATE}
        if len(shapes) != 1 or shapes.pop()[1:] != (3,):
            raise CacheError(f"{path}: positions and velocities have unlike shapes; run it again")
        self._frames = min(self._arrays[name].shape[0] for name in layout.growing(self._arrays))
        if self._frames < 1:
            raise CacheError(f"{path}: there is no frame in it; run it again")

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Open a cache for reading.

        Raises:
            CacheError: there is none, or its metadata are damaged.
        """
        path = Path(path)
        if not os.path.exists(path):
            raise CacheError(f"there is no cache {path}{_meant(path)}")
        try:
            return cls(path, metadata.read(path))
        except (FileNotFoundError, NotADirectoryError):
            meant = _meant(path) or "; name one that taut run wrote"
            raise CacheError(f"{path} is no cache: it is no Zarr group, with a zarr.json{meant}") from None

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
        return self.rows("time", 0, self._frames)

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
        return self._constant("spring_kind")

    @cached_property
    def rest_length(self) -> NDArray[np.float32]:
        """Rest length of each spring [m], shape (springs,)."""
        return self._constant("rest_length")

    @cached_property
    def strain_limit(self) -> NDArray[np.float32]:
        """Largest stretch allowed of each spring [1], infinite where there is none; shape (springs,)."""
        return self._constant("strain_limit")

    @cached_property
    def diagnostics(self) -> dict[str, NDArray[Any]]:
        """Numbers for each frame, shape (frames,) each; see :data:`taut.cache.layout.DIAGNOSTICS`."""
        return {name: self._numbers(name) for name in layout.DIAGNOSTICS}

    def _numbers(self, name: str) -> NDArray[Any]:
        if (array := f"diagnostics/{name}") in self._arrays:
            return self.rows(array, 0, self._frames)
        return np.full(self._frames, layout.ADDED[name], layout.DIAGNOSTICS[name])

    @property
    def positions(self) -> Series:
        """Positions of all frames [m], shape (frames, vertices, 3).

        ``cache.positions[frame]`` is what :attr:`taut.Simulation.positions` was then, shape (vertices, 3);
        ``cache.positions(frame)`` is the same. Frames are read when they are asked for; negative numbers
        count from the end.

        Raises:
            IndexError: there is no such frame.
            CacheError: the frame is damaged.
        """
        return self._series("positions")

    @property
    def velocities(self) -> Series:
        """Velocities of the motion [m/s], likewise."""
        return self._series("velocities")

    def _series(self, name: str) -> Series:
        return Series(lambda frame: self._state(name, frame), self._frames, self.vertices)

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

    def bodies(self, frame: int) -> Mapping[str, Body]:
        """What cloth collides with, by name, in a frame; none in caches of scenes without bodies.

        Places are in float32; otherwise like :attr:`positions`.
        """
        ranges = self._body_ranges
        if not ranges:
            self._index(frame)
            return {}
        positions = self._bodies_at_rest.copy()
        if moving := [one for one in ranges if one.moves]:
            rows, first = self._state(layout.BODY_POSITIONS, frame), 0
            for one in moving:
                own = rows[first : first + one.vertices]
                positions[one.first_vertex : one.first_vertex + one.vertices] = own
                first += one.vertices
        else:
            self._index(frame)
        return bodies_at(ranges, positions, self._body_faces)

    @cached_property
    def _bodies_at_rest(self) -> NDArray[np.float32]:
        return self._constant("bodies/rest")

    @cached_property
    def _body_faces(self) -> NDArray[np.int32]:
        faces = self._constant("bodies/faces")
        for one in self._body_ranges:
            own = faces[one.first_triangle : one.first_triangle + one.triangles] - one.first_vertex
            if own.size and not (own.min() >= 0 and own.max() < one.vertices):
                raise CacheError(
                    f"{self._path}: faces of {one.name!r} name vertices that are not there; run it again"
                )
        return faces

    @cached_property
    def _body_ranges(self) -> list[BodyRange]:
        """Which bodies there are, checked against the arrays."""
        listed = self._attributes.get("bodies", [])
        if not listed or not layout.BODY_ARRAYS.keys() <= self._arrays.keys():
            return []
        try:
            ranges = [BodyRange(**body) for body in listed]
            for one in ranges:
                one.check(*(self._arrays[name].shape[0] for name in layout.BODY_ARRAYS))
            moving = sum(one.vertices for one in ranges if one.moves)
            if moving and self._arrays[layout.BODY_POSITIONS].shape[1:] != (moving, 3):
                raise ValueError("they move, but their places have another shape")
        except (TypeError, ValueError, KeyError) as error:
            raise CacheError(f"{self._path}: its bodies are damaged ({error}); run it again") from None
        return ranges

    def stretch(self, frame: int) -> NDArray[np.float32]:
        """``|X_uv| / L - 1`` of each spring [1], shape (springs,); otherwise like :attr:`positions`."""
        return stretches(self.exact_positions(frame), self.springs, self.rest_length)

    def is_whole(self, frame: int) -> bool:
        """Whether a frame reads back as it was written: its state has the hash that was stored with it.

        Raises:
            CacheError: the numbers of the frames are damaged, the hashes among them.
        """
        stored = int(self.diagnostics["state_hash"][frame])
        try:
            state = self.local_positions(frame), self.velocities(frame)
            self.bodies(frame)
            return int(_taut.state_hash(*state, self.past(frame), self.origins(frame)), 16) == stored
        except CacheError:
            return False

    def _state(self, name: str, frame: int) -> NDArray[Any]:
        index = self._index(frame)
        values: NDArray[Any] = self.rows(name, index, index + 1)[0]
        return values

    def _index(self, frame: int) -> int:
        """The frame, counted from the start."""
        index = frame + self._frames if frame < 0 else frame
        if not 0 <= index < self._frames:
            raise IndexError(
                f"{self._path}: there is no frame {frame}; there are frames 0 to {self._frames - 1}"
            )
        return index

    def rows(self, name: str, first: int, stop: int) -> NDArray[Any]:
        """Rows of any array of :mod:`taut.cache.layout`; of those with a frame axis, frames are rows.

        Args:
            name: of the array.
            first: from 0.
            stop: the row after the last one.

        Raises:
            CacheError: a chunk is missing or damaged.
        """
        array = self._arrays[name]
        size = array.chunks[0]
        parts = [np.empty((0, *array.shape[1:]), array.dtype)]
        for chunk in range(first // size, -(-stop // size)):
            parts.append(self._chunk(name, chunk, max(first, chunk * size), min(stop, (chunk + 1) * size)))
        return np.concatenate(parts)

    def _chunk(self, name: str, chunk: int, first: int, stop: int) -> NDArray[Any]:
        """Rows of a single chunk, so that an error names its file."""
        array = self._arrays[name]
        file = self._path / name / array.metadata.encode_chunk_key((chunk, *(array.ndim - 1) * [0]))
        frames = f"frame {first}" if stop - first == 1 else f"frames {first} to {stop - 1}"
        what = f"{file}" if layout.is_constant(name) else f"{file}, {frames},"
        try:
            if not file.is_file() and not layout.may_miss(name, self._attributes["format"]):
                there = "no file" if os.path.lexists(file) else "missing"
                raise CacheError(f"{what} is {there}; run it again (--overwrite)")
            values = np.asarray(array[first:stop])
            if not self._is_own(name, first, values):
                found = "differs from its checksum, or another one is in its place"
                raise CacheError(f"{what} {found}; run it again (--overwrite)")
            return values
        except CacheError:
            raise
        except OSError as error:
            raise metadata.unreadable(file, error) from None
        except Exception as error:  # decoders raise all kinds of them
            raise CacheError(f"{what} is damaged ({error}); run it again (--overwrite)") from None

    def _is_own(self, name: str, first: int, values: NDArray[Any]) -> bool:
        """Whether rows hold what was written there, as far as the cache has checksums that say so."""
        if layout.is_constant(name):
            expected = self._arrays[name].attrs.get("checksum")
            return expected is None or expected == layout.checksum(name, 0, values)
        column = None if name == layout.CHECKSUMS else self._checksums.get(name)
        return column is None or all(
            column[row] == layout.checksum(name, row, value) for row, value in enumerate(values, first)
        )

    @cached_property
    def _checksums(self) -> dict[str, NDArray[np.uint32]]:
        """Of each array that has some, one a frame."""
        if layout.CHECKSUMS not in self._arrays:
            return {}
        names = cast(list[str], self._arrays[layout.CHECKSUMS].attrs["arrays"])
        columns = self.rows(layout.CHECKSUMS, 0, self._frames).T
        return dict(zip(names, columns, strict=True))

    def _constant(self, name: str) -> NDArray[Any]:
        return self.rows(name, 0, self._arrays[name].shape[0])

    def _indices(self, name: str) -> NDArray[np.int32]:
        values = self._constant(name)
        if values.size and not (values.min() >= 0 and values.max() < self.vertices):
            raise CacheError(f"{self._path}: {name} name vertices that are not there; run it again")
        return values


def _meant(path: Path) -> str:
    """The end of the sentence that a path is no cache: what may have been meant."""
    if path.suffix == ".toml" or is_shipped(str(path)):
        return f"; a scene is run first: taut run {path} --out {path.stem}.zarr"
    return did_you_mean(
        path.name, sorted(cache.name for cache in path.parent.glob("*.zarr") if cache != path)
    )


def _arrays(path: Path, document: dict[str, Any]) -> dict[str, zarr.Array[Any]]:
    """Every array of a cache, its type and dimensions checked."""
    kinds = {name: (kind, 1 + len(shape)) for name, (kind, shape) in layout.CONSTANT.items()}
    kinds |= {name: (kind, 1) for name, kind in layout.SERIES.items()}
    kinds |= {name: ("float32", 3) for name in layout.STATE}
    optional = layout.OPTIONAL | {
        name: (kind, 1 + len(shape)) for name, (kind, shape) in layout.BODY_ARRAYS.items()
    }
    store, arrays = LocalStore(path, read_only=True), {}
    try:
        nodes = document["consolidated_metadata"]["metadata"]
        kinds |= {name: kind for name, kind in optional.items() if name in nodes}
        missing = {name for name in layout.MAY_BE_MISSING if name not in nodes}
    except (KeyError, TypeError):
        raise CacheError(f"{path}: its {metadata.FILE} does not name its arrays; run it again") from None
    for name, (kind, dimensions) in kinds.items():
        if name in missing:
            continue
        try:
            array = layout.array(StorePath(store, name), nodes[name])
            usual = (str(array.dtype), array.ndim) == (kind, dimensions)
        except Exception:  # metadata that are read on trust may hold anything
            usual = False
        if not usual:
            raise CacheError(f"{path}: the array {name} is missing or of another type; run it again")
        arrays[name] = array
    return arrays
