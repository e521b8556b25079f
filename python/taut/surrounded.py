"""What stands around the cloths of a simulation: bodies, and where cloth touches something."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.arrays import FARTHEST, real, shown, stretches, triple, world_places
from taut.bodies import Body, bodies_at
from taut.contacts import Contacts, contacts_of
from taut.errors import SimulationError
from taut.intersections import Intersections, intersections_of
from taut.simulated import Simulated


class Surrounded(Simulated):
    """A model among bodies."""

    @property
    def body_positions(self) -> NDArray[np.float64]:
        """Where the vertices of all bodies are now in the world [m], shape (body vertices, 3), a copy."""
        return self._engine.body_positions()

    @property
    def bodies(self) -> Mapping[str, Body]:
        """What cloth collides with, by name, where it is now; a copy, empty without bodies.

        ``simulation.bodies["ball"].positions`` is the middle of a ball [m], shape (1, 3), float64.
        """
        return bodies_at(self.body_ranges, self.body_positions, self.body_triangles)

    def shift_body(self, body: str, offset: ArrayLike, over: float = 0.0) -> None:
        """Send a body off its path, and keep it there; a body that does not move by itself has a path, too.

        It goes in a straight line from where it is. Where the cloth cannot give way, the body
        waits, and comes after when it can. Give the offset of each frame, with the time of a frame, to lead
        it along a curve. :func:`taut.record` writes those bodies alone that the scene moves.

        Args:
            body: its name.
            offset: how far off its path it shall be [m], shape (3,).
            over: how long that takes [s]; 0: it is there now, whatever lies between, so that cloth there
                would be inside of it.

        Raises:
            KeyError: there is no such body.
            TypeError: something is no number.
            ValueError: a number is not finite, the offset too large, or the time below 0.
        """
        self._pose(body, offset, None, over)

    def pose_body(self, body: str, offset: ArrayLike, rotation: ArrayLike, over: float = 0.0) -> None:
        """Turn a body as well; otherwise like :meth:`shift_body`, which leaves it turned.

        First the body turns about its middle, the mean of its vertices (a plane about its point), then it is
        displaced. It turns evenly and the shorter way from how it is turned; lead it by less than half a turn
        a call.

        Args:
            body: its name.
            offset: how far off its path its middle shall be [m], shape (3,).
            rotation: how it shall be turned against its path: the axis times the angle [rad], shape (3,).
            over: how long that takes [s].

        Raises:
            KeyError: there is no such body.
            TypeError: something is no number.
            ValueError: a number is not finite, the offset too large, or the time below 0.
        """
        self._pose(body, offset, triple("rotation", rotation), over)

    def _pose(
        self, body: str, offset: ArrayLike, rotation: tuple[float, float, float] | None, over: float
    ) -> None:
        number, way = self._body_number(body), triple("offset", offset, FARTHEST)
        self._engine.pose_body(number, way, rotation, real("over", over, "a finite time [s], 0 or longer"))

    def set_body_vertices(self, body: str, positions: ArrayLike, over: float = 0.0) -> None:
        """Tell where the vertices of a body shall be: a body that is animated elsewhere.

        Each goes in a straight line from where it is, and stays there: the body has left the path that the
        scene gives it, and whatever moved it off that. Where the cloth cannot give way, the body waits, as in
        :meth:`shift_body`. Give the vertices of each frame, with the time of a frame.

        Args:
            body: its name.
            positions: places in the world [m], as in ``simulation.bodies[body].positions``.
            over: how long that takes [s]; 0: they are there now, whatever lies between.

        Raises:
            KeyError: there is no such body.
            TypeError: something is no number.
            ValueError: a wrong shape, a number that is not finite or too large, or a time below 0.
        """
        number = self._body_number(body)
        places = world_places(positions, self.body_ranges[number].vertices, "positions")
        self._engine.form_body(number, places, real("over", over, "a finite time [s], 0 or longer"))

    def body_offset(self, body: str) -> NDArray[np.float64]:
        """How far a body is off its path now [m], shape (3,): sent by :meth:`shift_body`, held back by cloth.

        Raises:
            KeyError: there is no such body.
        """
        return np.array(self._engine.body_offset(self._body_number(body)))

    def _body_number(self, body: str) -> int:
        names = [one.name for one in self.body_ranges]
        if body not in names:
            known = f"must be one of {', '.join(names)}" if names else "there are no bodies"
            raise KeyError(f"body = {shown(body)}: {known}")
        return names.index(body)

    @property
    def contacts(self) -> Contacts:
        """Where cloth was pushed by bodies, other cloth or itself in the last step, a copy.

        Empty before the first step, and after the state was set. Steps in which a body is fast have several
        parts; these are the places of the last one. They are found when they are asked for.
        """
        return contacts_of(self._engine.contacts())

    @property
    def spring_stretch(self) -> NDArray[np.float32]:
        """How much longer than its rest length each spring is now [1], shape (springs,), a copy.

        ``|X_uv| / L - 1``: below 0 where it is shorter. Springs are those of :attr:`springs`.
        """
        # Coordinates of each cloth: a spring has both ends in one.
        return stretches(self._engine.local_positions.astype(np.float64), self.springs, self.rest_length)

    @property
    def spring_tensions(self) -> NDArray[np.float64]:
        """Tension of each spring in the last step [N], shape (springs,), a copy; below 0 where it pushes.

        The part of the strain limit is in it, and that of dampers. What the step did to the momentum of each
        vertex, less what gravity, air, bending and contact did, is the work of springs. Of all tensions that
        do it these are the nearest to Hooke's law, in the sum of squares. In a chain there are no others. A
        mesh has more springs than it needs, so that neighbours share a load evenly. A sum over several
        springs, as of those at a pin, says more than a single one. A mean over some steps says more than one
        step. Coarse levels of the filter bear some loads across springs, which no tension tells: in irregular
        meshes some 5 % of the weight, up to a sixth where a few vertices bear all of it. Tensions are found
        when they are asked for. That takes about as long as some steps: less than a second for 10,000
        vertices.

        Raises:
            SimulationError: no step was taken since the start, or since the state was set.
        """
        found = self._engine.spring_tensions()
        if found is None:
            raise SimulationError(
                "spring_tensions tell of the last step, and there was none since the start, or since the "
                "state was set: call step() first"
            )
        return found

    def keep_trace(self, keep: bool = True) -> None:
        """Have steps tell where their parts end, from now on; that takes memory and time.

        Args:
            keep: whether it shall.
        """
        self._engine.keep_trace(keep)

    @property
    def trace(self) -> list[NDArray[np.float64]] | None:
        """Where the parts of the steps of the last :meth:`step` ended [m]; none without :meth:`keep_trace`.

        A step has one part, or several where contact or a fast body asks for it. From the end of a part to
        that of the next everything goes in a straight line, and nothing crosses anything. Each array has
        shape (vertices + body vertices, 3), float64: what :attr:`exact_positions` and :attr:`body_positions`
        were. Empty before the first step.
        """
        return self._engine.trace()

    def intersections(self) -> Intersections:
        """Where cloth intersects bodies, other cloth or itself now.

        Contact makes no crossing and takes none back. Those at the start are among :attr:`warnings`; others
        can only come with a state that is set, or a body that is moved at once. Cloth and cloth count where
        cloths collide with themselves.
        """
        return intersections_of(*self._engine.intersections())
