"""A recorded simulation that lives in memory, and some motions, for tests of what reads frames."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class Recording:
    """Satisfies `taut.frames.Frames`."""

    motion: NDArray[np.float32]
    faces: NDArray[np.int32]
    springs: NDArray[np.int32]
    rest_length: NDArray[np.float32]
    strain_limit: NDArray[np.float32]
    title: str = "Recording"
    scene: dict[str, Any] = field(default_factory=lambda: {"fps": 60, "up": "z"})
    pins: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))

    @property
    def frames(self) -> int:
        return len(self.motion)

    @property
    def time(self) -> NDArray[np.float64]:
        return np.arange(self.frames) / self.scene["fps"]

    def positions(self, frame: int) -> NDArray[np.float32]:
        return self.motion[frame]

    def velocities(self, frame: int) -> NDArray[np.float32]:
        return np.zeros_like(self.motion[frame])

    def stretch(self, frame: int) -> NDArray[np.float32]:
        ends = self.motion[frame][self.springs].astype(np.float64)
        with np.errstate(over="ignore", invalid="ignore"):
            length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
            return (length / self.rest_length - 1).astype(np.float32)


def grid(columns: int, rows: int, width: float = 1.5, height: float = 1.0) -> Recording:
    """A hanging rectangle in the plane y = 0, one frame, structural and shear springs, left edge pinned."""
    x, z = np.meshgrid(np.linspace(0, width, columns), np.linspace(1, 1 + height, rows))
    points = np.stack([x, np.zeros_like(x), z], axis=-1).reshape(-1, 3).astype(np.float32)
    index = np.arange(columns * rows, dtype=np.int32).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    pairs = [(index[:, :-1], index[:, 1:]), (index[:-1], index[1:]), (a, c), (b, d)]
    springs = np.concatenate([np.stack([p.ravel(), q.ravel()], -1) for p, q in pairs])
    return recording(points[None], faces, springs, pins=index[:, 0])


def chain(links: int) -> Recording:
    """A hanging chain of unit length: springs only, one frame."""
    points = np.zeros((links + 1, 3), np.float32)
    points[:, 2] = 2 - np.linspace(0, 1, links + 1)
    springs = np.stack([np.arange(links), np.arange(1, links + 1)], -1).astype(np.int32)
    return recording(points[None], np.zeros((0, 3), np.int32), springs, pins=np.zeros(1, np.int32))


def recording(
    motion: NDArray[np.float32], faces: NDArray[np.int32], springs: NDArray[np.int32], pins: NDArray[np.int32]
) -> Recording:
    ends = motion[0][springs]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).astype(np.float32)
    return Recording(motion, faces, springs, length, np.full(len(springs), 0.05, np.float32), pins=pins)


def moved(still: Recording, motion: list[NDArray[np.float32]], **changes: Any) -> Recording:
    """The same cloth with other positions."""
    made = Recording(
        np.asarray(motion, np.float32), still.faces, still.springs, still.rest_length, still.strain_limit
    )
    made.pins = still.pins
    for name, value in changes.items():
        setattr(made, name, value)
    return made
