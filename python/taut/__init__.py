"""taut: cloth that does not stretch.

    >>> import taut
    >>> scene = taut.Scene.load("flag.toml")
    >>> simulation = taut.Simulation(scene)
    >>> simulation.run(frames=60)
    >>> simulation.positions  # [m], shape (vertices, 3)

All quantities are in SI units. Names are loaded when they are first used, so that importing
taut is quick.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from taut._taut import __version__ as __version__
    from taut.batch import Batch as Batch
    from taut.cache import Cache as Cache
    from taut.errors import CacheError as CacheError
    from taut.errors import CacheWriteError as CacheWriteError
    from taut.errors import SceneError as SceneError
    from taut.errors import SimulationError as SimulationError
    from taut.report import Report as Report
    from taut.run import record as record
    from taut.scene import Scene as Scene
    from taut.simulation import Simulation as Simulation

_HOME = {
    "__version__": "taut._taut",
    "Batch": "taut.batch",
    "Cache": "taut.cache",
    "CacheError": "taut.errors",
    "CacheWriteError": "taut.errors",
    "Report": "taut.report",
    "Scene": "taut.scene",
    "SceneError": "taut.errors",
    "Simulation": "taut.simulation",
    "SimulationError": "taut.errors",
    "record": "taut.run",
}

__all__ = list(_HOME)  # noqa: PLE0604


def __getattr__(name: str) -> object:
    """Load a public name from the module that defines it."""
    if name not in _HOME:
        raise AttributeError(f"module 'taut' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, loaded or not."""
    return sorted({*globals(), *_HOME})
