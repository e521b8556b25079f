"""Several measurements of the same thing: a figure without its spread is no result."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Spread:
    """The middle and the ends of what was found."""

    median: float
    """Half of the figures are below it."""
    least: float
    """The lowest."""
    most: float
    """The highest."""
    runs: int
    """How many there were [1]."""

    @classmethod
    def of(cls, figures: Iterable[float]) -> "Spread":
        """Sum up figures.

        Raises:
            ValueError: there is none.
        """
        found = np.asarray(list(figures), dtype=np.float64)
        if not found.size:
            raise ValueError("no figures: a spread needs one at least")
        return cls(float(np.median(found)), float(found.min()), float(found.max()), len(found))

    def text(self, digits: int = 2, unit: str = "") -> str:
        """For people: the median, then the least and the most in parentheses."""
        least, most = f"{self.least:.{digits}f}", f"{self.most:.{digits}f}"
        return f"{self.median:.{digits}f}{unit} ({least} – {most}, {self.runs} runs)"
