"""What goes over the socket: headers in JSON with arrays behind them to the page, small JSON orders back."""

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

LONGEST_ORDER = 4096
"""Bytes of the longest message that a page may send."""

_KINDS = {"float32": "f4", "int32": "i4"}


class OrderError(ValueError):
    """A message of a page that cannot be obeyed; the text says what is wrong."""


def pack(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """A message for the page.

    It has three parts: the length of the header (uint32, little-endian); the header as JSON, filled up with
    blanks to four bytes; and the arrays. Their names, types and shapes stand in the header's ``arrays``.

    Args:
        header: JSON values.
        arrays: float32 or int32 arrays, in the order in which they are sent.
    """
    listed = [
        {"name": name, "type": str(array.dtype), "shape": array.shape} for name, array in arrays.items()
    ]
    text = json.dumps({**header, "arrays": listed}, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    parts = [
        np.ascontiguousarray(array, "<" + _KINDS[str(array.dtype)]).tobytes() for array in arrays.values()
    ]
    return b"".join([struct.pack("<I", len(text)), text, *parts])


def finite(value: float) -> float | None:
    """The number, or nothing where JSON has none for it."""
    return float(value) if math.isfinite(value) else None


@dataclass(frozen=True)
class Play:
    """Let time run, or stop it."""

    on: bool


@dataclass(frozen=True)
class Step:
    """Advance by one frame."""


@dataclass(frozen=True)
class Reset:
    """Go back to the start."""


@dataclass(frozen=True)
class Speed:
    """Simulated seconds for each second of the wall clock, at most [1]."""

    value: float


@dataclass(frozen=True)
class Loop:
    """Begin again at the end of a recording."""

    on: bool


@dataclass(frozen=True)
class Seek:
    """Go to a frame of a recording."""

    frame: int


@dataclass(frozen=True)
class Compare:
    """Show the bare cloth beside it."""

    on: bool


@dataclass(frozen=True)
class Set:
    """Give a control a value; :mod:`taut.view.controls` knows whether it may have it."""

    control: str
    value: float | str


@dataclass(frozen=True)
class Grab:
    """Hold a vertex and lead it to a place [m]."""

    vertex: int
    target: tuple[float, float, float]


@dataclass(frozen=True)
class Release:
    """Let it go."""


@dataclass(frozen=True)
class Pin:
    """Move a pin group so that its first vertex comes to a place [m]."""

    group: int
    target: tuple[float, float, float]


@dataclass(frozen=True)
class Drag:
    """Move a body so that the mean of its vertices comes to a place [m]."""

    body: int
    target: tuple[float, float, float]


@dataclass(frozen=True)
class Throw:
    """Throw a ball from a place through another one [m]."""

    start: tuple[float, float, float]
    target: tuple[float, float, float]


@dataclass(frozen=True)
class Contacts:
    """Send where cloth touches something with every picture, or do so no more."""

    on: bool


@dataclass(frozen=True)
class Seen:
    """The page has drawn the picture of this number and is ready for another."""

    number: int


Order = (
    Play | Step | Reset | Speed | Loop | Seek | Compare | Set
    | Grab | Release | Pin | Drag | Throw | Contacts | Seen
)  # fmt: skip

FARTHEST = 1e4
"""Largest coordinate of a target [m]."""
FASTEST = 16.0
"""Largest speed of the clock [1]."""


def parse(text: str) -> Order:
    """Read a message of a page.

    Raises:
        OrderError: it is no JSON, no order, or has fields that the order does not have.
    """
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        raise OrderError("a message must be a JSON object") from None
    if not isinstance(message, dict):
        raise OrderError("a message must be a JSON object")
    kind = message.pop("type", None)
    if not isinstance(kind, str) or kind not in _FIELDS:
        raise OrderError(f"type = {_short(kind)}: must be one of {', '.join(_FIELDS)}")
    make, fields = _FIELDS[kind]
    if message.keys() != fields.keys():
        raise OrderError(f"{kind}: must have the fields {', '.join(fields) or 'none'}")
    order: Order = make(**{name: read(f"{kind}.{name}", message[name]) for name, read in fields.items()})
    return order


def _flag(name: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise OrderError(f"{name} = {_short(value)}: must be true or false")
    return value


def _index(name: str, value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
        raise OrderError(f"{name} = {_short(value)}: must be a whole number from 0")
    return value


def _number(name: str, value: object, low: float = -1e9, high: float = 1e9) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise OrderError(f"{name} = {_short(value)}: must be a number from {low:g} to {high:g}")
    return float(value)


def _speed(name: str, value: object) -> float:
    return _number(name, value, 0.01, FASTEST)


def _place(name: str, value: object) -> tuple[float, float, float]:
    if not isinstance(value, list) or len(value) != 3:
        raise OrderError(f"{name} = {_short(value)}: must be three numbers")
    x, y, z = (_number(name, part, -FARTHEST, FARTHEST) for part in value)
    return x, y, z


def _word(name: str, value: object) -> str:
    if not isinstance(value, str) or len(value) > 40:
        raise OrderError(f"{name} = {_short(value)}: must be a word")
    return value


def _value(name: str, value: object) -> float | str:
    return _word(name, value) if isinstance(value, str) else _number(name, value)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + ".."


_FIELDS: dict[str, tuple[Any, dict[str, Any]]] = {
    "play": (Play, {"on": _flag}),
    "step": (Step, {}),
    "reset": (Reset, {}),
    "speed": (Speed, {"value": _speed}),
    "loop": (Loop, {"on": _flag}),
    "seek": (Seek, {"frame": _index}),
    "compare": (Compare, {"on": _flag}),
    "set": (Set, {"control": _word, "value": _value}),
    "grab": (Grab, {"vertex": _index, "target": _place}),
    "release": (Release, {}),
    "pin": (Pin, {"group": _index, "target": _place}),
    "drag": (Drag, {"body": _index, "target": _place}),
    "throw": (Throw, {"start": _place, "target": _place}),
    "contacts": (Contacts, {"on": _flag}),
    "seen": (Seen, {"number": _index}),
}
