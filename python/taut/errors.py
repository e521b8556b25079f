"""Every exception that taut raises on purpose; each says in one sentence what is wrong and what to do."""

from collections.abc import Iterable
from difflib import get_close_matches

from taut._taut import SceneError, SimulationError

__all__ = [
    "CacheError",
    "CacheWriteError",
    "CompareError",
    "SceneError",
    "SimulationError",
    "did_you_mean",
]


class CacheError(ValueError):
    """A cache cannot be used as asked: it is missing, damaged, taken, or belongs to another scene."""


class CacheWriteError(RuntimeError):
    """Frames could not be written (disk full, folder gone ..); the frames written before stay readable."""


class CompareError(ValueError):
    """Methods cannot be compared as asked: a name is unknown, or none of them simulates the scene."""


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The end of a sentence about a misspelt word: `; did you mean flag?`, or nothing if none is near."""
    near = get_close_matches(word, list(known), n=1)
    return f"; did you mean {near[0]}?" if near else ""
