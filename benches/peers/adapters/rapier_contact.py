"""Rapier's soft bodies through its Python package: a sheet of edges with self contacts, on one thread.

settings: substeps (solver iterations a frame; contact may ask for more), frequency [Hz] of the edges, radius
[m] of the particles, which is the thickness (0: 0.45 of the distance of neighbours; Rapier's own default is
about a half).
"""

from typing import Any

import numpy as np
import rapier3d as rapier
from numpy.typing import NDArray

from harness import FPS, GRAVITY, Job, serve

DAMPING_RATIO = 1.0
BOUND = 10.0
"""Half of the width of the block whose top is the floor [m]."""


class Sheet:
    """The sheet as particles and edges under a surface."""

    def __init__(self, job: Job) -> None:
        """Build the world."""
        self._world = rapier.PhysicsWorld(gravity=(0.0, 0.0, -GRAVITY))
        self._world.set_num_threads(1)
        parameters = self._world.integration_parameters
        parameters.dt = 1 / FPS
        parameters.num_solver_iterations = int(job.settings["substeps"])
        for body in job.bodies:
            self._world.add_collider(_collider(body).friction(job.friction))
        spacing = 1 / (len(job.positions) ** 0.5 - 1)
        radius = float(job.settings["radius"]) or 0.45 * spacing
        material = rapier.SoftBodyMaterial(
            edge_softness=rapier.SpringCoefficients(float(job.settings["frequency"]), DAMPING_RATIO)
        )
        builder = rapier.SoftBodyBuilder(job.positions.astype(np.float32))
        builder = builder.edges(job.edges.tolist()).surface(job.triangles.tolist())
        builder = builder.masses(job.masses.tolist()).material(material).can_sleep(False)
        builder = builder.particle_radius(radius).self_contacts(True)
        triangles = rapier.Collider.ball(radius).friction(job.friction)
        builder = builder.surface_collider(triangles)
        self._body = self._world.soft_bodies[self._world.add_soft_body(builder)]

    def frame(self) -> None:
        """Advance by 1/60 s."""
        self._world.step()

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        return np.array(self._body.particle_positions)


def _collider(body: dict[str, Any]) -> Any:
    builder = rapier.Collider
    if body["kind"] == "floor":
        return builder.cuboid(BOUND, BOUND, BOUND).translation((0.0, 0.0, body["height"] - BOUND))
    if body["kind"] == "ball":
        return builder.ball(body["radius"]).translation(tuple(body["centre"]))
    w, x, y, z = body["quaternion"]
    pose = rapier.Isometry3(tuple(body["centre"]), rapier.Rotation3(w, x, y, z))
    return builder.cuboid(*body["half"]).position(pose)


if __name__ == "__main__":
    serve(Sheet)
