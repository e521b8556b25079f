"""The engines on scenes with contact: their adapters, and the few settings tried, cheap ones first."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from engines import ENGINES, TAUT, Engine
from search import Settings
from store import Case

SIZES = (33, 65)
"""Particles along an edge, where none are asked for."""
SLOW_SIZES = (17, 33)
"""The same for an engine that takes seconds a frame else."""
MIDDLE = 33
"""Larger sheets get fewer settings: the slow engines take seconds a frame."""


@dataclass(frozen=True)
class Contender:
    """An engine in one of its ways to treat contact."""

    name: str
    """What results are filed under, and its place in tables is found by."""
    title: str
    """In tables."""
    engine: Engine
    """The package, and the adapter for contact."""
    settings: Callable[[int], list[Settings]]
    """What is tried at a size, from cheap to dear."""
    lacks: str = ""
    """What it does not have: a few words."""
    sizes: tuple[int, ...] = SIZES
    """Particles along an edge, where none are asked for."""

    def case(self, settings: Settings, scene: str, size: int) -> Case:
        """What results are filed under."""
        return Case(self.name, self.engine.version, settings, scene, size)


def _contender(
    engine: Engine, adapter: str, settings: Callable[[int], list[Settings]], lacks: str = ""
) -> Contender:
    return Contender(engine.name, engine.title, replace(engine, adapter=adapter), settings, lacks)


def _taut(size: int) -> list[Settings]:
    """Taut is told the limit."""
    return [{"strain_limit": 0.05}]


def _rapier(size: int) -> list[Settings]:
    """Its own choices first, then stiffer edges in more substeps; a sheet as thin as the others' last."""
    small = [(4, 30.0, 0.0), (32, 480.0, 0.0), (64, 960.0, 0.0), (64, 960.0, 0.002)]
    large = [(4, 30.0, 0.0), (16, 480.0, 0.0), (64, 1920.0, 0.0)]
    return [
        {"substeps": substeps, "frequency": frequency, "radius": radius}
        for substeps, frequency, radius in (small if size <= MIDDLE else large)
    ]


def _rapier_cloth(size: int) -> list[Settings]:
    """Contacts of whole triangles and its 8 iterations; more of them; with the ways swept, too."""
    tried = [(8, 8, 0), (16, 8, 0), (16, 32, 0), (32, 8, 1)]
    return [
        {"substeps": substeps, "iterations": iterations, "compliance": 0.0, "continuous": continuous}
        for substeps, iterations, continuous in tried
    ]


def _mujoco(mode: str) -> Callable[[int], list[Settings]]:
    """The stretch is the material's, and that of a solver that is ended early: more steps help both."""
    small = [(4, 4e6, 50), (8, 4e6, 50), (8, 16e6, 100)]
    return lambda size: [
        {"mode": mode, "steps": steps, "young": young, "iterations": iterations}
        for steps, young, iterations in (small if size <= MIDDLE else small[1:2])
    ]


def _newton(size: int) -> list[Settings]:
    """Fewer substeps are not cheaper: they have to reach further, and find more pairs."""
    tried = [(20, 4, 1e4), (20, 10, 2e4), (40, 4, 4e4)]
    return [
        {"substeps": substeps, "iterations": iterations, "stiffness": stiffness, "contact": 2e4}
        for substeps, iterations, stiffness in tried
    ]


def _blender(size: int) -> list[Settings]:
    small = [(10, 1.0, 2), (20, 1.0, 4), (20, 5.0, 4), (40, 1.0, 8)]
    return [
        {"quality": quality, "tension": tension, "collisions": collisions}
        for quality, tension, collisions in (small if size <= MIDDLE else small[1:2])
    ]


def _jolt(size: int) -> list[Settings]:
    return [{"iterations": size // 2 * factor, "compliance": 0.0} for factor in (2, 8, 32)]


def _pypbd(size: int) -> list[Settings]:
    """Contacts are looked for once a step, and solved with the velocities."""
    tried = [(16, 1), (16, 4), (16, 8)] if size <= MIDDLE else [(32, 2), (32, 8)]
    return [
        {"substeps": substeps, "steps": steps, "stiffness": 1e6, "passes": 10} for substeps, steps in tried
    ]


OURS = replace(_contender(TAUT, "taut_contact.py", _taut), sizes=(*SLOW_SIZES, SIZES[-1]))

FINE = replace(
    OURS,
    name="taut-fine",
    title="taut, four times the steps",
    settings=lambda size: [{"strain_limit": 0.05, "finer": 4}],
)
"""What the motion is compared with."""

_MUJOCO = _contender(ENGINES["mujoco"], "mujoco_contact.py", _mujoco("ipc"))

CONTENDERS = [
    OURS,
    _contender(ENGINES["rapier"], "rapier_contact.py", _rapier),
    replace(
        _contender(ENGINES["rapier-cloth"], ENGINES["rapier-cloth"].adapter, _rapier_cloth), sizes=SLOW_SIZES
    ),
    replace(_MUJOCO, name="mujoco-ipc", title="MuJoCo flex, `ipc`", lacks="no friction"),
    replace(_MUJOCO, name="mujoco-native", title="MuJoCo flex, native contact", settings=_mujoco("native")),
    replace(_contender(ENGINES["newton"], "newton_contact.py", _newton), sizes=SLOW_SIZES),
    _contender(ENGINES["blender"], "blender_contact.py", _blender),
    _contender(ENGINES["jolt"], "jolt_contact.mjs", _jolt, "no contact of cloth with itself"),
    _contender(ENGINES["pypbd"], "pypbd_contact.py", _pypbd, "no contact of cloth with itself"),
]
