"""Blender's cloth modifier with collisions, without Blender's window, through the package bpy.

settings: quality (steps a frame), tension [N/m] of tension, compression and shear, collisions (iterations of
the collision step, of bodies and of the cloth itself).
"""

import math
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from harness import FPS, GRAVITY, Job, serve

FRAMES_A_SECOND_OF_CLOTH = math.sqrt(1000.0)
"""As in blender_cloth.py."""
A_UNIT_OF_FRICTION = 100.0
"""A hundredth of what the modifier calls friction is a limit of tangential over normal velocity."""
WIDE = 5.0
"""Half of the width of the block whose top is the floor [m]."""
RINGS, SEGMENTS = 48, 96
"""Of the mesh of a ball; it is around the ball, so that cloth that stays out of it stays out of the ball."""


class Modifier:
    """The sheet as a mesh with a cloth modifier, bodies as meshes with a collision modifier."""

    def __init__(self, job: Job) -> None:
        """Build an empty file with all of it, one thread."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._scene = bpy.context.scene
        self._scene.render.threads_mode = "FIXED"
        self._scene.render.threads = 1
        self._scene.frame_start, self._scene.frame_end = 1, job.frames + 1
        self._scene.gravity = (0.0, 0.0, -GRAVITY)
        for body in job.bodies:
            self._add_body(body, job)
        mesh = bpy.data.meshes.new("sheet")
        mesh.from_pydata(job.positions.tolist(), [], job.triangles.tolist())
        self._object = bpy.data.objects.new("sheet", mesh)
        self._scene.collection.objects.link(self._object)
        modifier = self._object.modifiers.new("cloth", "CLOTH")
        self._set(modifier.settings, job)
        self._collide(modifier.collision_settings, job)
        modifier.point_cache.frame_start, modifier.point_cache.frame_end = 1, job.frames + 1
        self._frame = 1
        self._scene.frame_set(self._frame)
        self._positions = np.empty(3 * len(job.positions), np.float32)

    def _add_body(self, body: dict[str, Any], job: Job) -> None:
        vertices, faces = _mesh(body)
        mesh = bpy.data.meshes.new(body["kind"])
        mesh.from_pydata(vertices, [], faces)
        made = bpy.data.objects.new(body["kind"], mesh)
        self._scene.collection.objects.link(made)
        made.modifiers.new("collision", "COLLISION")
        made.collision.thickness_outer = max(0.001, job.thickness / 2)
        made.collision.cloth_friction = A_UNIT_OF_FRICTION * job.friction
        made.collision.damping = 0.0

    @staticmethod
    def _set(cloth: Any, job: Job) -> None:
        """Only stretch: no bending, no damping, no air."""
        tension = float(job.settings["tension"])
        cloth.quality = int(job.settings["quality"])
        cloth.time_scale = FRAMES_A_SECOND_OF_CLOTH / FPS
        cloth.mass = job.masses.sum() / len(job.masses)
        cloth.tension_stiffness = cloth.compression_stiffness = cloth.shear_stiffness = tension
        cloth.bending_model = "ANGULAR"
        cloth.bending_stiffness = 0.0
        cloth.tension_damping = cloth.compression_damping = cloth.shear_damping = 0.0
        cloth.bending_damping = cloth.air_damping = 0.0

    @staticmethod
    def _collide(settings: Any, job: Job) -> None:
        settings.use_collision = settings.use_self_collision = True
        settings.collision_quality = int(job.settings["collisions"])
        settings.distance_min = max(0.001, job.thickness / 2)
        settings.self_distance_min = job.thickness
        settings.self_friction = A_UNIT_OF_FRICTION * job.friction
        settings.damping = 0.0

    def frame(self) -> None:
        """Advance by 1/60 s."""
        self._frame += 1
        self._scene.frame_set(self._frame)

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        evaluated = self._object.evaluated_get(bpy.context.evaluated_depsgraph_get())
        evaluated.data.vertices.foreach_get("co", self._positions)
        return self._positions.reshape(-1, 3)


def _mesh(body: dict[str, Any]) -> tuple[list[list[float]], list[list[int]]]:
    """Vertices and faces of a body; what is below the floor is a block."""
    if body["kind"] == "ball":
        return _ball(body)
    if body["kind"] == "floor":
        half, axes = np.full(3, WIDE), np.eye(3)
        centre = np.array([0.0, 0.0, body["height"] - WIDE])
    else:
        half, axes, centre = np.array(body["half"]), np.array(body["axes"]), np.array(body["centre"])
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return (corners @ axes.T + centre).tolist(), sides


def _ball(body: dict[str, Any]) -> tuple[list[list[float]], list[list[int]]]:
    radius = body["radius"] / math.cos(math.pi / SEGMENTS) ** 2
    polar = np.linspace(0.0, math.pi, RINGS + 1)[1:-1]
    around = np.arange(SEGMENTS) * (2 * math.pi / SEGMENTS)
    x, y = np.outer(np.sin(polar), np.cos(around)), np.outer(np.sin(polar), np.sin(around))
    z = np.repeat(np.cos(polar)[:, None], SEGMENTS, axis=1)
    rings = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    points = np.concatenate([rings, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]]) * radius + np.array(body["centre"])
    top, bottom = len(rings), len(rings) + 1
    faces = []
    for column in range(SEGMENTS):
        beside = (column + 1) % SEGMENTS
        faces.append([top, column, beside])
        for ring in range(RINGS - 2):
            first, second = ring * SEGMENTS, (ring + 1) * SEGMENTS
            faces.append([first + column, second + column, second + beside, first + beside])
        last = (RINGS - 2) * SEGMENTS
        faces.append([bottom, last + beside, last + column])
    return points.tolist(), faces


if __name__ == "__main__":
    serve(Modifier)
