"""What a cache holds besides its frames, and one frame on its way into it."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.report import Report


@dataclass(frozen=True)
class Header:
    """Everything about a run that is the same in all its frames."""

    attributes: Mapping[str, Any]
    """Attributes of the group except `format` and `state_hash`: :data:`taut.cache.layout.ATTRIBUTES`, and
    `bodies` if there are any."""
    arrays: Mapping[str, NDArray[Any]]
    """The arrays without a frame axis, see :data:`taut.cache.layout.CONSTANT`; if there are bodies,
    :data:`taut.cache.layout.BODY_ARRAYS` too."""
    vertices: int
    """Vertices in each frame [1]."""
    past: int = 0
    """Rows that a frame has in the array `past` [1]; it has none where the state is whole without it."""

    @property
    def cloths(self) -> int:
        """Cloths [1]."""
        return len(self.attributes["cloths"])

    @property
    def bodies(self) -> int:
        """Bodies [1]."""
        return len(self.attributes.get("bodies", ()))

    @property
    def moving(self) -> int:
        """Vertices of bodies that may move [1]."""
        return sum(body["vertices"] for body in self.attributes.get("bodies", ()) if body["moves"])


@dataclass(frozen=True)
class Frame:
    """One frame to be written."""

    positions: NDArray[np.float32]
    """[m], shape (vertices, 3)."""
    velocities: NDArray[np.float32]
    """Those of the motion [m/s], shape (vertices, 3)."""
    report: Report
    """What happened since the frame before."""
    ms: float
    """Wall-clock time of the simulation of this frame alone [ms]; 0 for frame 0."""
    state_hash: str
    """:attr:`taut.Simulation.state_hash`, 16 hexadecimal digits."""
    past: NDArray[np.float32] | None = None
    """:attr:`taut.Simulation.past`, shape (n, 3)."""
    origins: NDArray[np.float64] | None = None
    """:attr:`taut.Simulation.origins`, shape (cloths, 3); nothing if all are zero."""
    local_positions: NDArray[np.float32] | None = None
    """:attr:`taut.Simulation.local_positions`, shape (vertices, 3); nothing if they are the positions."""
    bodies: NDArray[np.floating] | None = None
    """Places of the vertices of those bodies that may move [m], shape (n, 3); nothing if none may."""


def mesh_hash(mesh: tuple[NDArray[Any], ...]) -> str:
    """SHA-256 of the arrays of a mesh or of a path, as hexadecimal digits."""
    digest = hashlib.sha256()
    for array in mesh:
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
