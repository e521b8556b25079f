"""Arrays with a row for each frame, of which those are read that are asked for."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


class Series:
    """Vectors of all vertices in all frames: shape (frames, vertices, 3), float32.

    ``series[3]``, ``series[-1]``, ``series[:, 7]`` and ``series[::10, :, 2]`` read what they name, and
    ``numpy.asarray(series)`` all of it.
    """

    def __init__(self, read: Callable[[int], NDArray[np.float32]], frames: int, vertices: int) -> None:
        """Of what `read` gives for each frame, shape (vertices, 3)."""
        self._read = read
        self.shape = (frames, vertices, 3)
        """Frames, vertices, 3."""

    dtype = np.dtype(np.float32)
    """Of the numbers."""
    ndim = 3
    """Number of axes."""

    def __len__(self) -> int:
        """How many frames there are."""
        return self.shape[0]

    def __call__(self, frame: int) -> NDArray[np.float32]:
        """One frame, shape (vertices, 3): the same as ``series[frame]``."""
        return self._read(frame)

    def __getitem__(self, key: Any) -> Any:
        """Read frames, all vertices of each; then choose of them as NumPy does.

        Raises:
            IndexError: there is no such frame, vertex or axis.
            CacheError: a frame is damaged.
        """
        first, *rest = key if isinstance(key, tuple) else (key,)
        if first is Ellipsis:
            return np.asarray(self)[key]
        if isinstance(first, int | np.integer):
            return self._read(int(first))[tuple(rest)] if rest else self._read(int(first))
        chosen = np.arange(len(self))[first]
        if chosen.ndim != 1:
            raise IndexError(f"frames = {first!r}: must be a number, a slice, or a list of numbers")
        frames = np.empty((len(chosen), *self.shape[1:]), np.float32)
        for row, frame in zip(frames, chosen, strict=True):
            row[:] = self._read(int(frame))
        return frames[(slice(None), *rest)]

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """All of it as an array."""
        if copy is False:
            raise ValueError("the frames are on disk: an array of them is a copy")
        frames: NDArray[Any] = self[:]
        return frames if dtype is None else frames.astype(dtype)
