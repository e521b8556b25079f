"""What comes out of a mesh file."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


class MeshError(ValueError):
    """A mesh file cannot be used. The text names the file, what is wrong with it and what is allowed."""


@dataclass(frozen=True)
class Polygons:
    """Vertices and polygons, in the order in which the file has them."""

    vertices: NDArray[np.float64]
    """In the units of the file, shape (vertices, 3)."""
    corners: NDArray[np.int64]
    """Vertex indices of all polygons, one polygon after the other, shape (corners,)."""
    counts: NDArray[np.int64]
    """How many corners each polygon has (3 or more), shape (polygons,)."""
    repairs: tuple[str, ...] = ()
    """What had to be changed to read the file, one sentence each."""
