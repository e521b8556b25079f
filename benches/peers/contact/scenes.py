"""The scenes with contact: a square sheet of 1 m and 0.2 kg falls on a ball, on a corner, on its own edge.

z points up; lengths are in metres. All bodies are fixed, and every scene has a floor at z = 0.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheet import Reals, Sheet

FRAMES = 120
"""Frames of a full run: 2 s."""
THICKNESS = 0.004
"""Mid-surfaces of cloth are this far apart [m]; a mid-surface is half of it off bodies."""
FRICTION = 0.4
"""Coulomb's coefficient, of cloth on bodies and on cloth [1]."""


@dataclass(frozen=True)
class Ball:
    """A ball."""

    centre: tuple[float, float, float]
    radius: float

    def as_job(self) -> dict[str, Any]:
        """What an adapter needs."""
        return {"kind": "ball", "centre": list(self.centre), "radius": self.radius}


@dataclass(frozen=True)
class Box:
    """A block, turned about the x, then the y axis."""

    centre: tuple[float, float, float]
    half: tuple[float, float, float]
    """Half of its widths [m]."""
    turned: tuple[float, float]
    """Angles about x and y [degrees]."""

    @property
    def axes(self) -> Reals:
        """Its own axes as columns, shape (3, 3)."""
        return turn(*self.turned)

    def as_job(self) -> dict[str, Any]:
        """What an adapter needs."""
        w, x, y, z = self._quaternion
        return {
            "kind": "box",
            "centre": list(self.centre),
            "half": list(self.half),
            "turned": list(self.turned),
            "axes": self.axes.tolist(),
            "quaternion": [w, x, y, z],
        }

    @property
    def _quaternion(self) -> tuple[float, float, float, float]:
        """The same rotation, w first."""
        (cx, sx), (cy, sy) = (
            (float(np.cos(half)), float(np.sin(half))) for half in np.radians(self.turned) / 2
        )
        return cy * cx, cy * sx, sy * cx, -sy * sx


@dataclass(frozen=True)
class Floor:
    """All below a height."""

    height: float = 0.0

    def as_job(self) -> dict[str, Any]:
        """What an adapter needs."""
        return {"kind": "floor", "height": self.height}


Body = Ball | Box | Floor


def turn(about_x: float, about_y: float) -> Reals:
    """The matrix of a rotation about x, then y [degrees]."""
    a, b = np.radians([about_x, about_y])
    first = [[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]]
    second = [[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]]
    return np.array(second) @ np.array(first)


@dataclass(frozen=True)
class Setting:
    """Where the sheet starts, and what else there is."""

    origin: tuple[float, float, float]
    """Where the sheet's first corner is, before it is turned about the world's origin [m]."""
    turned: tuple[float, float]
    """Angles about x and y [degrees]."""
    moved: tuple[float, float, float]
    """Where it goes then [m]."""
    bodies: tuple[Body, ...]


CORNER_UP = (45.0, -float(np.degrees(np.arctan(np.sqrt(0.5)))))
"""Turns a cube so that a corner is at its top [degrees]."""

SETTINGS = {
    "ball": Setting((-0.47, -0.51, 0.9), (0.0, 0.0), (0.0, 0.0, 0.0), (Ball((0.0, 0.0, 0.4), 0.3), Floor())),
    "corner": Setting(
        (-0.49, -0.51, 0.9),
        (0.0, 0.0),
        (0.0, 0.0, 0.0),
        (Box((0.0, 0.0, 0.35), (0.2, 0.2, 0.2), CORNER_UP), Floor()),
    ),
    "heap": Setting((-0.5, -0.5, 0.0), (86.0, 3.0), (0.0, 0.0, 0.6), (Floor(),)),
}
CONTACT_SCENES = tuple(SETTINGS)
"""On a ball, on the upper corner of a cube, and on its own lower edge, a little askew."""


class ContactSheet(Sheet):
    """The sheet in one of these scenes; nothing holds it."""

    def __init__(self, scene: str, size: int) -> None:
        """Lay it out.

        Args:
            scene: one of :data:`CONTACT_SCENES`.
            size: particles along an edge [1], at least 2.

        Raises:
            ValueError: there is no such scene, or the size is too small.
        """
        if scene not in SETTINGS:
            raise ValueError(f"scene = {scene!r}: must be one of {', '.join(CONTACT_SCENES)}")
        super().__init__("one-corner", size)
        self.scene = scene
        self.setting = SETTINGS[scene]
        self.flat: Reals = self.positions
        """Places in the plane of the sheet, z = 0 [m]."""
        laid = self.flat + np.array(self.setting.origin)
        self.positions = laid @ turn(*self.setting.turned).T + np.array(self.setting.moved)

    @property
    def pins(self) -> list[int]:
        """None."""
        return []

    @property
    def bodies(self) -> tuple[Body, ...]:
        """What it can touch."""
        return self.setting.bodies

    def as_job(self) -> dict[str, Any]:
        """What an adapter needs to build it; see ``adapters/harness.py``."""
        return super().as_job() | {
            "diagonals": self.other_diagonal.tolist(),
            "bodies": [body.as_job() for body in self.bodies],
            "thickness": THICKNESS,
            "friction": FRICTION,
            "grid": {
                "origin": list(self.setting.origin),
                "turned": list(self.setting.turned),
                "moved": list(self.setting.moved),
            },
        }


Frames = NDArray[np.float64]
"""Positions [m], shape (frames, particles, 3); the first is 1/60 s after the start."""
