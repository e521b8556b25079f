"""Every exception that taut raises on purpose; each says in one sentence what is wrong and what to do."""

from taut._taut import SceneError, SimulationError

__all__ = ["CacheError", "CacheWriteError", "SceneError", "SimulationError"]


class CacheError(ValueError):
    """A cache cannot be used as asked: it is missing, damaged, taken, or belongs to another scene."""


class CacheWriteError(RuntimeError):
    """Frames could not be written (disk full, folder gone ..); the frames written before stay readable."""
