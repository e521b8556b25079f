"""PositionBasedDynamics among bodies: XPBD distance constraints, vertices against distance fields of bodies.

Its cloth does not collide with itself.

settings: steps (a frame: the library looks for contacts once a step), substeps (a step), stiffness [N/m] of
the edges, passes (velocity iterations, which solve contacts).
"""

from pathlib import Path
from typing import Any

import numpy as np
import pypbd as pbd
from numpy.typing import NDArray

from harness import FPS, Job, serve

UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""The package's gravity is fixed along -y: this turns the job's z there."""
WIDE = 5.0
"""Half of the width of the block whose top is the floor [m]."""
TOLERANCE = 0.02
"""Distance at which a vertex is looked at [m]."""
CUBE = """
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
f 1 3 2
f 1 4 3
f 5 6 7
f 5 7 8
f 1 2 6
f 1 6 5
f 4 7 3
f 4 8 7
f 1 5 8
f 1 8 4
f 2 3 7
f 2 7 6
"""
"""The library wants a mesh of every body, if only for its box."""


class Edges:
    """The sheet as particles and distance constraints."""

    def __init__(self, job: Job) -> None:
        """Build the model in the library's only simulation."""
        simulation = pbd.Simulation.getCurrent()
        simulation.initDefault()
        self._model = simulation.getModel()
        self._model.init()
        self._count = len(job.positions)
        self._stepper = simulation.getTimeStep()
        self._field = pbd.DistanceFieldCollisionDetection()
        self._stepper.setCollisionDetection(self._model, self._field)
        self._field.setTolerance(TOLERANCE)
        self._add_cloth(job)
        cube = job.output.parent / "cube.obj"
        cube.write_text(CUBE)
        for number, body in enumerate(job.bodies):
            self._add_body(number, body, job, cube)
        controller = pbd.TimeStepController
        self._stepper.setValueUInt(controller.NUM_SUB_STEPS, int(job.settings["substeps"]))
        self._stepper.setValueUInt(controller.MAX_ITERATIONS, 1)
        self._stepper.setValueUInt(controller.MAX_ITERATIONS_V, int(job.settings["passes"]))
        self._steps = int(job.settings["steps"])
        clock = pbd.TimeManager.getCurrent()
        clock.setTime(0.0)
        clock.setTimeStepSize(1 / (FPS * self._steps))

    def _add_cloth(self, job: Job) -> None:
        model = self._model
        model.addTriangleModel(list(job.positions @ UP.T), job.triangles.ravel().tolist())
        particles = model.getParticles()
        for index, mass in enumerate(job.masses.tolist()):
            particles.setMass(index, mass)
        for first, second in job.edges.tolist():
            model.addDistanceConstraint_XPBD(first, second, float(job.settings["stiffness"]))
        model.initConstraintGroups()
        cloth = model.getTriangleModels()[0]
        cloth.setFrictionCoeff(job.friction)
        cloth.setRestitutionCoeff(0.0)
        kind = pbd.CollisionObject.TriangleModelCollisionObjectType
        self._field.addCollisionObjectWithoutGeometry(0, kind, particles, 0, self._count, True)

    def _add_body(self, number: int, body: dict[str, Any], job: Job, cube: Path) -> None:
        """Each is larger by half of the thickness, which the library does not know."""
        if body["kind"] == "floor":
            half, axes = np.full(3, WIDE), np.eye(3)
            centre = np.array([0.0, 0.0, body["height"] - WIDE])
        else:
            half = np.array(body.get("half", [body.get("radius")] * 3))
            axes, centre = np.array(body.get("axes", np.eye(3))), np.array(body["centre"])
        half = half + job.thickness / 2
        vertices, mesh = pbd.OBJLoader.loadObjToMesh(str(cube), [1.0, 1.0, 1.0])
        made = self._model.addRigidBody(
            1.0, vertices, mesh, translation=UP @ centre, rotation=UP @ axes, scale=half
        )
        made.setMass(0.0)
        made.setFrictionCoeff(job.friction)
        made.setRestitutionCoeff(0.0)
        kind = pbd.CollisionObject.RigidBodyCollisionObjectType
        corners = made.getGeometry().getVertexDataLocal()
        place = (number, kind, corners, 0, corners.size())
        if body["kind"] == "ball":
            self._field.addCollisionSphere(*place, half[0], True, False)
        else:
            self._field.addCollisionBox(*place, 2 * half, True, False)

    def frame(self) -> None:
        """Advance by 1/60 s."""
        for _ in range(self._steps):
            self._stepper.step(self._model)

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        laid = np.array(self._model.getParticles().getVertices()).reshape(-1, 3)[: self._count]
        return np.asarray(laid @ UP)


if __name__ == "__main__":
    serve(Edges)
