"""The engines, the packages they come from, and the settings that the search tries."""

import hashlib
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from search import Family, Settings


@dataclass(frozen=True)
class Engine:
    """An engine and how to get and drive it."""

    name: str
    """On the command line."""
    title: str
    """In tables."""
    adapter: str
    """File in ``adapters/``."""
    families: Callable[[int, list[float]], list[Family]]
    """Families of settings for a size and the limits sought, the most promising first."""
    packages: tuple[str, ...] = ()
    """Pinned packages, from npm for an ``.mjs`` adapter, from crates.io for a ``Cargo.toml``, else from PyPI;
    none: the project's environment."""
    python: str = ""
    """The Python version that the packages need, such as "3.11"; empty: the one that runs this."""

    @property
    def version(self) -> str:
        """What results are filed under; taut's own results are void as soon as its engine is built anew."""
        if self.packages:
            return " ".join(self.packages)
        from taut import _taut

        engine = hashlib.sha256(Path(_taut.__file__).read_bytes()).hexdigest()[:8]
        return f"taut=={version('taut')} ({engine})"


def _taut(size: int, limits: list[float]) -> list[Family]:
    """Taut needs no search: it is told the limit."""
    return [Family({"strain_limit": limit}, "iterations", 200, 200) for limit in limits]


def _jolt(size: int, limits: list[float]) -> list[Family]:
    """Long range attachments help; a little compliance keeps hard edges from fighting each other."""
    settings: list[Settings] = [
        {"attachments": attachments, "compliance": compliance}
        for attachments in (1, 0)
        for compliance in (0.0, 1e-5)
    ]
    return [Family(fixed, "iterations", size // 2, 2048) for fixed in settings]


def _mujoco(size: int, limits: list[float]) -> list[Family]:
    """The stretch is the material's; more steps only take damping away."""
    return [Family({"steps": steps}, "young", 500_000, 32_000_000) for steps in (1, 2, 4, 8)]


def _pypbd(size: int, limits: list[float]) -> list[Family]:
    """One iteration a substep is its best use (small steps); the others confirm it."""
    least = size // 2
    return [
        Family({"iterations": 1, "stiffness": 1e6}, "substeps", least, 2048),
        Family({"iterations": 4, "stiffness": 1e6}, "substeps", least // 4, 512),
        Family({"iterations": 1, "stiffness": 1e4}, "substeps", least, 2048),
    ]


def _blender(size: int, limits: list[float]) -> list[Family]:
    return [Family({"tension": tension}, "quality", 2, 80) for tension in (0.05, 0.2, 1.0, 0.02, 3.0)]


def _newton(size: int, limits: list[float]) -> list[Family]:
    """VBD with one iteration a substep, and XPBD as soft as it needs to be to converge."""
    least = size
    vbd: list[Settings] = [
        {"solver": "vbd", "iterations": iterations, "stiffness": stiffness}
        for iterations, stiffness in ((1, 1e4), (1, 1e3), (4, 1e4), (1, 1e5))
    ]
    xpbd: list[Settings] = [
        {"solver": "xpbd", "iterations": iterations, "softness": softness}
        for iterations, softness in ((1, 8.0), (4, 8.0), (1, 6.0))
    ]
    return [
        Family(fixed, "substeps", least, 1024, multiple=2) for fixed in (vbd[0], xpbd[0], *vbd[1:], *xpbd[1:])
    ]


def _rapier(size: int, limits: list[float]) -> list[Family]:
    """Edges as stiff as they come: a frequency over that of the substeps makes them rigid."""
    return [Family({"passes": n, "frequency": 1e6}, "substeps", size // 2, 2048) for n in (1, 4, 16)]


def _rapier_cloth(size: int, limits: list[float]) -> list[Family]:
    """Its default of 8 iterations a substep, fewer and more; hard edges come with long range bounds."""
    tried = [(8, 0.0), (8, 1e-7), (2, 1e-7), (32, 0.0), (2, 0.0)]
    return [
        Family({"iterations": n, "compliance": compliance}, "substeps", max(4, size // 4 // n), 2048 // n)
        for n, compliance in tried
    ]


TAUT = Engine("taut", "taut", "taut_cloth.py", _taut)

PEERS = [
    Engine("jolt", "Jolt (WebAssembly)", "jolt_cloth.mjs", _jolt, ("jolt-physics@1.1.0",)),
    Engine("mujoco", "MuJoCo flex", "mujoco_cloth.py", _mujoco, ("mujoco==4.0.0", "numpy==2.3.5")),
    Engine("pypbd", "pyPBD (XPBD)", "pypbd_cloth.py", _pypbd, ("pyPBD==2.2.2", "numpy==1.26.4"), "3.11"),
    Engine(
        "blender", "Blender cloth", "blender_cloth.py", _blender, ("bpy==4.5.15", "numpy==1.26.4"), "3.11"
    ),
    Engine("rapier", "Rapier", "rapier_cloth.py", _rapier, ("rapier3d==0.36.1", "numpy==2.3.5")),
    Engine(
        "rapier-cloth", "rapier-cloth", "rapier_cloth/Cargo.toml", _rapier_cloth, ("rapier-cloth==0.3.0",)
    ),
    Engine("newton", "Newton (CPU)", "newton_cloth.py", _newton, ("newton==1.8.0", "warp-lang==1.19.0")),
]

ENGINES = {engine.name: engine for engine in [TAUT, *PEERS]}

REFERENCE = Engine(
    "reference",
    "reference",
    "taut_cloth.py",
    lambda size, limits: [Family({"strain_limit": 0.01, "filter": "sweeps"}, "iterations", 2000, 2000)],
)
"""What the motion is compared with: taut's plain sweeps, run until they converge."""

RUNNING_PYTHON = f"{sys.version_info.major}.{sys.version_info.minor}"
