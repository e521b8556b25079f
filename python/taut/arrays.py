"""What users give as arrays, checked; and arrays that they may only read."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = TypeVar("Array", bound=NDArray[Any])


def single(name: str, value: ArrayLike, shape: tuple[int, ...], kind: Any = np.float32) -> NDArray[Any]:
    """Numbers that single precision can hold, as an array of a kind.

    Raises:
        TypeError: numbers of another type.
        ValueError: a wrong shape, or a number that is not finite (which one is named).
    """
    array = np.asarray(value)
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
    array = np.atleast_1d(np.asarray(vertices))
    if array.dtype.kind not in "iu" and array.size:
        raise TypeError(f"vertices has type {array.dtype}: must be integers")
    if array.ndim != 1:
        raise ValueError(f"vertices has shape {array.shape}: must be one number, or a list of them")
    for vertex in array[(array < 0) | (array >= count)][:1]:
        raise IndexError(f"vertex = {vertex}: there are {count}, counted from 0")
    return [int(vertex) for vertex in array]


def world_places(targets: ArrayLike, count: int) -> NDArray[np.float64]:
    """A place for each of `count` vertices [m], shape (count, 3); one place alone may have the shape (3,).

    Raises:
        ValueError: a wrong shape.
    """
    array = np.ascontiguousarray(targets, np.float64)
    if array.shape == (3,) and count == 1:
        array = array.reshape(1, 3)
    if array.shape != (count, 3):
        raise ValueError(f"targets has shape {array.shape}: must be {(count, 3)}, a place for each vertex")
    return array


def triple(name: str, value: ArrayLike) -> tuple[float, float, float]:
    """Three numbers.

    Raises:
        ValueError: they are not three, or not finite.
    """
    array = np.asarray(value, np.float64)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ValueError(f"{name} = {array.tolist()}: must be three finite numbers")
    x, y, z = array.tolist()
    return x, y, z


def read_only(array: Array) -> Array:
    """The same array, not to be written any more."""
    array.flags.writeable = False
    return array
