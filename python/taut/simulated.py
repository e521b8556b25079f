"""What a simulation simulates: scene, meshes and model, none of which changes."""

from collections.abc import Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taut._taut import Engine
from taut.arrays import read_only, whole
from taut.bodies import BodyRange
from taut.scene import FollowedPath, Mesh, Scene

MOST_THREADS = 1024
"""Worker threads that can be asked for [1]; no machine has more cores that would help."""


class ClothRange(NamedTuple):
    """Where a cloth's vertices lie among all vertices."""

    name: str
    first_vertex: int
    vertices: int


_Parts = tuple[Scene, dict[str, Mesh], list[str], dict[str, FollowedPath]]
"""What a model is built of: the scene, what its files held then, and what was repaired in them."""


class Simulated:
    """A model, built from a scene."""

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        """Build the model; see :class:`taut.Simulation`."""
        if not isinstance(scene, Scene):
            raise TypeError(
                f"scene is a {type(scene).__name__}; must be a taut.Scene, as from taut.Scene.load(path)"
            )
        if threads is not None:
            threads = whole(
                "threads", threads, f"1 to {MOST_THREADS}, or None for all cores", 1, MOST_THREADS
            )
        meshes, repairs = scene.read_meshes()
        self._build((scene, meshes, repairs, scene.read_paths()), threads)

    def _build(self, parts: _Parts, threads: int | None) -> None:
        self._parts = parts
        self._scene, self._meshes, self._repairs, self._paths = parts
        self._engine = Engine(self._scene.to_json(), self._meshes, threads, self._paths)

    @property
    def scene(self) -> Scene:
        """The scene it was made of."""
        return self._scene

    @property
    def meshes(self) -> Mapping[str, Mesh]:
        """Geometry of the meshes that the scene names: vertices, corners and counts of the faces."""
        return self._meshes

    @property
    def paths(self) -> Mapping[str, FollowedPath]:
        """The arrays that pins and bodies follow: places [m] and frames per second, if not the scene's."""
        return self._paths

    @property
    def warnings(self) -> list[str]:
        """What is suspicious in the scene and what was repaired in its meshes, one sentence each."""
        return self._repairs + [text for text in self._engine.warnings if text not in self._repairs]

    @property
    def threads(self) -> int:
        """Worker threads [1]."""
        return self._engine.threads

    @property
    def substeps(self) -> int:
        """Steps per frame [1]."""
        return self._engine.substeps

    @property
    def step_length(self) -> float:
        """Length of a step [s]."""
        return self._engine.step_length

    @property
    def step_bound(self) -> float:
        """Largest stable step [s]."""
        return self._engine.step_bound

    @cached_property
    def cloths(self) -> list[ClothRange]:
        """Name, first vertex and number of vertices of each cloth."""
        return [ClothRange(*cloth) for cloth in self._engine.cloths]

    @cached_property
    def body_ranges(self) -> list[BodyRange]:
        """Name, shape and radius of each body, and where its vertices and triangles lie among all."""
        return [BodyRange(*body) for body in self._engine.bodies]

    @cached_property
    def body_triangles(self) -> NDArray[np.int32]:
        """Triangles of all bodies, vertices counted over all bodies, shape (triangles, 3), read-only."""
        return read_only(self._engine.body_triangles)

    @cached_property
    def faces(self) -> NDArray[np.int32]:
        """Triangles as vertex indices, shape (triangles, 3), read-only."""
        return read_only(self._engine.faces)

    @cached_property
    def springs(self) -> NDArray[np.int32]:
        """Springs as pairs of vertex indices, shape (springs, 2), read-only."""
        return read_only(self._engine.springs)

    @cached_property
    def spring_kind(self) -> NDArray[np.uint8]:
        """Kind of each spring: 0 structural, 1 shear, 2 flexion; shape (springs,), read-only."""
        return read_only(self._engine.spring_kind)

    @cached_property
    def rest_length(self) -> NDArray[np.float32]:
        """Rest length of each spring [m], shape (springs,), read-only."""
        return read_only(self._engine.rest_length)

    @cached_property
    def strain_limit(self) -> NDArray[np.float32]:
        """Largest stretch of each spring at the start [1], infinite for none; shape (springs,), read-only."""
        return read_only(self._engine.strain_limit)

    @cached_property
    def mass(self) -> NDArray[np.float32]:
        """Mass of each vertex [kg], shape (vertices,), read-only."""
        return read_only(self._engine.mass)

    @cached_property
    def pinned(self) -> NDArray[np.bool_]:
        """Whether each vertex is pinned, shape (vertices,), read-only."""
        return read_only(self._engine.pinned)
