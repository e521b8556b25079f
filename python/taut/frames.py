"""What a picture or an exported file needs to know of a simulation: the reading side of a cache."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from taut.bodies import Body

Progress = Callable[[int, int], None]
"""Called with how many frames are done and how many there are in all."""


class Frames(Protocol):
    """A recorded simulation, read frame by frame. Lengths in metres, times in seconds."""

    @property
    def title(self) -> str:
        """One line for people."""

    @property
    def frames(self) -> int:
        """How many frames there are; frame 0 is the initial state."""

    @property
    def time(self) -> NDArray[np.float64]:
        """Time of each frame [s], shape (frames,)."""

    @property
    def faces(self) -> NDArray[np.int32]:
        """Triangles, shape (triangles, 3)."""

    @property
    def springs(self) -> NDArray[np.int32]:
        """Vertex pairs, shape (springs, 2)."""

    @property
    def rest_length(self) -> NDArray[np.float32]:
        """Rest length of each spring [m], shape (springs,)."""

    @property
    def strain_limit(self) -> NDArray[np.float32]:
        """Largest stretch allowed of each spring, infinite where there is none; shape (springs,)."""

    @property
    def scene(self) -> Mapping[str, Any]:
        """The resolved scene."""

    def positions(self, frame: int) -> NDArray[np.float32]:
        """Positions [m], shape (vertices, 3)."""

    def velocities(self, frame: int) -> NDArray[np.float32]:
        """Velocities [m/s], shape (vertices, 3)."""

    def stretch(self, frame: int) -> NDArray[np.float32]:
        """|X_uv| / L - 1 of each spring, shape (springs,)."""


@runtime_checkable
class Exact(Protocol):
    """Frames that know places in the world in double precision, far from its origin too."""

    def exact_positions(self, frame: int) -> NDArray[np.float64]:
        """Positions [m], shape (vertices, 3)."""


@runtime_checkable
class Obstructed(Protocol):
    """Frames of scenes that may have bodies."""

    def bodies(self, frame: int) -> Mapping[str, Body]:
        """What cloth collides with, by name."""


def bodies_of(frames: Frames, frame: int) -> list[Body]:
    """What cloth collides with in a frame, in the scene's order."""
    return list(frames.bodies(frame).values()) if isinstance(frames, Obstructed) else []


def frame_rate(frames: Frames) -> float:
    """Frames per second [1/s], from the scene or else from the recorded times."""
    declared = frames.scene.get("fps")
    if isinstance(declared, (int, float)) and declared > 0:
        return float(declared)
    if frames.frames > 1 and frames.time[1] > frames.time[0]:
        return float(1.0 / (frames.time[1] - frames.time[0]))
    return 60.0


def up_axis(frames: Frames) -> int:
    """Index of the axis that points up: 2 (z, the default) or 1 (y)."""
    return 1 if frames.scene.get("up") == "y" else 2


def links(frames: Frames) -> NDArray[np.int64]:
    """Indices of the springs that no triangle shows: those of nets and chains; shape (links,)."""
    springs = np.asarray(frames.springs)
    if springs.size == 0:
        return np.zeros(0, dtype=np.int64)
    covered = np.zeros(1 + max(int(springs.max()), int(np.max(frames.faces, initial=0))), dtype=np.bool_)
    covered[frames.faces] = True
    return np.flatnonzero(~covered[springs].all(axis=1))


def vertex_stretch(frames: Frames, frame: int) -> NDArray[np.float32]:
    """Largest stretch among the springs that meet at each vertex (0 where none do), shape (vertices,).

    A spring whose stretch is not a number counts as infinitely stretched, so that it is seen.
    """
    stretch = np.nan_to_num(frames.stretch(frame), nan=np.inf, posinf=np.inf, neginf=np.inf)
    worst = np.full(len(frames.positions(frame)), -np.inf, dtype=np.float32)
    springs = np.asarray(frames.springs)
    np.maximum.at(worst, springs[:, 0], stretch)
    np.maximum.at(worst, springs[:, 1], stretch)
    worst[np.isneginf(worst)] = 0.0
    return worst
