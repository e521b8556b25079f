"""The ball that pages throw: a body of the scene whose way is worked out here, frame by frame."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.bodies import Body, Skin
from taut.simulation import Simulation
from taut.view.controls import inline
from taut.view.wire import OrderError, Throw

_FLIGHT = 0.3
"""So long a ball is on its way to where it is thrown [s]."""
_SIZE = 0.1
"""Its radius, in diagonals of the cloth."""
_AWAY = 100.0
"""How far it is while nobody has thrown it, in diagonals of the cloth: out of reach of everything."""
_FARTHEST = 20.0
"""It is thrown from no farther than this, and is gone when it is so far from the cloth, in its diagonals."""
_BOUNCE = 0.3
"""Part of its speed with which it leaves the floor [1]."""
_ROLLING = 1.0
"""Rate at which it loses speed along the floor [1/s]."""
_GAP = 4.0
"""What is left between it and the floor, in thicknesses of the cloth: that may lie there."""
_HELD = 1e-6
"""What it stays behind its way by rounding, as a part of its radius."""


class Ball:
    """Where a ball is that was thrown, and how fast it goes."""

    def __init__(
        self, names: Iterable[str], rest: NDArray[np.floating], up: int, floor: float | None
    ) -> None:
        """Nobody has thrown it yet.

        Args:
            names: of the bodies of the scene.
            rest: positions of the cloth's vertices at the start [m].
            up: the axis that points up.
            floor: height at which it stops falling [m], if there is one.
        """
        low, high = rest.min(axis=0), rest.max(axis=0)
        self._size = max(float(np.linalg.norm(high - low)), 0.1)
        self._middle = (low + high) / 2
        self._up, self._floor = up, floor
        self.radius = float(f"{_SIZE * self._size:.3g}")
        """[m]"""
        self.name = "ball thrown"
        taken = set(names)
        while self.name in taken:
            self.name += "'"
        self._home = np.round(self._middle - _AWAY * self._size * np.eye(3)[up], 3)
        self._place: NDArray[np.float64] | None = None
        self._velocity: NDArray[np.float64] | None = None
        self._next: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
        self._gap = 0.0
        body = Body(self.name, "sphere", self.radius, np.zeros((1, 3)), np.zeros((0, 3), np.int32))
        self._skin = Skin(body)
        self._points = self._skin.points(body)

    @property
    def faces(self) -> NDArray[np.int32]:
        """Triangles, counter-clockwise seen from outside, shape (faces, 3)."""
        return self._skin.faces

    @property
    def is_shown(self) -> bool:
        """Whether it was thrown, and is near."""
        return self._place is not None

    @property
    def offset(self) -> NDArray[np.float64]:
        """How far it is from where the scene has it [m]."""
        return np.zeros(3) if self._place is None else self._place - self._home

    def points(self) -> NDArray[np.float32] | None:
        """Where the corners of the triangles are [m], shape (points, 3); nothing while it is away."""
        return None if self._place is None else (self._points + self._place).astype(np.float32)

    def settings(self, document: Mapping[str, Any]) -> list[str]:
        """The settings that put it into a resolved scene."""
        sphere = {"center": self._home.tolist(), "radius": self.radius}
        return [f"body={inline([*document.get('body', ()), {'name': self.name, 'sphere': sphere}])}"]

    def throw(self, order: Throw, simulation: Simulation) -> None:
        """Let it fly through a place.

        Raises:
            OrderError: that is where it starts, or the cloth is there.
        """
        start, target = np.array(order.start), np.array(order.target)
        way = target - start
        length = float(np.linalg.norm(way))
        if length < 0.1 * self.radius:
            raise OrderError("throw: the ball must start elsewhere than where it is thrown to")
        start = target - way * min(1.0, _FARTHEST * self._size / length)
        limited = simulation.rest_length[simulation.spring_kind < 2]
        reach = self.radius + float(limited.max(initial=0.0))
        away = np.linalg.norm(simulation.positions - start, axis=1).min(initial=np.inf)
        if not away > reach:
            raise OrderError("throw: the cloth is where the ball would start; look at it from farther away")
        thickness = [float(cloth["thickness"]) for cloth in simulation.scene.document["cloth"]]
        self._gap = _GAP * max(thickness)
        self._place = start
        self._velocity = (target - start) / _FLIGHT - 0.5 * _FLIGHT * np.array(simulation.gravity)

    def catch(self) -> None:
        """Somebody holds it: it does not fly any more."""
        self._velocity = None

    def park(self) -> None:
        """Put it away."""
        self._place = self._velocity = self._next = None

    def plan(self, gravity: Sequence[float], seconds: float) -> NDArray[np.float64] | None:
        """Where it shall be after a frame, from where the scene has it [m]; nothing if it does not fly."""
        self._next = None
        if self._place is None or self._velocity is None:
            return None
        pull = np.array(gravity)
        place = self._place + seconds * self._velocity + 0.5 * seconds**2 * pull
        velocity = self._velocity + seconds * pull
        up = self._up
        if self._floor is not None and place[up] < self._floor + self.radius + self._gap:
            place[up] = self._floor + self.radius + self._gap
            velocity *= np.exp(-_ROLLING * seconds)
            # What a frame of gravity gives is no bounce.
            fast = abs(velocity[up]) > 4 * seconds * np.linalg.norm(pull)
            velocity[up] = _BOUNCE * abs(velocity[up]) if fast else 0.0
        self._next = place, velocity
        return np.asarray(place - self._home)

    def settle(self, offset: NDArray[np.float64], seconds: float) -> None:
        """It is there now [m]: where cloth held it back, it has lost its speed."""
        before, self._place = self.offset + self._home, self._home + offset
        if self._next is not None:
            planned, self._velocity = self._next
            self._next = None
            if np.linalg.norm(self._place - planned) > _HELD * self.radius:
                self._velocity = (self._place - before) / seconds
        if np.linalg.norm(self._place - self._middle) > 1.5 * _FARTHEST * self._size:
            self.park()
