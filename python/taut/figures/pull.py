"""Fig. 2: a strip is pulled, and force is set against stretch."""

from dataclasses import dataclass

import numpy as np

from taut.figures.scenes import STRIP, STRIP_SHEAR, STRIP_STIFFNESS, Size, strip
from taut.scene import Scene
from taut.simulation import Simulation

MOST_PULL = 6.0
"""Largest pull [N/m], per breadth."""

_STILL = 1e-6  # [m], between two peaks of the kinetic energy
_PEAKS = 60  # at most; at the limit the filter lets the strip move by a millimetre or so
_MOST_STEPS = 20_000


@dataclass(frozen=True, slots=True)
class Curve:
    """Force and stretch of the strip at rest."""

    pull: tuple[float, ...]
    """Force per breadth in its middle [N/m]."""
    stretch: tuple[float, ...]
    """Of the whole strip [1]."""
    worst: tuple[float, ...]
    """Of its worst spring [1]."""


def membrane_stiffness() -> float:
    """Pull per breadth and stretch of a strip that is free to get narrower, for small strain [N/m].

    Section 1 of docs/equations.md: C11 = E + E_sh/2 and C12 = E_sh/2, hence C11 - C12^2/C11.
    """
    along, across = STRIP_STIFFNESS + STRIP_SHEAR / 2, STRIP_SHEAR / 2
    return along - across**2 / along


def pull_strip(size: Size, method: str) -> Curve:
    """Hang one load after the other on the strip and measure it at rest."""
    pulls = np.linspace(0, MOST_PULL, size.loads + 1)[1:]
    found = [_at_rest(Simulation(Scene(strip(size, pull, method)), 1)) for pull in pulls]
    lengths, worst = zip(*found, strict=True)
    stretch = tuple(length / STRIP[0] - 1 for length in lengths)
    return Curve(tuple(map(float, pulls)), stretch, worst)


def _at_rest(simulation: Simulation) -> tuple[float, float]:
    """Length of the strip [m] and stretch of its worst spring [1] in equilibrium.

    It is found by dynamic relaxation: whenever the kinetic energy has passed a peak, all motion is stopped.
    Each peak lies near an equilibrium, so the strip gets there in a few of them, whatever its damping.
    """
    low = simulation.positions[:, 2] == simulation.positions[:, 2].min()
    top = float(simulation.positions[:, 2].max())
    length, before, peaks = STRIP[0], 0.0, 0
    while simulation.steps < _MOST_STEPS and peaks < _PEAKS:
        report = simulation.step()
        if report.kinetic_energy < before:
            simulation.velocities = np.zeros_like(simulation.velocities)
            now = top - float(simulation.positions[low, 2].mean(dtype=np.float64))
            if abs(now - length) < _STILL:
                break
            length, before, peaks = now, 0.0, peaks + 1
        else:
            before = report.kinetic_energy
    return length, simulation.report.worst_stretch
