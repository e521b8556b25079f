"""Newton's XPBD and VBD solvers on Warp's CPU back end (one thread, compiled kernels).

settings: solver ("xpbd" or "vbd"), substeps (a frame, even), iterations (a substep), and the stiffness: for
xpbd ``softness``, the compliance of a spring per squared substep in inverse particle masses (its springs are
corrected all at once, a low softness diverges), for vbd ``stiffness`` [N/m] of the triangles.
"""

from typing import Any

import newton
import warp as wp
from numpy.typing import NDArray

from harness import FPS, GRAVITY, Job, serve


class Sheet:
    """The sheet as a cloth mesh."""

    def __init__(self, job: Job) -> None:
        """Build the model and its solver; kernels are compiled once into the environment's folder."""
        wp.config.quiet = True
        wp.config.kernel_cache_dir = str(job.environment / "kernels")
        wp.init()
        wp.set_device("cpu")
        self._substeps = int(job.settings["substeps"])
        model = self._model(job)
        iterations = int(job.settings["iterations"])
        if job.settings["solver"] == "xpbd":
            self._solver = newton.solvers.SolverXPBD(model, iterations=iterations)
        else:
            self._solver = newton.solvers.SolverVBD(
                model, iterations=iterations, particle_enable_self_contact=False
            )
        self._now, self._next = model.state(), model.state()
        self._control = model.control()
        self._graph: Any = None
        self._frames = 0

    def _model(self, job: Job) -> Any:
        builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=(0.0, 0.0, -GRAVITY))
        builder.add_cloth_mesh(
            pos=wp.vec3(0.0),
            rot=wp.quat_identity(),
            scale=1.0,
            vel=wp.vec3(0.0),
            vertices=[wp.vec3(*position) for position in job.positions.tolist()],
            indices=job.triangles.ravel().tolist(),
            density=job.masses.sum(),
            particle_radius=0.0,
            edge_ke=0.0,
            edge_kd=0.0,
            **self._stiffness(job),
        )
        if job.settings["solver"] == "vbd":
            builder.color(include_bending=False)
        for pin in job.pins:
            builder.particle_mass[pin] = 0.0
            builder.particle_flags[pin] &= ~newton.ParticleFlags.ACTIVE
        model = builder.finalize()
        model.particle_grid = None
        model.particle_max_velocity = 1e5
        return model

    def _stiffness(self, job: Job) -> dict[str, Any]:
        if job.settings["solver"] == "vbd":
            stiffness = float(job.settings["stiffness"])
            return {"tri_ke": stiffness, "tri_ka": stiffness, "tri_kd": 0.0, "tri_drag": 0.0, "tri_lift": 0.0}
        spring = job.masses.max() * (FPS * self._substeps) ** 2 / float(job.settings["softness"])
        return {"add_springs": True, "spring_ke": spring, "spring_kd": 0.0, "tri_ke": 0.0, "tri_ka": 0.0}

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
        for _ in range(self._substeps):
            self._now.clear_forces()
            self._solver.step(self._now, self._next, self._control, None, 1 / (FPS * self._substeps))
            self._now, self._next = self._next, self._now

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        array: NDArray[Any] = self._now.particle_q.numpy()
        return array


if __name__ == "__main__":
    serve(Sheet)
