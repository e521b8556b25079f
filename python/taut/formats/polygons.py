"""What comes out of a mesh file, and what is said where it cannot be used."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vertices = NDArray[np.float64]
"""Shape (vertices, 3)."""
Integers = NDArray[np.int64]
"""Indices or counts."""

AGAIN = "export the mesh again, or as OBJ"
"""What helps where a file is damaged."""


class MeshError(ValueError):
    """A mesh file cannot be used. The text names the file, what is wrong with it and what is allowed."""


@dataclass(frozen=True)
class Polygons:
    """Vertices and polygons, in the order in which the file has them."""

    vertices: Vertices
    """In the units of the file, shape (vertices, 3)."""
    corners: Integers
    """Vertex indices of all polygons, one polygon after the other, shape (corners,)."""
    counts: Integers
    """How many corners each polygon has (3 or more), shape (polygons,)."""
    repairs: tuple[str, ...] = ()
    """What had to be changed to read the file, one sentence each."""


def refusal(name: str, what: str, remedy: str = AGAIN) -> MeshError:
    """The error about a file; its name may have a line, as in ``shirt.off:12``."""
    return MeshError(f"{name}: {what}; {remedy}")


def check_numbers(name: str, vertices: Vertices, corners: Integers, counts: Integers) -> None:
    """Refuse coordinates that are not finite, polygons of two and indices that lead nowhere.

    Raises:
        MeshError: vertex and face are counted from 0.
    """
    if len(vertices) == 0:
        raise refusal(name, "holds no vertices")
    if len(counts) == 0:
        raise refusal(name, "holds no faces", "export the mesh with its faces")
    for bad in np.flatnonzero(~np.isfinite(vertices).all(axis=1))[:1]:
        raise refusal(name, f"vertex {bad} is {vertices[bad].tolist()}: must be finite numbers")
    for bad in np.flatnonzero(counts < 3)[:1]:
        raise refusal(name, f"face {bad} has {counts[bad]} corners: must have 3 or more")
    for bad in np.flatnonzero((corners < 0) | (corners >= len(vertices)))[:1]:
        face = int(np.searchsorted(np.cumsum(counts), bad, side="right"))
        allowed = f"indices must be from 0 to {len(vertices) - 1}"
        raise refusal(name, f"face {face} has a corner {corners[bad]}: {allowed}")
