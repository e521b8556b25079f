"""What users give as numbers and arrays, checked; and arrays that they may only read."""

import math
import operator
import reprlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FARTHEST = 1e9
"""Places beyond this are refused [m]: single precision tells them 64 m apart."""

SPEED = "a speed above 0 [m/s] that single precision can hold"
"""What speeds must be."""
SLOWEST = float(np.finfo(np.float32).tiny)
"""The lowest speed [m/s]."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 40
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxarray = 4


def shown(value: object) -> str:
    """A value as errors show it: short, in one line."""
    if isinstance(value, int) and abs(value) >= 10**20:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, np.ndarray) and value.size > 4:
        return f"an array of shape {value.shape} and type {value.dtype}"
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    return " ".join(_SHORT.repr(value).split())


def single(name: str, value: ArrayLike, shape: tuple[int, ...], kind: Any = np.float32) -> NDArray[Any]:
    """Numbers that single precision can hold, as an array of a kind.

    Raises:
        TypeError: numbers of another type.
        ValueError: a wrong shape, or a number that is not finite (which one is named).
    """
    array = _array(name, value, f"an array of float32 or float64, shape {shape}")
    if array.dtype.kind != "f":
        raise TypeError(
            f"{name} has type {array.dtype}: must be float32 or float64; try array.astype('float32')"
        )
    if array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}: must be {shape}, (vertices, 3)")
    with np.errstate(over="ignore"):
        numbers = np.ascontiguousarray(array, np.float32)
    bad = np.argwhere(~np.isfinite(numbers))
    if bad.size:
        vertex, axis = bad[0]
        number = array[vertex, axis]
        raise ValueError(f"{name}[{vertex}, {axis}] = {number}: must be finite in float32")
    return np.ascontiguousarray(array, kind)


def chosen(vertices: ArrayLike, count: int) -> list[int]:
    """One vertex or several, as a list.

    Raises:
        IndexError: one is not among the first `count`.
        TypeError: they are no integers.
        ValueError: they are more than a list.
    """
    array = np.atleast_1d(_array("vertices", vertices, "one integer, or a list of them"))
    # Integers of more than 64 bits make an array of objects: none of them is a vertex.
    large = array.size and all(isinstance(number, int) for number in array.flat)
    if array.dtype.kind not in "iu" and array.size and not large:
        raise TypeError(f"vertices has type {array.dtype}: must be integers")
    if array.ndim != 1:
        raise ValueError(f"vertices has shape {array.shape}: must be one number, or a list of them")
    for vertex in array[(array < 0) | (array >= count)][:1]:
        raise IndexError(f"vertex = {shown(vertex)}: there are {count}, counted from 0")
    return [int(vertex) for vertex in array]


def world_places(places: ArrayLike, count: int, name: str = "targets") -> NDArray[np.float64]:
    """A place for each of `count` vertices [m], shape (count, 3); one place alone may have the shape (3,).

    Raises:
        TypeError: they are no numbers.
        ValueError: a wrong shape, or a number that is not finite or too large.
    """
    array = _reals(name, places, f"numbers of shape {(count, 3)}, a place [m] for each vertex")
    if array.shape == (3,) and count == 1:
        array = array.reshape(1, 3)
    if array.shape != (count, 3):
        raise ValueError(f"{name} has shape {array.shape}: must be {(count, 3)}, a place for each vertex")
    for index in np.flatnonzero(~np.isfinite(array).all(axis=1))[:1]:
        raise ValueError(f"{name}[{index}] is not finite: {shown(array[index])} must be numbers [m]")
    for index in np.flatnonzero((abs(array) > FARTHEST).any(axis=1))[:1]:
        raise ValueError(
            f"{name}[{index}] = {shown(array[index])}: must be within {FARTHEST:g} m of the origin"
        )
    return array


def triple(name: str, value: ArrayLike, largest: float = math.inf) -> tuple[float, float, float]:
    """Three numbers.

    Args:
        name: what they are, for errors.
        value: a sequence.
        largest: none may be larger than this, whatever its sign.

    Raises:
        TypeError: they are no numbers.
        ValueError: they are not three, not finite, or too large.
    """
    allowed = "must be three finite numbers"
    if largest < math.inf:
        allowed += f" from {-largest:g} to {largest:g}"
    array = _reals(name, value, "three finite numbers")
    if array.shape != (3,):
        raise ValueError(f"{name} = {shown(value)}: has shape {array.shape}, {allowed}, shape (3,)")
    if not np.isfinite(array).all() or (abs(array) > largest).any():
        raise ValueError(f"{name} = {shown(value)}: {allowed}")
    x, y, z = array.tolist()
    return x, y, z


def real(name: str, value: object, allowed: str, least: float | None = None) -> float:
    """One number; `allowed` says which ones.

    Raises:
        TypeError: it is none.
        ValueError: it is beyond double precision, or below `least`.
    """
    try:
        number = math.nan if isinstance(value, str | bytes) else float(value)  # type: ignore[arg-type]
        if isinstance(value, str | bytes) or np.ndim(value):  # type: ignore[arg-type]
            raise TypeError
    except OverflowError:
        raise ValueError(f"{name} = {shown(value)}: must be {allowed}") from None
    except (TypeError, ValueError):
        raise TypeError(f"{name} = {shown(value)}: is a {type(value).__name__}; must be {allowed}") from None
    if least is not None and not number >= least:
        raise ValueError(f"{name} = {shown(value)}: must be {allowed}")
    return number


def whole(name: str, value: object, allowed: str, least: float = 0, most: float = math.inf) -> int:
    """One whole number from `least` to `most`; `allowed` says so.

    Raises:
        TypeError: it is none.
        ValueError: it is out of range.
    """
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name} = {shown(value)}: is a {type(value).__name__}; must be {allowed}") from None
    if not least <= number <= most:
        raise ValueError(f"{name} = {shown(number)}: must be {allowed}")
    return number


def entry(name: str, value: object, count: int) -> int:
    """One index from 0.

    Raises:
        IndexError: it is not below `count`.
        TypeError: it is no integer.
    """
    number = whole(name, value, f"an integer from 0 to {count - 1}", -math.inf)
    if not 0 <= number < count:
        raise IndexError(f"{name} = {shown(number)}: there are {count}, counted from 0")
    return number


def stretches(
    places: NDArray[np.float64], springs: NDArray[np.int32], rest_length: NDArray[np.float32]
) -> NDArray[np.float32]:
    """``|X_uv| / L - 1`` of each spring [1], shape (springs,)."""
    x, y, z = (places[springs[:, 1]] - places[springs[:, 0]]).T
    length = np.sqrt(x * x + y * y + z * z)
    return np.asarray(length / rest_length - 1.0, np.float32)


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """A view of the same numbers that cannot be made writable, as one of an array of NumPy's could."""
    return np.asarray(memoryview(array.data).toreadonly())


def _array(name: str, value: ArrayLike, allowed: str) -> NDArray[Any]:
    try:
        return np.asarray(value)
    except (TypeError, ValueError):
        raise ValueError(
            f"{name} = {shown(value)}: its parts have different shapes; must be {allowed}"
        ) from None


def _reals(name: str, value: ArrayLike, allowed: str) -> NDArray[np.float64]:
    array = _array(name, value, allowed)
    if array.size and array.dtype.kind not in "fiu":
        kind = f"holds values of type {array.dtype}"
        if all(isinstance(number, int) for number in array.flat):
            raise ValueError(f"{name} = {shown(value)}: holds a number that is too large; must be {allowed}")
        raise TypeError(f"{name} = {shown(value)}: {kind}; must be {allowed}")
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(array, np.float64)
