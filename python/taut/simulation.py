"""A running simulation: NumPy in, NumPy out; the work is done by the compiled engine."""

import operator
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut._taut import Engine
from taut.report import Report
from taut.scene import Mesh, Scene

Array = TypeVar("Array", bound=NDArray[Any])

MOST_THREADS = 1024
"""Worker threads that can be asked for [1]; no machine has more cores that would help."""


class ClothRange(NamedTuple):
    """Where a cloth's vertices lie among all vertices."""

    name: str
    first_vertex: int
    vertices: int


class Simulation:
    """A scene that moves. Other Python threads run while it steps."""

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        """Build the model and put it in its initial state.

        Args:
            scene: what to simulate.
            threads: worker threads [1]; all cores when left out. Results do not depend on it.

        Raises:
            SceneError: the scene or one of its meshes cannot be simulated.
            TypeError: `scene` is no :class:`taut.Scene`.
            ValueError: `threads` is out of range.
        """
        if not isinstance(scene, Scene):
            raise TypeError(
                f"scene is a {type(scene).__name__}; must be a taut.Scene, as from taut.Scene.load(path)"
            )
        if threads is not None and not 1 <= operator.index(threads) <= MOST_THREADS:
            raise ValueError(f"threads = {threads}: must be 1 to {MOST_THREADS}, or None for all cores")
        self._scene = scene
        self._meshes, repairs = scene.read_meshes()
        self._engine = Engine(scene.to_json(), self._meshes, threads)
        self._warnings = repairs + [text for text in self._engine.warnings if text not in repairs]
        shape = (self._engine.vertex_count, 3)
        self._state = np.empty(shape, np.float32), np.empty(shape, np.float32)
        self._positions, self._velocities = (_read_only(array.view()) for array in self._state)
        self._refresh()
        self._report = Report(**self._engine.report())

    # What is simulated; none of it changes.

    @property
    def scene(self) -> Scene:
        """The scene it was made of."""
        return self._scene

    @property
    def meshes(self) -> Mapping[str, Mesh]:
        """Geometry of the meshes that the scene names: vertices, corners and counts of the faces."""
        return self._meshes

    @property
    def warnings(self) -> list[str]:
        """What is suspicious in the scene and what was repaired in its meshes, one sentence each."""
        return list(self._warnings)

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
    def faces(self) -> NDArray[np.int32]:
        """Triangles as vertex indices, shape (triangles, 3), read-only."""
        return _read_only(self._engine.faces)

    @cached_property
    def springs(self) -> NDArray[np.int32]:
        """Springs as pairs of vertex indices, shape (springs, 2), read-only."""
        return _read_only(self._engine.springs)

    @cached_property
    def spring_kind(self) -> NDArray[np.uint8]:
        """Kind of each spring: 0 structural, 1 shear, 2 flexion; shape (springs,), read-only."""
        return _read_only(self._engine.spring_kind)

    @cached_property
    def rest_length(self) -> NDArray[np.float32]:
        """Rest length of each spring [m], shape (springs,), read-only."""
        return _read_only(self._engine.rest_length)

    @cached_property
    def strain_limit(self) -> NDArray[np.float32]:
        """Largest stretch allowed of each spring [1], infinite for none; shape (springs,), read-only."""
        return _read_only(self._engine.strain_limit)

    @cached_property
    def mass(self) -> NDArray[np.float32]:
        """Mass of each vertex [kg], shape (vertices,), read-only."""
        return _read_only(self._engine.mass)

    @cached_property
    def pinned(self) -> NDArray[np.bool_]:
        """Whether each vertex is pinned, shape (vertices,), read-only."""
        return _read_only(self._engine.pinned)

    # The state.

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self._engine.time

    @property
    def steps(self) -> int:
        """Steps taken since the start [1]."""
        return self._engine.steps

    @property
    def positions(self) -> NDArray[np.float32]:
        """Positions in the world [m], shape (vertices, 3), float32.

        A live, read-only view: the same array shows the new positions after every step; copy it to keep
        it. Assign an array to move the vertices: ``simulation.positions = array``, of type float32 or
        float64 and the same shape, with finite numbers.

        Float32 tells places 1 km from the origin 0.06 mm apart; :attr:`exact_positions` has all digits.
        """
        return self._positions

    @positions.setter
    def positions(self, array: ArrayLike) -> None:
        self.set_state(array, self._velocities, self.steps)

    @property
    def origins(self) -> NDArray[np.float64]:
        """Where the coordinates of each cloth begin now [m], shape (cloths, 3), a copy.

        Each cloth is simulated with coordinates of its own, so that it moves alike wherever it is. They begin
        at the origin of the world for cloth near it; a cloth that travels takes its origin along.
        """
        return self._engine.origins

    @property
    def local_positions(self) -> NDArray[np.float32]:
        """Positions from the origin of each cloth [m], shape (vertices, 3), a copy: what is simulated."""
        return self._engine.local_positions

    @property
    def exact_positions(self) -> NDArray[np.float64]:
        """Positions in the world [m], shape (vertices, 3), float64: origins and local positions added up."""
        return in_world(self.local_positions, self.origins, self.cloths)

    @property
    def velocities(self) -> NDArray[np.float32]:
        """Velocities [m/s], shape (vertices, 3), float32; a view and assignable like :attr:`positions`."""
        return self._velocities

    @velocities.setter
    def velocities(self, array: ArrayLike) -> None:
        self.set_state(self._positions, array, self.steps)

    @property
    def past(self) -> NDArray[np.float32] | None:
        """What a two-step integrator (``bdf2``) remembers of the last step; nothing with all others.

        Displacements [m], then what forces added to velocities [m/s]: shape (2 vertices, 3), a copy.
        """
        return self._engine.past()

    def set_state(
        self,
        positions: ArrayLike,
        velocities: ArrayLike,
        steps: int,
        past: NDArray[np.float32] | None = None,
        origins: NDArray[np.float64] | None = None,
    ) -> None:
        """Replace the state.

        Args:
            positions: in the world [m], shape (vertices, 3), float32 or float64.
            velocities: [m/s], likewise.
            steps: steps taken since the start, from which the time follows.
            past: :attr:`past`; without it a two-step integrator starts anew.
            origins: :attr:`origins`, if the positions are :attr:`local_positions`: together the same bits as
                they were; without them cloths far from where they were built get origins near them.

        Raises:
            TypeError: numbers of another type.
            ValueError: a wrong shape, or a number that is not finite (which one is named).
        """
        places = self._checked("positions", positions, np.float64 if origins is None else np.float32)
        self._engine.set_state(places, self._checked("velocities", velocities), steps, past, origins)
        self._refresh()
        self._report = Report(**self._engine.report())

    # What a user holds while it runs.

    @cached_property
    def pin_groups(self) -> list[NDArray[np.int32]]:
        """The vertices of each pin of each cloth, in the scene's order; read-only."""
        return [_read_only(group) for group in self._engine.pin_groups]

    def lead(self, vertex: int, target: ArrayLike, speed: float) -> None:
        """Lead a vertex by hand in all further steps, until :meth:`release`.

        It keeps its mass, so that the strain limit can hold it back: light hands drag no heavy cloth. Hang a
        weight on the vertex, in the scene, to make the hand strong.

        Args:
            vertex: index into :attr:`positions`; a pinned one stays where its pin is.
            target: where it shall go [m], shape (3,).
            speed: at most [m/s].

        Raises:
            IndexError: there is no such vertex.
            ValueError: a number is not finite, or the speed not above 0.
        """
        self._engine.lead(operator.index(vertex), _triple(target), speed)

    def release(self, vertex: int) -> None:
        """Let a vertex go that :meth:`lead` holds.

        Raises:
            IndexError: there is no such vertex.
        """
        self._engine.release(operator.index(vertex))

    def shift_pins(self, group: int, offset: ArrayLike, speed: float) -> None:
        """Move a group of :attr:`pin_groups` off its path; where the cloth cannot follow, the pins wait.

        Args:
            group: index into :attr:`pin_groups`.
            offset: how far off its path it shall be [m], shape (3,).
            speed: at most [m/s]; infinite: at once.

        Raises:
            IndexError: there is no such group.
            ValueError: a number is not finite, or the speed not above 0.
        """
        self._engine.shift_pins(operator.index(group), _triple(offset), speed)

    def pin_offset(self, group: int) -> NDArray[np.float64]:
        """How far a group of :attr:`pin_groups` is off its path now [m], shape (3,).

        Raises:
            IndexError: there is no such group.
        """
        return np.array(self._engine.pin_offset(operator.index(group)))

    def admit(self) -> None:
        """Move vertices until no spring is over its limit.

        For a state from elsewhere, as one that was reached under a wider limit: the filter
        ``coarse_to_fine`` keeps the cloth within its limit, but must not start beyond it. Other filters move
        nothing.
        """
        self._engine.admit()
        self._refresh()
        self._report = Report(**self._engine.report())

    @property
    def report(self) -> Report:
        """What happened in the last call of :meth:`step`, or in the last frame of :meth:`run`."""
        return self._report

    @property
    def state_hash(self) -> str:
        """XXH3 hash of local positions, velocities, past and origins, 16 hexadecimal digits."""
        return self._engine.state_hash()

    def external_forces(self) -> NDArray[np.float32]:
        """What acts on each vertex from outside in the present state: gravity, air drag and wind [N].

        Returns:
            Array of shape (vertices, 3); zero for pinned vertices.
        """
        return self._engine.external_forces()

    def snapshot(self) -> bytes:
        """The state as bytes, for :meth:`restore` of a simulation of the same scene."""
        return self._engine.snapshot()

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot.

        Raises:
            ValueError: it is damaged, or of another scene.
        """
        self._engine.restore(snapshot)
        self._refresh()
        self._report = Report(**self._engine.report())

    def step(self, n: int = 1) -> Report:
        """Advance by `n` steps of :attr:`step_length`.

        Raises:
            SimulationError: a vertex became non-finite; the state is the one before the call.
            ValueError: `n` is below 1.
        """
        if operator.index(n) < 1:
            raise ValueError(f"n = {n}: must be 1 or more steps")
        self._report = Report(**self._engine.step(n))
        self._refresh()
        return self._report

    def run(self, frames: int, on_frame: Callable[["Simulation"], Any] | None = None) -> Report:
        """Advance by frames of :attr:`substeps` steps each; :func:`taut.record` writes them to a cache.

        Args:
            frames: frames to add to the state that there is [1].
            on_frame: called with this simulation after each frame.

        Raises:
            SimulationError: a vertex became non-finite; the state is that of the frame before.
            ValueError: `frames` is negative.
        """
        if operator.index(frames) < 0:
            raise ValueError(f"frames = {frames}: must be 0 or more")
        for _ in range(frames):
            self.step(self.substeps)
            if on_frame is not None:
                on_frame(self)
        return self._report

    def yardstick(self, repeats: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        """Time what a machine can do: one plain spring-force pass over this cloth, on one thread.

        Benchmarks divide by it, since clocks differ between machines. Nothing moves.

        Returns:
            Duration of each pass [s], shape (repeats,), and the forces of the springs in the present state
            [N], shape (vertices, 3).

        Raises:
            ValueError: `repeats` is below 1.
        """
        if operator.index(repeats) < 1:
            raise ValueError(f"repeats = {repeats}: must be 1 or more passes")
        return self._engine.yardstick(repeats)

    def _refresh(self) -> None:
        self._engine.read_state(*self._state)

    def _checked(self, name: str, value: ArrayLike, kind: Any = np.float32) -> NDArray[Any]:
        array = np.asarray(value)
        if array.dtype.kind != "f":
            raise TypeError(
                f"{name} has type {array.dtype}: must be float32 or float64; try array.astype('float32')"
            )
        if array.shape != self._positions.shape:
            raise ValueError(
                f"{name} has shape {array.shape}: must be {self._positions.shape}, (vertices, 3)"
            )
        with np.errstate(over="ignore"):
            numbers = np.ascontiguousarray(array, np.float32)
        bad = np.argwhere(~np.isfinite(numbers))
        if bad.size:
            vertex, axis = bad[0]
            number = array[vertex, axis]
            raise ValueError(f"{name}[{vertex}, {axis}] = {number}: must be finite in float32")
        return np.ascontiguousarray(array, kind)


def in_world(
    local: NDArray[np.float32], origins: NDArray[np.float64], cloths: Sequence[ClothRange]
) -> NDArray[np.float64]:
    """Places in the world [m], float64, of local positions, shape (vertices, 3).

    Args:
        local: [m], from the origin of each cloth.
        origins: of the cloths [m], shape (cloths, 3).
        cloths: which vertices are whose.
    """
    places: NDArray[np.float64] = local.astype(np.float64) + np.repeat(
        origins, [cloth.vertices for cloth in cloths], axis=0
    )
    return places


def _triple(value: ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(value, np.float64).tolist()
    return x, y, z


def _read_only(array: Array) -> Array:
    array.flags.writeable = False
    return array
