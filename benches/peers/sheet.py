"""The cloth that every engine gets: one square metre, 0.2 kg, level, at rest, held at one or two corners.

z points up; lengths are in metres. Particle ``(i, j)`` (column, row) has number ``j * size + i``.
"""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

FPS = 60
"""Frames per second."""
GRAVITY = 9.81
"""In every engine [m/s^2]."""
FRAMES = 300
"""Frames of a full run: 5 s."""
DENSITY = 0.2
"""Mass per area [kg/m^2]; the cloth has 1 m^2."""
SCENES = ("one-corner", "two-corners")
"""A level sheet is let go, held by the corner at the origin, or by both corners of its edge x = 0."""

Indices = NDArray[np.int64]
Reals = NDArray[np.float64]


class Sheet:
    """A sheet of ``size`` times ``size`` particles in one of the scenes."""

    def __init__(self, scene: str, size: int) -> None:
        """Lay it out.

        Args:
            scene: one of :data:`SCENES`.
            size: particles along an edge [1], at least 2.

        Raises:
            ValueError: there is no such scene, or the size is too small.
        """
        if scene not in SCENES:
            raise ValueError(f"scene = {scene!r}: must be one of {', '.join(SCENES)}")
        if size < 2:
            raise ValueError(f"size = {size}: must be at least 2 particles along an edge")
        self.scene, self.size = scene, size
        along = np.linspace(0.0, 1.0, size)
        x, y = np.meshgrid(along, along)
        self.positions: Reals = np.stack([x.ravel(), y.ravel(), np.zeros(size * size)], axis=1)
        self._number: Indices = np.arange(size * size).reshape(size, size)

    @property
    def pins(self) -> list[int]:
        """Particles that do not move."""
        corners = [self._number[0, 0], self._number[-1, 0]]
        return [int(corner) for corner in corners[: 1 if self.scene == "one-corner" else 2]]

    @cached_property
    def structural(self) -> Indices:
        """Edges along rows and columns, shape (edges, 2)."""
        n = self._number
        return np.concatenate([_pairs(n[:, :-1], n[:, 1:]), _pairs(n[:-1], n[1:])])

    @cached_property
    def diagonal(self) -> Indices:
        """One diagonal a quad, alternating, so that the cloth has no grain: shape (quads, 2)."""
        a, b, c, d = self._corners
        return np.where(self._odd, _pairs(b, d), _pairs(a, c))

    @cached_property
    def other_diagonal(self) -> Indices:
        """The diagonals that :attr:`diagonal` leaves out, shape (quads, 2)."""
        a, b, c, d = self._corners
        return np.where(self._odd, _pairs(a, c), _pairs(b, d))

    @cached_property
    def triangles(self) -> Indices:
        """Two triangles a quad, split along :attr:`diagonal`; shape (triangles, 3)."""
        a, b, c, d = (corner.ravel() for corner in self._corners)
        odd = np.stack([np.stack([a, b, d], axis=1), np.stack([b, c, d], axis=1)], axis=1)
        even = np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1)
        return np.where(self._odd[:, :, None], odd, even).reshape(-1, 3)

    @cached_property
    def masses(self) -> Reals:
        """Mass of each particle [kg]: the area of the quarters of quads around it."""
        share = np.ones(self.size)
        share[[0, -1]] = 0.5
        return np.outer(share, share).ravel() * DENSITY / (self.size - 1) ** 2

    def as_job(self) -> dict[str, Any]:
        """What an adapter needs to build it; see ``adapters/harness.py``."""
        return {
            "positions": self.positions.tolist(),
            "masses": self.masses.tolist(),
            "pins": self.pins,
            "edges": np.concatenate([self.structural, self.diagonal]).tolist(),
            "triangles": self.triangles.tolist(),
        }

    @property
    def _corners(self) -> tuple[Indices, Indices, Indices, Indices]:
        n = self._number
        return n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]

    @property
    def _odd(self) -> NDArray[np.bool_]:
        """Quads whose diagonal runs the other way, shape (quads, 1)."""
        quads = np.arange(self.size - 1)
        odd: NDArray[np.bool_] = np.add.outer(quads, quads) % 2 == 1
        return odd.reshape(-1, 1)


def _pairs(first: Indices, second: Indices) -> Indices:
    return np.stack([first.ravel(), second.ravel()], axis=1)
