"""Rapier's soft bodies through its Python package: a sheet of edges that touches nothing, on one thread.

settings: substeps (a frame; Rapier's solver iterations), passes (over the edges, a substep; its PGS
iterations), frequency [Hz] of the edges, which are damped critically.
"""

from typing import Any

import numpy as np
import rapier3d as rapier
from numpy.typing import NDArray

from harness import FPS, GRAVITY, Job, serve

DAMPING_RATIO = 1.0


class Sheet:
    """The sheet as particles and edges; a class for contact adds surfaces."""

    def __init__(self, job: Job) -> None:
        """Build the world."""
        self.world = rapier.PhysicsWorld(gravity=(0.0, 0.0, -GRAVITY))
        self.world.set_num_threads(1)
        parameters = self.world.integration_parameters
        parameters.dt = 1 / FPS
        parameters.num_solver_iterations = int(job.settings["substeps"])
        softness = rapier.SpringCoefficients(float(job.settings["frequency"]), DAMPING_RATIO)
        builder = rapier.SoftBodyBuilder(job.positions.astype(np.float32))
        builder = builder.edges(job.edges.tolist()).masses(job.masses.tolist()).pinned_particles(job.pins)
        builder = builder.material(rapier.SoftBodyMaterial(edge_softness=softness)).can_sleep(False)
        builder = self.finished(builder, job)
        self._body = self.world.soft_bodies[self.world.add_soft_body(builder)]

    def finished(self, builder: Any, job: Job) -> Any:
        """What is left to set."""
        # Rapier makes one pass of its own beside those that a soft body asks for.
        return builder.no_surface_collider().additional_pgs_iterations(int(job.settings["passes"]) - 1)

    def frame(self) -> None:
        """Advance by 1/60 s."""
        self.world.step()

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        return np.array(self._body.particle_positions)


if __name__ == "__main__":
    serve(Sheet)
