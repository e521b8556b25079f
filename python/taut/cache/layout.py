"""Names, types and chunks of the arrays in a cache. Zarr, version 3.

Every chunk is on disk, with a checksum, whatever it holds. So a chunk that is missing or damaged is seen.
What a row holds has a checksum of its own, in which the row and its array are named. So an intact chunk in
the place of another is seen, too.

Group attributes:

- ``format`` (:data:`taut.cache.metadata.FORMAT`), ``version`` of taut, ``scene`` (resolved), ``title``,
  ``warnings``
- ``cloths``: ``[{name, first_vertex, vertices}]``
- ``bodies``, if there are any: ``[{name, shape, radius, moves, first_vertex, vertices, first_triangle,
  triangles}]``, see :class:`taut.bodies.Body`; they count in `bodies/rest` and in `bodies/faces`
- ``substeps`` [1], ``step_length`` [s], ``threads`` [1]
- ``meshes``: path to SHA-256 of the geometry
- ``state_hash`` of the last frame, 16 hexadecimal digits
- ``checksum`` of the metadata: :data:`taut.cache.metadata.CHECKSUM`
"""

import json
import zlib
from collections.abc import Container
from functools import lru_cache
from typing import Any

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.abc.buffer import Buffer
from zarr.codecs import BloscCodec, Crc32cCodec
from zarr.storage import MemoryStore, StorePath

from taut.cache import metadata
from taut.cache.header import Header

ATTRIBUTES: dict[str, type] = {
    "version": str,
    "scene": dict,
    "title": str,
    "warnings": list,
    "cloths": list,
    "substeps": int,
    "step_length": float,
    "threads": int,
    "meshes": dict,
    "state_hash": str,
}
"""Type of each attribute of the group; it also has ``format`` and ``checksum``."""

STATE = ("positions", "velocities")
"""float32, shape (frames, vertices, 3), one chunk a frame [m], [m/s]; velocities are those of the motion."""

CONSTANT: dict[str, tuple[str, tuple[int, ...]]] = {
    "faces": ("int32", (3,)),
    "springs": ("int32", (2,)),
    "spring_kind": ("uint8", ()),
    "rest_length": ("float32", ()),
    "strain_limit": ("float32", ()),
    "pins": ("int32", ()),
}
"""Type and shape of an element of each array without a frame axis."""

DIAGNOSTICS: dict[str, str] = {
    "worst_stretch": "float64",
    "worst_spring": "int32",
    "worst_stretch_in_steps": "float64",
    "worst_spring_in_steps": "int32",
    "limited_steps": "int32",
    "limited_springs": "int64",
    "sweeps": "int64",
    "cuts": "int32",
    "held_back_pins": "int32",
    "pinched": "int64",
    "held_back_bodies": "int32",
    "lost_motion": "float64",
    "mean_lost_motion": "float64",
    "contacts": "int64",
    "contact_cuts": "int32",
    "halved_steps": "int32",
    "closest": "float64",
    "penetrations": "int32",
    "asleep": "bool",
    "detection_ms": "float64",
    "solve_ms": "float64",
    "certificate_ms": "float64",
    "kinetic_energy": "float64",
    "elastic_energy": "float64",
    "potential_energy": "float64",
    "ms": "float64",
    "state_hash": "uint64",
}
"""Type of each array in the group ``diagnostics``, shape (frames,): :class:`taut.cache.Frame`'s numbers.

The ones whose names end in ``ms`` are wall-clock times [ms]; in all others a run has the same numbers again
when it is repeated."""

ADDED: dict[str, float] = {
    "pinched": 0,
    "held_back_bodies": 0,
    "contacts": 0,
    "contact_cuts": 0,
    "halved_steps": 0,
    "closest": float("inf"),
    "penetrations": 0,
    "asleep": False,
    "detection_ms": 0,
    "solve_ms": 0,
    "certificate_ms": 0,
}
"""Those of them that caches from before they were written lack, and what they stand for in every frame."""

SERIES: dict[str, str] = {"time": "float64"} | {
    f"diagnostics/{name}": kind for name, kind in DIAGNOSTICS.items()
}
"""Type of each array with one number a frame."""

MAY_BE_MISSING = {f"diagnostics/{name}" for name in ADDED}
"""Those of them that a cache may lack."""

SERIES_CHUNK = 1024

PAST = "past"
"""float32, shape (frames, n, 3), one chunk a frame; only there if a run needs it to go on:
:attr:`taut.Simulation.past`. With the filter ``coarse_to_fine`` the integrator has velocities of its own
beside those of the motion, and each cloth a row of its own."""

ORIGINS = "origins"
"""float64, shape (frames, cloths, 3): where the coordinates of each cloth begin in a frame [m]. Caches of
taut 0.1.0 and before have none: all are zero."""

LOCAL = "local_positions"
"""float32, shape (frames, vertices, 3), one chunk a frame: positions from the origin of each cloth [m], which
a run needs to go on. Where all origins are zero they are `positions`; the array is not on disk then and
reads as NaN. Caches of taut 0.1.0 and before have none."""

CHECKSUMS = "checksums"
"""uint32, shape (frames, arrays): :func:`checksum` of each row; its attribute `arrays` names the columns."""

BODY_ARRAYS: dict[str, tuple[str, tuple[int, ...]]] = {
    "bodies/rest": ("float32", (3,)),
    "bodies/faces": ("int32", (3,)),
}
"""Type and shape of an element of the arrays without a frame axis that caches of scenes with bodies have:
places of the vertices of all bodies in frame 0, in the world [m], and triangles of all of them."""

