"""A running simulation: NumPy in, NumPy out; the work is done by the compiled engine."""

import copy
import json
from collections.abc import Callable, Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut import _taut
from taut.arrays import (
    FARTHEST,
    read_only,
    real,
    shown,
    single,
    triple,
    whole,
)
from taut.held import Held
from taut.intersections import Intersections
from taut.report import Report
from taut.scene import Scene
from taut.scene.plain import plain

Hook = Callable[[NDArray[np.float32], NDArray[np.float32], float], None]
"""A filter of one's own, see :meth:`Simulation.step`."""

MOST_STEPS = 2**52
"""Steps that a simulation can have taken when its state is set [1]: the time of more could not be told."""


class Simulation(Held):
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
        self._write_to(np.empty(shape, np.float32), np.empty(shape, np.float32))
        self._take(self._engine.report())

    def _write_to(self, positions: NDArray[np.float32], velocities: NDArray[np.float32]) -> None:
        """Keep the state in these arrays, shape (vertices, 3), from now on."""
        self._state = positions, velocities
        self._positions, self._velocities = (read_only(array) for array in self._state)
        self._engine.read_state(*self._state)

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
        float64 and the same shape, with finite numbers. Pins stay on their paths: see :meth:`translate`.

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

        ``None`` if there is nothing. In this order, one after the other:

        - the integrator's own velocities [m/s], where a filter lets them differ, as ``coarse_to_fine`` does;
        - with ``bdf2`` the last displacements [m] and what forces added to velocities [m/s];
        - with ``coarse_to_fine`` a row for every cloth: the number of cycles it takes at least, as it hangs
          calm; the part of its back-off that it keeps [1]; the part of its way in a step that it leaves out
          where it lies calm on something [1].
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
        self._take(self._engine.report())

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

    def translate(self, offset: ArrayLike, cloth: str | None = None) -> Intersections:
        """Displace cloth as a whole, and what holds it: nothing is thrown, as it is by :attr:`positions`.

        Velocities stay, and what an integrator remembers; pins go along with their paths, and what is held or
        led with its targets. Cloth that intersects something then comes apart in the next steps, as at a
        start.

        Args:
            offset: how far [m], shape (3,).
            cloth: name of one cloth; all of them when left out.

        Returns:
            Where cloth intersects something now; it is for you to look at.

        Raises:
            KeyError: there is no such cloth.
            TypeError: something is no number.
            ValueError: a number is not finite, or the offset too large.
        """
        way = triple("offset", offset, FARTHEST)
        names = [one.name for one in self.cloths]
        if cloth is not None and cloth not in names:
            raise KeyError(f"cloth = {shown(cloth)}: must be one of {', '.join(names)}")
        for number, name in enumerate(names):
            if cloth in (None, name):
                self._engine.translate(number, way)
        self._take(self._engine.report())
        return self.intersections()

    def clone(self) -> Self:
        """Another simulation that goes on by itself from the state that there is, with all that holds it.

        :mod:`pickle` does the same across processes. The model is built anew.
        """
        return copy.copy(self)

    def admit(self) -> None:
        """Move vertices until no spring is over its limit.

        For a state from elsewhere, as one that was reached under a wider limit: the filter
        ``coarse_to_fine`` keeps the cloth within its limit, but must not start beyond it. Other filters move
        nothing.
        """
        self._engine.admit()
        self._take(self._engine.report())

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
        self._take(self._engine.report())

    def step(self, n: int = 1, dt: float | None = None, hook: Hook | None = None) -> Report:
        """Advance by `n` steps: all of them, or none.

        Ctrl-C is answered within a fraction of a second; as after any exception, the state is then the one
        before the call.

        Args:
            n: how many [1].
            dt: how long each of them is [s]; :attr:`step_length` when left out. Each call has its own.
            hook: a filter of your own, called as ``hook(positions, velocities, dt)`` with what forces propose
                before the strain limit and contact make it admissible. It gets positions at the start of the
                step [m] and the velocities that lead to its end [m/s], both of shape (vertices, 3), and the
                length of the step [s]; what it writes into ``velocities`` is what the step goes on with. What
                is held keeps its own. Contact and fast bodies have steps taken in parts, each of which is
                proposed, some of them twice. The hook runs in a thread of the engine, and must not call this
                simulation; whatever it raises ends the call.

        Raises:
            SimulationError: a vertex became non-finite.
            TypeError: something is no number.
            ValueError: `n` is below 1, or `dt` below 1e-12 s or over what springs bear.
        """
        n = whole("n", n, f"1 or more steps, at most {MOST_STEPS}", 1, MOST_STEPS)
        if dt is not None:
            dt = real("dt", dt, "a length of time [s]")
        if hook is not None and not callable(hook):
            raise TypeError(f"hook is a {type(hook).__name__}: must be a function, or None")
        return self._take(self._engine.step(n, dt, hook))

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

    def _take(self, told: "_taut.Report") -> Report:
        """Show the state that the engine has reached, and what it tells of that."""
        self._engine.read_state(*self._state)
        self._report = Report(**told)
        return self._report


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
