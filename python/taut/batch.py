"""Many simulations that step side by side."""

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from taut import _taut
from taut.arrays import read_only, real, whole
from taut.report import Report
from taut.scene import Scene
from taut.simulated import MOST_THREADS
from taut.simulation import MOST_STEPS, Simulation


class Batch:
    """Worlds with equally many vertices, stepped side by side on one pool of threads.

    ``batch[3]`` is a :class:`taut.Simulation` like any other: wind, gravity, what is held and bodies are set
    there, world by world, and it may take steps by itself. Each takes its steps on one thread at a time, so
    that a batch pays from as many worlds on as there are threads. Results are those of single simulations,
    bit by bit.
    """

    def __init__(self, scenes: Iterable[Scene], threads: int | None = None) -> None:
        """Build a world of each scene: ``Batch([scene] * 64)``.

        Args:
            scenes: at least one.
            threads: worker threads [1]; all cores when left out. Results do not depend on it.

        Raises:
            SceneError: a scene cannot be simulated.
            TypeError: something is no :class:`taut.Scene`.
            ValueError: there is no scene, worlds have different numbers of vertices, or `threads` is out of
                range.
        """
        if threads is not None:
            allowed = f"1 to {MOST_THREADS}, or None for all cores"
            threads = whole("threads", threads, allowed, 1, MOST_THREADS)
        if isinstance(scenes, Scene):
            raise TypeError("scenes is a single Scene: must be several of them, as in Batch([scene] * 64)")
        self._threads = threads
        self._worlds = tuple(Simulation(scene, 1) for scene in scenes)
        if not self._worlds:
            raise ValueError("scenes is empty: must be one scene or more")
        vertices = len(self._worlds[0].positions)
        for number, world in enumerate(self._worlds):
            if len(world.positions) != vertices:
                raise ValueError(
                    f"scenes[{number}] has {len(world.positions)} vertices, scenes[0] {vertices}: must be "
                    "equally many, so that they fit into one array"
                )
        shape = (len(self._worlds), vertices, 3)
        state = np.empty(shape, np.float32), np.empty(shape, np.float32)
        for world, positions, velocities in zip(self._worlds, *state, strict=True):
            world._write_to(positions, velocities)
        self._positions, self._velocities = (read_only(array) for array in state)

    def __len__(self) -> int:
        """How many worlds there are."""
        return len(self._worlds)

    def __getitem__(self, world: int) -> Simulation:
        """One of them."""
        return self._worlds[world]

    def __iter__(self) -> Iterator[Simulation]:
        """All of them, in the order of their scenes."""
        return iter(self._worlds)

    @property
    def positions(self) -> NDArray[np.float32]:
        """Positions of all worlds [m], shape (worlds, vertices, 3); a live, read-only view."""
        return self._positions

    @property
    def velocities(self) -> NDArray[np.float32]:
        """Velocities of the motion of all worlds [m/s], shape (worlds, vertices, 3); likewise."""
        return self._velocities

    def step(self, n: int = 1, dt: float | None = None) -> list[Report]:
        """Advance all worlds by `n` steps: all of them, or none.

        Args:
            n: how many [1].
            dt: how long each of them is [s]; :attr:`taut.Simulation.step_length` of each when left out.

        Raises:
            SimulationError: a vertex became non-finite; the world is named.
            TypeError: something is no number.
            ValueError: `n` is below 1, or `dt` below 1e-12 s or over what springs of a world bear.
        """
        n = whole("n", n, f"1 or more steps, at most {MOST_STEPS}", 1, MOST_STEPS)
        if dt is not None:
            dt = real("dt", dt, "a length of time [s]")
        told = _taut.step_all([world._engine for world in self._worlds], n, dt, self._threads)
        return [world._take(one) for world, one in zip(self._worlds, told, strict=True)]
