"""The row about hard places: a hand or a weight on one vertex must not make the cloth much more expensive."""

from dataclasses import dataclass, field, replace

import numpy as np
from taut import Simulation
from taut.bench import Spread, Timeable, Window
from taut.bench.trials import Shape, Trial

from tools.targets.speed import timed
from tools.targets.table import Effort, Row

FACTOR = 4.0
SHAPES: tuple[Shape, ...] = ("grid", "mesh")
MASS = 0.3  # [kg], of the flag
ASIDE, BEYOND = (-0.3, -0.5, 0.2), (0.0, -0.7, 0.3)
"""Where a hand takes the middle [m]: somewhere, and further from the pole than the cloth is long."""


@dataclass(frozen=True, slots=True)
class Pulled:
    """A flag whose middle a hand pulls across the wind."""

    trial: Trial
    pull: tuple[float, float, float]
    """Where the hand takes it from its place [m]."""
    mass: float
    """Of the vertex besides its own [kg]: light hands drag no heavy cloth."""
    scene: str = field(default="pulled flag", init=False)

    @property
    def cells(self) -> int:
        """Cells along a side of a square grid with as many vertices [1]."""
        return self.trial.cells

    @property
    def strain_limit(self) -> float:
        """Lambda [1]."""
        return self.trial.strain_limit

    def simulation(self) -> Simulation:
        """Return it at its start, the hand already pulling."""
        middle = np.array([0.75, 0.0, 0.5])
        weights = [{"nearest": middle.tolist(), "mass": self.mass}] if self.mass else []
        simulation = replace(self.trial, cloth={"weights": weights}).simulation()
        vertex = int(np.argmin(np.linalg.norm(simulation.positions - middle, axis=1)))
        simulation.lead(vertex, middle + self.pull, 2.0)
        return simulation


def hand(effort: Effort) -> Row:
    """Mean frame of the flag with a hand or a weight over that without."""
    parts, spreads = [], []
    for shape in SHAPES:
        free = Trial("flag", effort.vertices(65), 0.05, shape)
        weights = [{"nearest": [0.75, 0.0, 0.5], "mass": MASS / 2}]
        heavy = Trial("flag", free.vertices, 0.05, shape, cloth={"weights": weights})
        cases: dict[str, Timeable] = {
            "light hand": Pulled(free, ASIDE, 0.0),
            "strong hand": Pulled(free, ASIDE, MASS),
            "strong hand beyond reach": Pulled(free, BEYOND, MASS),
            "weight": heavy,
        }
        ratios: dict[str, list[float]] = {name: [] for name in cases}
        window = Window(min(effort.frames, 120), np.inf)
        for _ in range(effort.runs):
            # Each run begins with new simulations: a hand is no part of the state that is gone back to.
            *loaded, plain = timed([*cases.values(), free], window)
            for found, one in zip(ratios.values(), loaded, strict=True):
                found.append(float(one.ms[0] / plain.ms[0]))
        for name, found in ratios.items():
            spreads.append(Spread.of(found))
            parts.append(f"{shape}, {name} {spreads[-1].median:.2f} x")
    worst = max(spreads, key=lambda spread: spread.median)
    target = (
        "flag of 65² vertices, first 2 s, its middle pulled by hand, or half its weight on one vertex: ≤ 4 x "
        "the cost of the flag alone"
    )
    return Row(target, "; ".join(parts), worst.median <= FACTOR, "1", f"{worst.text()} x")
