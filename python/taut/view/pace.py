"""The clock of a show: no faster than asked, and how fast it really is."""

import time
from collections import deque

_WINDOW = 45
"""Frames over which the speed is measured."""


class Pace:
    """Lets frames follow each other at the speed that was asked for."""

    def __init__(self, rate: float) -> None:
        """Begin at the speed of real time.

        Args:
            rate: frames for each simulated second [1/s].
        """
        self._rate = rate
        self.speed = 1.0
        """Simulated seconds a second, at most [1]."""
        self._due = time.perf_counter()
        self._seen: deque[float] = deque(maxlen=_WINDOW)

    @property
    def factor(self) -> float:
        """Simulated seconds a second lately [1]; 0 while it rests."""
        if len(self._seen) < 2:
            return 0.0
        return (len(self._seen) - 1) / self._rate / max(1e-9, self._seen[-1] - self._seen[0])

    def wait(self) -> None:
        """A frame is done: sleep until the next one is due. A late one is not made up for."""
        frame = 1 / (self._rate * self.speed)
        now = time.perf_counter()
        self._seen.append(now)
        self._due = max(self._due + frame, now - frame)
        if self._due > now:
            time.sleep(min(self._due - now, 0.25))

    def rest(self) -> None:
        """Time stands still."""
        self._due = time.perf_counter()
        self._seen.clear()
