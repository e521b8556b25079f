"""PositionBasedDynamics through its Python package: XPBD distance constraints, double precision.

settings: substeps (a frame), iterations (a substep), stiffness [N/m] of the edges.
"""

from typing import Any

import numpy as np
import pypbd as pbd
from numpy.typing import NDArray

from harness import FPS, Job, serve


class Edges:
    """The sheet as particles and distance constraints."""

    def __init__(self, job: Job) -> None:
        """Build the model in the library's only simulation."""
        simulation = pbd.Simulation.getCurrent()
        simulation.initDefault()
        self._model = simulation.getModel()
        self._count = len(job.positions)
        self._add_particles(job)
        for first, second in job.edges.tolist():
            self._model.addDistanceConstraint_XPBD(first, second, float(job.settings["stiffness"]))
        self._model.initConstraintGroups()
        self._stepper = simulation.getTimeStep()
        controller = pbd.TimeStepController
        self._stepper.setValueUInt(controller.NUM_SUB_STEPS, int(job.settings["substeps"]))
        self._stepper.setValueUInt(controller.MAX_ITERATIONS, int(job.settings["iterations"]))
        self._stepper.setValueUInt(controller.MAX_ITERATIONS_V, 0)
        clock = pbd.TimeManager.getCurrent()
        clock.setTime(0.0)
        clock.setTimeStepSize(1 / FPS)

    def _add_particles(self, job: Job) -> None:
        """The package's gravity is fixed at 9.81 m/s^2 along -y: the sheet is laid into x and -z.

        The triangle model only makes the particles; it adds no constraints by itself.
        """
        laid = np.stack([job.positions[:, 0], job.positions[:, 2], -job.positions[:, 1]], axis=1)
        self._model.addTriangleModel(list(laid), job.triangles.ravel().tolist())
        particles = self._model.getParticles()
        masses = job.masses.copy()
        masses[job.pins] = 0.0
        for index, mass in enumerate(masses.tolist()):
            particles.setMass(index, mass)

    def frame(self) -> None:
        """Advance by 1/60 s."""
        self._stepper.step(self._model)

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        laid = np.array(self._model.getParticles().getVertices()).reshape(-1, 3)[: self._count]
        return np.stack([laid[:, 0], -laid[:, 2], laid[:, 1]], axis=1)


if __name__ == "__main__":
    serve(Edges)
