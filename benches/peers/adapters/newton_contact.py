"""Newton's VBD solver with self contact among bodies, on Warp's CPU back end (one thread, compiled kernels).

settings: substeps (a frame, even), iterations (a substep), stiffness [N/m] of the triangles and contact [N/m]
of contacts. Whole triangles touch bodies, and ways are cut where they would reach into them or into
other cloth, which Newton calls "divide and truncate".
"""

from typing import Any

import newton
import warp as wp
from numpy.typing import NDArray

from harness import FPS, GRAVITY, Job, serve

PAIRS = 128
"""Room for pairs of a vertex or an edge; what is over it would be dropped."""
FASTEST = 4.0
"""Cloth falls no faster than this [m/s]; what it goes in half a substep has to be within reach."""


class Sheet:
    """The sheet as a cloth mesh among shapes."""

    def __init__(self, job: Job) -> None:
        """Build the model and its solver; kernels are compiled once into the environment's folder."""
        wp.config.quiet = True
        wp.config.kernel_cache_dir = str(job.environment / "kernels")
        wp.init()
        wp.set_device("cpu")
        self._substeps = int(job.settings["substeps"])
        model = self._model(job)
        reach = max(job.thickness, 2 * FASTEST / (FPS * self._substeps))
        self._pipeline = newton.CollisionPipeline(
            model,
            broad_phase="nxn",
            soft_contact_gap=reach,
            enable_rigid_soft_full_surface_contact=True,
        )
        self._solver = newton.solvers.SolverVBD(
            model,
            iterations=int(job.settings["iterations"]),
            particle_enable_self_contact=True,
            particle_self_contact_margin=job.thickness,
            particle_self_contact_gap=reach,
            particle_vertex_contact_buffer_size=PAIRS,
            particle_edge_contact_buffer_size=2 * PAIRS,
            particle_topological_contact_filter_threshold=1,
            rigid_soft_enable_dat=True,
            rigid_body_particle_contact_buffer_size=8192,
            collision_pipeline=self._pipeline,
        )
        self._now, self._next = model.state(), model.state()
        self._control = model.control()
        self._graph: Any = None
        self._frames = 0

    @staticmethod
    def _model(job: Job) -> Any:
        builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=(0.0, 0.0, -GRAVITY))
        stiffness = float(job.settings["stiffness"])
        builder.add_cloth_mesh(
            pos=wp.vec3(0.0),
            rot=wp.quat_identity(),
            scale=1.0,
            vel=wp.vec3(0.0),
            vertices=[wp.vec3(*position) for position in job.positions.tolist()],
            indices=job.triangles.ravel().tolist(),
            density=job.masses.sum(),
            particle_radius=job.thickness / 2,
            edge_ke=0.0,
            edge_kd=0.0,
            tri_ke=stiffness,
            tri_ka=stiffness,
            tri_kd=0.0,
            tri_drag=0.0,
            tri_lift=0.0,
        )
        for body in job.bodies:
            _add_shape(builder, body, job)
        builder.color(include_bending=False)
        model = builder.finalize()
        model.soft_contact_ke = float(job.settings["contact"])
        model.soft_contact_kd = 0.0
        model.soft_contact_mu = job.friction
        model.particle_max_velocity = 1e5
        return model

    def frame(self) -> None:
        """Advance by 1/60 s; from the second frame on as a captured graph, as Newton's own examples do."""
        self._frames += 1
        if self._frames == 2:
            with wp.ScopedCapture() as capture:
                self._steps()
            self._graph = capture.graph
        if self._graph is None:
            self._steps()
        else:
            wp.capture_launch(self._graph)

    def _steps(self) -> None:
        self._solver.rebuild_bvh(self._now)
        for _ in range(self._substeps):
            self._now.clear_forces()
            self._solver.step(self._now, self._next, self._control, None, 1 / (FPS * self._substeps))
            self._now, self._next = self._next, self._now

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        array: NDArray[Any] = self._now.particle_q.numpy()
        return array


def _add_shape(builder: Any, body: dict[str, Any], job: Job) -> None:
    surface = newton.ModelBuilder.ShapeConfig(
        mu=job.friction, ke=float(job.settings["contact"]), kd=0.0, margin=0.0
    )
    if body["kind"] == "floor":
        builder.add_shape_plane(plane=(0.0, 0.0, 1.0, -body["height"]), width=0.0, length=0.0, cfg=surface)
        return
    w, x, y, z = body.get("quaternion", (1.0, 0.0, 0.0, 0.0))
    place = wp.transform(wp.vec3(*body["centre"]), wp.quat(x, y, z, w))
    if body["kind"] == "ball":
        builder.add_shape_sphere(-1, xform=place, radius=body["radius"], cfg=surface)
    else:
        wide, deep, high = body["half"]
        builder.add_shape_box(-1, xform=place, hx=wide, hy=deep, hz=high, cfg=surface)


if __name__ == "__main__":
    serve(Sheet)
