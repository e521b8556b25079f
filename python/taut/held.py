"""What a user holds while a simulation runs: vertices and pins."""

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.arrays import FARTHEST, SLOWEST, SPEED, chosen, entry, read_only, real, triple, world_places
from taut.surrounded import Surrounded


class Held(Surrounded):
    """A model among bodies, held here and there."""

    @cached_property
    def pin_groups(self) -> list[NDArray[np.int32]]:
        """The vertices of each pin of each cloth, in the scene's order; read-only."""
        return [read_only(group) for group in self._engine.pin_groups]

    def lead(self, vertex: int, target: ArrayLike, speed: float) -> None:
        """Lead a vertex by hand in all further steps, until :meth:`release`.

        It keeps its mass, so that the strain limit can hold it back: light hands drag no heavy cloth. Hang a
        weight on the vertex, in the scene, to make the hand strong.

        Args:
            vertex: index into :attr:`taut.Simulation.positions`; a pinned one stays where its pin is.
            target: where it shall go [m], shape (3,).
            speed: at most [m/s].

        Raises:
            IndexError: there is no such vertex.
            TypeError: something is no number.
            ValueError: a number is not finite, the target out of reach, or the speed not above 0.
        """
        number = entry("vertex", vertex, self._engine.vertex_count)
        self._engine.lead(number, triple("target", target, FARTHEST), real("speed", speed, SPEED, SLOWEST))

    def hold(self, vertices: ArrayLike, targets: ArrayLike, over: float = 0.0) -> None:
        """Hold vertices, or give vertices that are held other targets.

        What is held goes to its target whatever pulls at it, like a pin of the scene, until :meth:`release`;
        a pinned vertex leaves its path meanwhile. Where the cloth cannot follow, the filter
        ``coarse_to_fine`` makes it wait. A body in its way stops it, and it goes on along that; where the
        way is free again, it comes to its target little by little. New targets cost nothing; when other
        vertices are held, the next step costs about as much as building the simulation.

        Args:
            vertices: index into :attr:`taut.Simulation.positions`, or several of them, shape (n,).
            targets: where they shall be [m], shape (n, 3); for one vertex (3,) will do.
            over: how long they take to get there [s], in a straight line; 0: until the end of the next step.

        Raises:
            IndexError: there is no such vertex.
            TypeError: vertices that are no integers, or something else that is no number.
            ValueError: a wrong shape, a number that is not finite, or a target out of reach.
        """
        numbers = chosen(vertices, self._engine.vertex_count)
        places = world_places(targets, len(numbers))
        self._engine.hold(numbers, places, real("over", over, "a finite time [s], 0 or longer"))

    def release(self, vertices: ArrayLike) -> None:
        """Let vertices go that :meth:`hold` or :meth:`lead` holds; they keep their velocities.

        Raises:
            IndexError: there is no such vertex.
            TypeError: vertices that are no integers.
        """
        self._engine.release(chosen(vertices, self._engine.vertex_count))

    @property
    def held(self) -> NDArray[np.int32]:
        """The vertices that :meth:`hold` holds, in rising order, shape (n,)."""
        return self._engine.held

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
