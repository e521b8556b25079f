"""What is kept of a motion, and what can be said about it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from taut import Simulation

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Motion:
    """Frames of a simulation, one after the other, in double precision."""

    positions: Array
    """[m], shape (frames + 1, vertices, 3)."""
    velocities: Array
    """What the simulation says [m/s], the same shape."""
    kinetic: Array
    """What it says [J], shape (frames + 1,)."""
    cycles: Array
    """Cycles of the filter for a step, shape (frames,)."""
    mass: Array
    """[kg], shape (vertices,)."""
    fps: float
    """[1/s]."""

    @classmethod
    def of(cls, simulation: Simulation, frames: int) -> "Motion":
        """Simulates some frames and keeps them, and the state before them."""
        positions, velocities = [simulation.positions.copy()], [simulation.velocities.copy()]
        kinetic, cycles = [simulation.report.kinetic_energy], []
        for _ in range(frames):
            report = simulation.step(simulation.substeps)
            positions.append(simulation.positions.copy())
            velocities.append(simulation.velocities.copy())
            kinetic.append(report.kinetic_energy)
            cycles.append(report.sweeps / simulation.substeps)
        return cls(
            np.array(positions, np.float64),
            np.array(velocities, np.float64),
            np.array(kinetic),
            np.array(cycles),
            simulation.mass.astype(np.float64),
            simulation.scene.fps,
        )

    @property
    def moved(self) -> Array:
        """Velocities as centred differences of positions [m/s], shape (frames - 1, vertices, 3)."""
        return np.asarray((self.positions[2:] - self.positions[:-2]) * self.fps / 2)

    def shaking(self) -> Array:
        """Second differences of positions from frame to frame [m], shape (frames - 1, vertices)."""
        return np.asarray(np.linalg.norm(np.diff(self.positions, 2, axis=0), axis=2))

    def trembling(self) -> Array:
        """A quarter of the fourth differences [m], shape (frames - 3, vertices).

        Of what goes to and fro every frame it is as much as the second difference; of a swing, which has
        periods of many frames, nearly nothing is left.
        """
        return np.asarray(np.linalg.norm(np.diff(self.positions, 4, axis=0), axis=2) / 4)

    def mismatch(self, slowest: float = 0.0) -> float:
        """How far velocities are off those of the motion, root mean square relative to theirs [1].

        Only frames count in which the cloth moves at `slowest` [m/s] at least, root mean square; 0 if there
        are none.
        """
        moved = self.moved
        frames = np.sqrt((moved**2).sum(axis=2).mean(axis=1)) >= slowest
        off, moved = (self.velocities[1:-1] - moved)[frames], moved[frames]
        return float(np.sqrt((off**2).sum() / (moved**2).sum())) if moved.any() else 0.0

    def kinetic_of_motion(self) -> Array:
        """Kinetic energy of the motion that positions make [J], shape (frames - 1,)."""
        return np.asarray(0.5 * (self.moved**2).sum(axis=2) @ self.mass)

    def centre(self) -> Array:
        """Centre of mass [m], shape (frames + 1, 3)."""
        return np.asarray(np.einsum("v,fvc->fc", self.mass / self.mass.sum(), self.positions))


def rms(lengths: Array) -> float:
    """Root mean square."""
    return float(np.sqrt((lengths**2).mean()))
