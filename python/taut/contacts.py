"""Where cloth touches something, and how hard."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """Where cloth was pushed by what it touches in the last step: a row of each array for each place."""

    vertices: NDArray[np.int32]
    """The vertex of the cloth nearest to it, index into :attr:`taut.Simulation.positions`, shape (n,)."""
    bodies: NDArray[np.int32]
    """What it touches: index into the bodies of the scene, -1 for cloth; shape (n,)."""
    positions: NDArray[np.float64]
    """The place on the cloth, in the world [m], shape (n, 3)."""
    normals: NDArray[np.float64]
    """The way in which the cloth is pushed, of length 1, shape (n, 3)."""
    forces: NDArray[np.float64]
    """How hard it is pushed along the normal, on the mean of the step [N], shape (n,)."""
    friction: NDArray[np.float64]
    """What friction adds to that, across the normal [N], shape (n, 3)."""

    def __len__(self) -> int:
        """How many places there are."""
        return len(self.forces)


def contacts_of(told: tuple[NDArray[Any], ...]) -> Contacts:
    """From what the engine tells."""
    return Contacts(*told)
