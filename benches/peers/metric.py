"""How far a cloth stretched and how much it moved, from its frames: the same function for every engine."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheet import FPS, GRAVITY, Indices, Reals, Sheet

SETTLED = 0.5
"""Frames up to this time [s] do not count for :attr:`Measured.worst`."""


@dataclass(frozen=True, slots=True)
class Measured:
    """Figures of one run."""

    worst: float | None
    """Largest stretch [1] of rows, columns and one diagonal a quad, in all frames later than 0.5 s; None if
    there are no such frames or positions are not finite."""
    worst_time: float | None
    """When that was [s]."""
    worst_everywhere: float | None
    """The same with both diagonals and from the first frame on [1]; None where positions are not finite."""
    peak_speed: float
    """Largest speed of the centre of mass, by differences of finite frames [m/s]."""
    gained: float
    """Largest energy of motion and height over that at the start, by differences of finite frames, in that of
    the whole sheet 1 m higher [1]. Nothing in these scenes gives energy, and differences of frames see less
    than there is of it: what is over 0 by more than rounding was made by the engine."""


def measure(sheet: Sheet, frames: NDArray[np.float32]) -> Measured:
    """Measure a run.

    Args:
        sheet: the cloth and its rest shape.
        frames: positions [m], shape (frames, particles, 3); the first is 1/60 s after the start.

    Returns:
        Its figures.
    """
    judged = np.concatenate([sheet.structural, sheet.diagonal])
    rest, other_rest = _lengths(sheet.positions, judged), _lengths(sheet.positions, sheet.other_diagonal)
    weights = sheet.masses / sheet.masses.sum()
    start = weights @ sheet.positions[:, 2]
    worst = worst_time = everywhere = None
    peak = gained = 0.0
    before = sheet.positions
    for index, frame in enumerate(frames):
        positions = frame.astype(np.float64)
        if not np.isfinite(positions).all():
            return Measured(None, None, None, peak, gained)
        way, height = weights @ (positions - before), weights @ (positions[:, 2] + before[:, 2]) / 2 - start
        squares = weights @ ((positions - before) ** 2).sum(axis=1)
        peak = max(peak, float(np.linalg.norm(way)) * FPS)
        gained = max(gained, float(squares) * FPS**2 / (2 * GRAVITY) + float(height))
        before = positions
        stretch = float((_lengths(positions, judged) / rest).max()) - 1
        other = float((_lengths(positions, sheet.other_diagonal) / other_rest).max()) - 1
        everywhere = max(stretch, other, -1.0 if everywhere is None else everywhere)
        time = (index + 1) / FPS
        if time > SETTLED and (worst is None or stretch > worst):
            worst, worst_time = stretch, time
    return Measured(worst, worst_time, everywhere, peak, gained)


def _lengths(positions: Reals, edges: Indices) -> Reals:
    ends = positions[edges]
    lengths: Reals = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))
    return lengths