BODY_POSITIONS = "bodies/positions"
"""float32, shape (frames, n, 3), one chunk a frame: places of the vertices of those bodies that may move, one
body after the other, in the world [m]. Only there if a body may move; the others are where they were in
frame 0. A run does not need it to go on."""

GROWING = (*SERIES, "velocities", "positions")
"""Every array with a frame axis but :data:`OPTIONAL`, in the order in which a new frame is made known."""

OPTIONAL: dict[str, tuple[str, int]] = {
    CHECKSUMS: ("uint32", 2),
    PAST: ("float32", 3),
    ORIGINS: ("float64", 3),
    LOCAL: ("float32", 3),
    BODY_POSITIONS: ("float32", 3),
}
"""Type and dimensions of each array with a frame axis that a cache may do without."""

_MAY_BE_ZERO = {"spring_kind", "pins", LOCAL} | {
    name for name, kind in SERIES.items() if not kind.startswith("float")
}


def may_miss(name: str, format: str) -> bool:
    """Whether a chunk of an array may not be on disk, and stands for zeros then."""
    return format == metadata.TRUSTED and name in _MAY_BE_ZERO


def growing(nodes: Container[str]) -> list[str]:
    """Those of `nodes` that are arrays with a frame axis, in the order in which a frame is made known."""
    always = (name for name in GROWING if name in nodes or name not in MAY_BE_MISSING)
    return [*(name for name in OPTIONAL if name in nodes), *always]


def is_constant(name: str) -> bool:
    """Whether an array has no frame axis."""
    return name in CONSTANT or name in BODY_ARRAYS


def checksum(name: str, row: int, values: NDArray[Any]) -> int:
    """CRC-32 of what a row of an array holds and of which row that is. A constant array is row 0."""
    which = f"{name} {row} {values.dtype} {values.shape}"
    return zlib.crc32(np.ascontiguousarray(values).tobytes(), zlib.crc32(which.encode()))


def array(place: StorePath, node: dict[str, Any]) -> zarr.Array[Any]:
    """The array at a place, of which this is the ``zarr.json``."""
    return zarr.Array(zarr.AsyncArray(_parsed(json.dumps(node)), place))


@lru_cache(maxsize=256)
def _parsed(node: str) -> Any:
    # Zarr takes a millisecond over each, and most of a cache's arrays are alike.
    return zarr.Array.from_dict(StorePath(MemoryStore()), json.loads(node)).metadata


def empty(header: Header) -> dict[str, bytes]:
    """The files of a cache without frames."""
    files: dict[str, Buffer] = {}
    attributes = {"format": metadata.FORMAT, **header.attributes, "state_hash": ""}
    root = zarr.create_group(MemoryStore(files), attributes=attributes)
    root.create_group("diagnostics")
    constant = CONSTANT
    if header.bodies:
        root.create_group("bodies")
        constant = CONSTANT | BODY_ARRAYS
    for name, (kind, _) in constant.items():
        data = np.ascontiguousarray(header.arrays[name], kind)
        chunk = tuple(max(1, size) for size in data.shape)
        array = root.create_array(name, shape=data.shape, chunks=chunk, **_coding(kind))
        array[...] = data
        array.attrs["checksum"] = checksum(name, 0, data)
    rows = dict.fromkeys((*STATE, LOCAL), header.vertices)
    rows |= {name: n for name, n in ((PAST, header.past), (BODY_POSITIONS, header.moving)) if n}
    for name, vertices in rows.items():
        root.create_array(name, shape=(0, vertices, 3), chunks=(1, vertices, 3), **_coding("float32"))
    chunk = (SERIES_CHUNK, max(1, header.cloths), 3)
    root.create_array(ORIGINS, shape=(0, header.cloths, 3), chunks=chunk, **_coding("float64"))
    for name, kind in SERIES.items():
        root.create_array(name, shape=(0,), chunks=(SERIES_CHUNK,), **_coding(kind))
    names = [*rows, ORIGINS, *SERIES]
    root.create_array(
        CHECKSUMS,
        shape=(0, len(names)),
        chunks=(SERIES_CHUNK, len(names)),
        attributes={"arrays": names},
        **_coding("uint32"),
    )
    return _with_all_metadata({name: content.to_bytes() for name, content in files.items()})


def _with_all_metadata(files: dict[str, bytes]) -> dict[str, bytes]:
    end = f"/{metadata.FILE}"
    nodes = {name.removesuffix(end): json.loads(files[name]) for name in files if name.endswith(end)}
    consolidated = {"kind": "inline", "must_understand": False, "metadata": nodes}
    document = json.loads(files[metadata.FILE]) | {"consolidated_metadata": consolidated}
    return files | {metadata.FILE: metadata.encoded(document)}


def _coding(kind: str) -> dict[str, Any]:
    # Every chunk carries a checksum, and is written even where it holds nothing but zeros.
    # One flat folder for each array: a folder for each frame would double the files to flush.
    return {
        "dtype": kind,
        "fill_value": float("nan") if kind.startswith("float") else 0,
        "compressors": [BloscCodec(cname="zstd", clevel=3, shuffle="shuffle"), Crc32cCodec()],
        "chunk_key_encoding": {"name": "default", "separator": "."},
        "config": {"write_empty_chunks": True},
    }
