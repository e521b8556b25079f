"""A running simulation: NumPy in, NumPy out; the work is done by the compiled engine."""

import json
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.arrays import (
    FARTHEST,
    SLOWEST,
    SPEED,
    chosen,
    entry,
    read_only,
    real,
    single,
    triple,
    whole,
    world_places,
)
from taut.report import Report
from taut.scene import Scene
from taut.scene.plain import plain
from taut.surrounded import Surrounded

MOST_STEPS = 2**52
"""Steps that a simulation can have taken when its state is set [1]: the time of more could not be told."""


class Simulation(Surrounded):
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
        super().__init__(scene, threads)
        self._told: dict[str, Any] = {}
        self._begin()

    def _begin(self) -> None:
        shape = (self._engine.vertex_count, 3)
        self._state = np.empty(shape, np.float32), np.empty(shape, np.float32)
        self._positions, self._velocities = (read_only(array) for array in self._state)
        self._refresh()
        self._report = Report(**self._engine.report())

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies, deep ones and pickled ones too, go on by themselves from the state that there is."""
        return _again, (type(self), self._parts, self.threads, self._told, self.snapshot())

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
        counts = [cloth.vertices for cloth in self.cloths]
        return np.repeat(self.origins, counts, axis=0) + self.local_positions.astype(np.float64)

    @property
    def velocities(self) -> NDArray[np.float32]:
        """Velocities of the motion [m/s], shape (vertices, 3); a view, assignable like :attr:`positions`."""
        return self._velocities

    @velocities.setter
    def velocities(self, array: ArrayLike) -> None:
        self.set_state(self._positions, array, self.steps)

    @property
    def past(self) -> NDArray[np.float32] | None:
        """What a run needs to go on besides positions and velocities, shape (n, 3), a copy.

        Its own velocities [m/s] where a filter lets them differ, as ``coarse_to_fine``; with ``bdf2``, then
        the last displacements [m] and what forces added to velocities [m/s]; with ``coarse_to_fine``, then a
        row for every cloth: the number of cycles it takes at least, as it hangs calm, the part of its
        back-off that it keeps [1], and the part of its way in a step that it leaves out where it lies calm on
        something [1]. ``None``: nothing.
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
            steps: steps taken since the start, from which the time follows; at most :data:`MOST_STEPS`.
            past: :attr:`past`; without it the integrator starts anew with these velocities.
            origins: :attr:`origins`, if the positions are :attr:`local_positions`: together the same bits as
                they were; without them cloths far from where they were built get origins near them.

        Raises:
            TypeError: numbers of another type.
            ValueError: a wrong shape, a number that is not finite (which one is named), or too many steps.
        """
        shape = self._positions.shape
        steps = whole("steps", steps, f"a whole number from 0 to {MOST_STEPS}", 0, MOST_STEPS)
        places = single("positions", positions, shape, np.float64 if origins is None else np.float32)
        self._engine.set_state(places, single("velocities", velocities, shape), steps, past, origins)
        self._refresh()
        self._report = Report(**self._engine.report())

    # What a user holds while it runs.

    @cached_property
    def pin_groups(self) -> list[NDArray[np.int32]]:
        """The vertices of each pin of each cloth, in the scene's order; read-only."""
        return [read_only(group) for group in self._engine.pin_groups]

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
            TypeError: something is no number.
            ValueError: a number is not finite, the target out of reach, or the speed not above 0.
        """
        number = entry("vertex", vertex, len(self._positions))
        self._engine.lead(number, triple("target", target, FARTHEST), real("speed", speed, SPEED, SLOWEST))

    def hold(self, vertices: ArrayLike, targets: ArrayLike, over: float = 0.0) -> None:
        """Hold vertices, or give vertices that are held other targets.

        What is held goes to its target whatever pulls at it, like a pin of the scene, until :meth:`release`;
        a pinned vertex leaves its path meanwhile. Where the cloth cannot follow, the filter
        ``coarse_to_fine`` makes it wait. New targets cost nothing; when other vertices are held, the next
        step costs about as much as building the simulation.

        Args:
            vertices: index into :attr:`positions`, or several of them, shape (n,).
            targets: where they shall be [m], shape (n, 3); for one vertex (3,) will do.
            over: how long they take to get there [s], in a straight line; 0: until the end of the next step.

        Raises:
            IndexError: there is no such vertex.
            TypeError: vertices that are no integers, or something else that is no number.
            ValueError: a wrong shape, a number that is not finite, or a target out of reach.
        """
        numbers = chosen(vertices, len(self._positions))
        places = world_places(targets, len(numbers))
        self._engine.hold(numbers, places, real("over", over, "a finite time [s], 0 or longer"))

    def release(self, vertices: ArrayLike) -> None:
        """Let vertices go that :meth:`hold` or :meth:`lead` holds; they keep their velocities.

        Raises:
            IndexError: there is no such vertex.
            TypeError: vertices that are no integers.
        """
        self._engine.release(chosen(vertices, len(self._positions)))

    @property
    def held(self) -> NDArray[np.int32]:
        """The vertices that :meth:`hold` holds, in rising order, shape (n,)."""
        return self._engine.held

    # What acts on it.

    @property
    def gravity(self) -> tuple[float, float, float]:
        """Acceleration of gravity [m/s^2]; assign three numbers to change it from the next step on."""
        x, y, z = self._engine.gravity
        return x, y, z

    @gravity.setter
    def gravity(self, value: ArrayLike) -> None:
        gravity = triple("gravity", value)
        self._engine.gravity = list(gravity)
        self._told["gravity"] = gravity

    @property
    def wind(self) -> dict[str, Any] | None:
        """The wind, with the fields that a scene gives it; ``None``: the air is at rest.

        Assign such a mapping, a velocity [m/s] (all but its keyframes stays), or ``None``; it blows from
        the next step on. A change costs nothing.
        """
        wind = self._engine.wind
        return None if wind is None else dict(json.loads(wind))

    @wind.setter
    def wind(self, value: Mapping[str, Any] | ArrayLike | None) -> None:
        if value is not None and not isinstance(value, Mapping):
            value = {**(self.wind or {}), "velocity": triple("wind", value), "keyframes": []}
        self._engine.wind = None if value is None else json.dumps(plain(dict(value), "wind"))
        self._told["wind"] = self.wind

    def shift_pins(self, group: int, offset: ArrayLike, speed: float) -> None:
        """Move a group of :attr:`pin_groups` off its path; where the cloth cannot follow, the pins wait.

        Args:
            group: index into :attr:`pin_groups`.
            offset: how far off its path it shall be [m], shape (3,).
            speed: at most [m/s]; infinite: at once.

        Raises:
            IndexError: there is no such group.
            TypeError: something is no number.
            ValueError: a number is not finite, the offset too large, or the speed not above 0.
        """
        number = entry("group", group, len(self.pin_groups))
        self._engine.shift_pins(
            number, triple("offset", offset, FARTHEST), real("speed", speed, SPEED, SLOWEST)
        )

    def pin_offset(self, group: int) -> NDArray[np.float64]:
        """How far a group of :attr:`pin_groups` is off its path now [m], shape (3,).

        Raises:
            IndexError: there is no such group.
        """
        return np.array(self._engine.pin_offset(entry("group", group, len(self.pin_groups))))

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
            TypeError: it is not of type bytes.
            ValueError: it is damaged, or of another scene.
        """
        if not isinstance(snapshot, bytes):
            kind = type(snapshot).__name__
            raise TypeError(f"snapshot is a {kind}: must be bytes, as from Simulation.snapshot()")
        self._engine.restore(snapshot)
        self._refresh()
        self._report = Report(**self._engine.report())

    def step(self, n: int = 1, dt: float | None = None) -> Report:
        """Advance by `n` steps: all of them, or none.

        Ctrl-C is answered within a fraction of a second; as after any exception, the state is then the one
        before the call.

        Args:
            n: how many [1].
            dt: how long each of them is [s]; :attr:`step_length` when left out. Each call has its own.

        Raises:
            SimulationError: a vertex became non-finite.
            TypeError: something is no number.
            ValueError: `n` is below 1, or `dt` below 1e-12 s or over what springs bear.
        """
        n = whole("n", n, f"1 or more steps, at most {MOST_STEPS}", 1, MOST_STEPS)
        if dt is not None:
            dt = real("dt", dt, "a length of time [s]")
        self._report = Report(**self._engine.step(n, dt))
        self._refresh()
        return self._report

    def run(self, frames: int, on_frame: Callable[["Simulation"], Any] | None = None) -> Report:
        """Advance by frames of :attr:`substeps` steps each; :func:`taut.record` writes them to a cache.

        Args:
            frames: frames to add to the state that there is [1].
            on_frame: called with this simulation after each frame.

        Raises:
            SimulationError: a vertex became non-finite; the state is that of the frame before.
            TypeError: `frames` is no integer, or `on_frame` no function.
            ValueError: `frames` is negative.
        """
        if on_frame is not None and not callable(on_frame):
            raise TypeError(f"on_frame is a {type(on_frame).__name__}: must be a function, or None")
        for _ in range(whole("frames", frames, "0 or more", 0, MOST_STEPS)):
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
        return self._engine.yardstick(whole("repeats", repeats, "1 or more passes", 1, MOST_STEPS))

    def _refresh(self) -> None:
        self._engine.read_state(*self._state)


def _again(
    kind: type[Simulation], parts: Any, threads: int, told: Mapping[str, Any], snapshot: bytes
) -> Simulation:
    """Another simulation like the one that these are of."""
    simulation = kind.__new__(kind)
    simulation._build(parts, threads)
    simulation._told = {}
    simulation._begin()
    for name, value in told.items():
        setattr(simulation, name, value)
    simulation.restore(snapshot)
    return simulation
