"""Blender's cloth modifier without Blender's window, through the package bpy.

settings: quality (steps a frame), tension [N/m], which is the stiffness of compression and shear too.
"""

import math
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from harness import FPS, GRAVITY, Job, serve

FRAMES_A_SECOND_OF_CLOTH = math.sqrt(1000.0)
"""The modifier takes gravity as 0.001 g a frame and frame, so that this many of its frames are a second; its
time scale makes up for that (a free fall then follows g t^2 / 2)."""


class Modifier:
    """The sheet as a mesh with a cloth modifier."""

    def __init__(self, job: Job) -> None:
        """Build an empty file with the sheet in it, one thread."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._scene = bpy.context.scene
        self._scene.render.threads_mode = "FIXED"
        self._scene.render.threads = 1
        self._scene.frame_start, self._scene.frame_end = 1, job.frames + 1
        self._scene.gravity = (0.0, 0.0, -GRAVITY)
        mesh = bpy.data.meshes.new("sheet")
        mesh.from_pydata(job.positions.tolist(), [], job.triangles.tolist())
        self._object = bpy.data.objects.new("sheet", mesh)
        self._scene.collection.objects.link(self._object)
        self._object.vertex_groups.new(name="pins").add(job.pins, 1.0, "REPLACE")
        modifier = self._object.modifiers.new("cloth", "CLOTH")
        self._set(modifier.settings, job)
        modifier.collision_settings.use_collision = False
        modifier.collision_settings.use_self_collision = False
        modifier.point_cache.frame_start, modifier.point_cache.frame_end = 1, job.frames + 1
        self._frame = 1
        self._scene.frame_set(self._frame)
        self._positions = np.empty(3 * len(job.positions), np.float32)

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
        cloth.vertex_group_mass = "pins"
        cloth.pin_stiffness = 50.0

    def frame(self) -> None:
        """Advance by 1/60 s."""
        self._frame += 1
        self._scene.frame_set(self._frame)

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        evaluated = self._object.evaluated_get(bpy.context.evaluated_depsgraph_get())
        evaluated.data.vertices.foreach_get("co", self._positions)
        return self._positions.reshape(-1, 3)


if __name__ == "__main__":
    serve(Modifier)
