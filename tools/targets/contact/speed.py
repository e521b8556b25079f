"""The row about what contact costs: a frame with it against one without; garments in real time."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tools.targets.contact.scenes import Stage

FRAME = 1e3 / 60  # [ms]
COST, WORST, EXPONENT = 3.0, 3.0, 1.1
SIZES = (33, 65, 129)
"""Vertices along a side of what shows the growth."""
FRAMES = 300


@dataclass(slots=True)
class Timed:
    """A scene that is timed, several times."""

    name: str
    made: Stage
    without: tuple[str, ...] = ()
    fields: dict[str, object] = field(default_factory=dict)
    runs: list[NDArray[np.float64]] = field(default_factory=list)
