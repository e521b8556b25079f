"""Where bodies should be at any time, as the scene says it: what the engine makes of that may be late."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut import Simulation

Points = NDArray[np.float64]


class Travel:
    """The bodies of a simulation."""

    def __init__(self, simulation: Simulation) -> None:
        """Of one that has not begun yet."""
        document = simulation.scene.document
        self._fps = simulation.scene.fps
        self._bodies = [
            (body, np.asarray(simulation.bodies[body["name"]].positions), _path(simulation, body))
            for body in document.get("body", ())
        ]

    def at(self, time: float) -> Points:
        """Vertices of all bodies [m], shape (body vertices, 3)."""
        if not self._bodies:
            return np.zeros((0, 3))
        return np.concatenate([self._place(*body, time) for body in self._bodies])

    def _place(self, body: dict[str, Any], start: Points, path: Points | None, time: float) -> Points:
        if path is not None:
            frame = min(time * self._fps, len(path) - 1.0)
            first = min(int(frame), len(path) - 2)
            part = frame - first
            return np.asarray((1 - part) * path[first] + part * path[first + 1])
        places = start
        if turn := body.get("turn"):
            angle = np.radians(_between([[0, 0], *turn["angle"]], time))
            point = np.array(turn["point"])
            places = point + (places - point) @ rotation(turn["axis"], angle).T
        return np.asarray(places + _between([[0, [0, 0, 0]], *body.get("move", ())], time))


def rotation(axis: Any, angle: float) -> Points:
    """The matrix of a turn about an axis [radians]."""
    x, y, z = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def _between(keyframes: list[Any], time: float) -> Any:
    """What keyframes say at a time."""
    times = [key[0] for key in keyframes]
    values = np.array([key[1] for key in keyframes], np.float64)
    if values.ndim == 1:
        return np.interp(time, times, values)
    return np.array([np.interp(time, times, column) for column in values.T])


def _path(simulation: Simulation, body: dict[str, Any]) -> Points | None:
    name = body.get("motion")
    return None if name is None else simulation.paths[name][0]
