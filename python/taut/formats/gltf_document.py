"""The JSON of a glTF file and the bytes that belong to it; every entry that is asked for is checked."""

import base64
import json
import struct
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.arrays import shown
from taut.formats.polygons import AGAIN, MeshError, refusal

_HEAD = struct.Struct("<4sII")  # magic, version, bytes of the file
_CHUNK = struct.Struct("<I4s")  # bytes that follow, kind
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_EMBED = "save it as .glb, or as glTF with embedded data"


class Entry:
    """A table of the JSON, and where it stands."""

    def __init__(self, document: "Document", table: Any, where: str) -> None:
        """Refuses what is no table."""
        self.document, self.where = document, where
        if not isinstance(table, dict):
            raise self.refusal(f"is {shown(table)}: must be a table")
        self.table: dict[str, Any] = table

    def refusal(self, what: str, remedy: str = AGAIN) -> MeshError:
        """The error about it."""
        return refusal(self.document.name, f"{self.where} {what}", remedy)

    def integer(self, key: str, default: int | None = None) -> int:
        """A number from 0."""
        value = self.table.get(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or value < 0:
            raise self.refusal(f"has {key} = {shown(value)}: must be an integer, 0 or more")
        return value

    def index(self, key: str, kind: str) -> int:
        """The index of an entry of a kind."""
        index = self.integer(key)
        self.document.entry(kind, index, f"{self.where}.{key}")
        return index

    def reals(self, key: str, default: list[float]) -> list[float]:
        """As many finite numbers as are there by default."""
        if key not in self.table:
            return default
        value = self.table[key]
        if (
            not isinstance(value, list)
            or len(value) != len(default)
            or not all(isinstance(one, int | float) and not isinstance(one, bool) for one in value)
            or not all(abs(one) <= sys.float_info.max for one in value)
        ):
            raise self.refusal(f"has {key} = {shown(value)}: must be {len(default)} finite numbers")
        return [float(one) for one in value]

    def list_of(self, key: str) -> list[Any]:
        """A list; empty where there is none."""
        value = self.table.get(key, [])
        if not isinstance(value, list):
            raise self.refusal(f"has {key} = {shown(value)}: must be a list")
        return value

    def indices(self, key: str, kind: str) -> list[int]:
        """The indices of entries of a kind."""
        found = self.list_of(key)
        for place, index in enumerate(found):
            if not isinstance(index, int) or isinstance(index, bool):
                raise self.refusal(f"has {key}[{place}] = {shown(index)}: must be an index into {kind}")
        return found

    def tables(self, key: str) -> list["Entry"]:
        """The tables of a list."""
        found = self.list_of(key)
        return [Entry(self.document, one, f"{self.where}.{key}[{place}]") for place, one in enumerate(found)]

    def table_of(self, key: str) -> "Entry":
        """A table in it."""
        return Entry(self.document, self.table.get(key), f"{self.where}.{key}")


class Document:
    """A glTF file."""

    def __init__(self, name: str, text: bytes, chunk: bytes | None) -> None:
        """Reads the JSON; ``chunk``: the data that a binary file has besides."""
        self.name, self.chunk = name, chunk
        self.top = Entry(self, _parsed(name, text), "its JSON")
        self.buffers: dict[int, bytes] = {}
        version = self.top.table_of("asset").table.get("version")
        if not isinstance(version, str) or not version.startswith("2."):
            raise self.top.refusal(
                f"has asset.version = {shown(version)}: must be 2.0", "export it as glTF 2.0"
            )

    def entry(self, kind: str, index: int, asking: str) -> Entry:
        """One of the lists of the JSON."""
        entries = self.top.list_of(kind)
        if not 0 <= index < len(entries):
            raise refusal(self.name, f"{asking} asks for {kind}[{shown(index)}]: there are {len(entries)}")
        return Entry(self, entries[index], f"{kind}[{index}]")

    def numbers(self, asking: Entry, key: str, shape: str, types: Mapping[int, str]) -> NDArray[Any]:
        """The numbers of an accessor, shape (count, width)."""
        accessor = self.entry("accessors", asking.integer(key), f"{asking.where}.{key}")
        if "sparse" in accessor.table or "bufferView" not in accessor.table:
            what = "is sparse" if "sparse" in accessor.table else "has no bufferView of its own"
            raise accessor.refusal(what, "export it without compression and without sparse accessors")
        kind, component = accessor.table.get("type"), accessor.integer("componentType")
        if kind != shape or component not in types:
            given = f"has the type {shown(kind)} of components {shown(component)}"
            allowed = f"{shape} of {' or '.join(map(str, types))}"
            raise accessor.refusal(f"{given}: {key} must be {allowed}", "export it without quantization")
        dtype, width, count = np.dtype(types[component]), _WIDTHS[shape], accessor.integer("count")
        view = self.entry("bufferViews", accessor.integer("bufferView"), accessor.where)
        data = self._bytes_of(view)
        row, start = width * dtype.itemsize, accessor.integer("byteOffset", default=0)
        stride = view.integer("byteStride", default=row)
        if count < 1 or stride < row:
            given = f"{shown(count)} rows of {shown(stride)} bytes"
            raise accessor.refusal(f"has {given}: must be 1 or more of {row} or more")
        needed = start + (count - 1) * stride + row
        if needed > len(data):
            raise accessor.refusal(f"needs {shown(needed)} bytes of {view.where}, which has {len(data)}")
        return np.ndarray((count, width), dtype, data, start, (stride, dtype.itemsize))

    def _bytes_of(self, view: Entry) -> memoryview:
        buffer = self.entry("buffers", view.integer("buffer"), view.where)
        index = view.integer("buffer")
        if index not in self.buffers:
            self.buffers[index] = self._buffer(buffer, index)
        data = self.buffers[index]
        start, size = view.integer("byteOffset", default=0), view.integer("byteLength")
        if start + size > len(data):
            end = shown(start + size)
            raise view.refusal(f"goes to byte {end} of {buffer.where}, which has {len(data)} bytes")
        return memoryview(data)[start : start + size]

    def _buffer(self, buffer: Entry, index: int) -> bytes:
        uri = buffer.table.get("uri")
        if uri is None and index == 0 and self.chunk is not None:
            data = self.chunk
        elif uri is None:
            raise buffer.refusal("has no uri and no data", _EMBED)
        elif not isinstance(uri, str) or not uri.startswith("data:"):
            raise buffer.refusal(f"lies in another file, {shown(uri)}, which is not opened", _EMBED)
        else:
            head, separator, text = uri.partition("base64,")
            try:
                data = base64.b64decode(text, validate=True)
            except ValueError:
                separator = ""
            if not separator:
                raise buffer.refusal(f"has damaged base64 data, `{shown(head)}`: must be `data:..;base64,..`")
        size = buffer.integer("byteLength")
        if size > len(data):
            raise buffer.refusal(f"is cut short: it must have {shown(size)} bytes, there are {len(data)}")
        return data[:size]


def from_gltf(name: str, data: bytes) -> Document:
    """A file that is JSON."""
    return Document(name, data, None)


def from_glb(name: str, data: bytes) -> Document:
    """A binary file: a head, a chunk of JSON, and one of other data perhaps."""
    if len(data) < _HEAD.size + _CHUNK.size or not data.startswith(b"glTF"):
        raise refusal(
            name, f"is no binary glTF file: must begin with `glTF` and have {_HEAD.size + _CHUNK.size} bytes"
        )
    _, version, size = _HEAD.unpack_from(data)
    if version != 2:
        raise refusal(name, f"has the version {version} of binary glTF: must be 2", "export it as glTF 2.0")
    if size != len(data):
        what = "is cut short" if size > len(data) else "is too long"
        raise refusal(name, f"{what}: its head says {size} bytes, there are {len(data)}")
    chunks: list[tuple[bytes, bytes]] = []
    at = _HEAD.size
    while at + _CHUNK.size <= len(data):
        length, kind = _CHUNK.unpack_from(data, at)
        at += _CHUNK.size
        if at + length > len(data):
            left = len(data) - at
            raise refusal(name, f"the chunk at byte {at} has a length of {length} bytes, and {left} are left")
        chunks.append((kind, data[at : at + length]))
        at += length
    if chunks[0][0] != b"JSON":
        raise refusal(name, f"its first chunk has the kind {shown(chunks[0][0])}: must be b'JSON'")
    return Document(name, chunks[0][1], next((content for kind, content in chunks if kind == b"BIN\0"), None))


def _parsed(name: str, text: bytes) -> Any:
    try:
        return json.loads(text.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        what = f"byte {error.start} of its JSON is no UTF-8"
    except json.JSONDecodeError as error:
        what = f"its JSON is damaged in line {error.lineno}, column {error.colno}"
    except ValueError:
        what = "its JSON holds a number of too many digits"
    except RecursionError:
        what = "its JSON is nested too deeply"
    raise refusal(name, what)
