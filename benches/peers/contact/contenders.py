"""The engines on scenes with contact: their adapters, and the few settings that are tried, from cheap to dear."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from engines import ENGINES, TAUT, Engine
from search import Settings
from store import Case


@dataclass(frozen=True)
class Contender:
    """An engine, its adapter for contact, and what is tried with it."""

    engine: Engine
    settings: Callable[[int], list[Settings]]
    """What is tried at a size, from cheap to dear."""
    sizes: tuple[int, ...]
    """Particles along an edge, where none are asked for."""
    lacks: str = ""
    """What the engine does not have: a few words."""

    def case(self, settings: Settings, scene: str, size: int) -> Case:
        """What results are filed under."""
        return Case(self.engine.name, self.engine.version, settings, scene, size)


def _with(engine: Engine, adapter: str, title: str | None = None) -> Engine:
    return replace(engine, adapter=adapter, title=title or engine.title)


def _taut(size: int) -> list[Settings]:
    """Taut is told the limit."""
    return [{"strain_limit": 0.05}]


OURS = Contender(_with(TAUT, "taut_contact.py"), _taut, (17, 33, 65))

FINE = replace(
    OURS,
    engine=replace(OURS.engine, name="taut-fine", title="taut, four times the steps"),
    settings=lambda size: [{"strain_limit": 0.05, "finer": 4}],
)
"""What the motion is compared with."""


def _rapier(size: int) -> list[Settings]:
    """Its own choices first, then stiffer edges and more substeps; a thin sheet last."""
    tried = [(4, 30.0, 0.0), (8, 120.0, 0.0), (16, 240.0, 0.0), (32, 480.0, 0.0), (32, 480.0, 0.002)]
    return [
        {"substeps": substeps, "passes": 0, "frequency": frequency, "radius": radius}
        for substeps, frequency, radius in tried
    ]


RAPIER = Engine(
    "rapier", "Rapier", "rapier_contact.py", lambda size, limits: [], ("rapier3d==0.36.1", "numpy==2.3.5")
)
CONTENDERS = [OURS, Contender(RAPIER, _rapier, (17, 33, 65))]
