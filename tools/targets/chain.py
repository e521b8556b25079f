"""The row about the hanging chain: a limit must not take energy from a swing, nor hold it up."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut import Scene, Simulation

from tools.targets.table import Effort, Row

LINKS = 32
LENGTH = 1.0  # [m], of the chain when it is taut
MASS = 0.003  # [kg], of a bead
GRAVITY = 9.81  # [m/s^2]
PERIOD = 1.68129  # [s], w^2 l / g is the smallest root of the Laguerre polynomial L_32
STRAIN_LIMIT = 1e-3
"""The chain may be so much shorter than when it is taut: its period is known to half of this."""
SWAY = 0.02  # [m], of the tip
PERIODS = 10
SUBSTEPS: dict[str, int | str] = {"automatic": "auto", "1/240 s": 4}


@dataclass(frozen=True, slots=True)
class Swing:
    """Small horizontal swings of the beads of a chain of inextensible links: M x'' = -K x."""

    stiffness: NDArray[np.float64]
    """K [N/m], shape (links, links); the tension of a link carries all beads below it."""

    @classmethod
    def of_chain(cls) -> "Swing":
        """The swings of the chain of this row."""
        difference = np.eye(LINKS) - np.eye(LINKS, k=-1)
        tension = MASS * GRAVITY * np.arange(LINKS, 0, -1)
        return cls(difference.T @ np.diag(tension * LINKS / LENGTH) @ difference)

    def first_mode(self) -> NDArray[np.float64]:
        """Displacements of the slowest swing, 1 at the tip, shape (links,)."""
        mode = np.linalg.eigh(self.stiffness)[1][:, 0]
        return np.asarray(mode / mode[-1], dtype=np.float64)

    def energy(self, simulation: Simulation) -> float:
        """Energy of the swing [J]; links that are a little shorter or longer do not count."""
        x = simulation.positions[1:, 0].astype(np.float64)
        speed = simulation.velocities[1:, 0].astype(np.float64)
        return float(0.5 * MASS * speed @ speed + 0.5 * x @ self.stiffness @ x)


def swing(effort: Effort) -> Row:
    """Period of the first mode, and energy after ten periods."""
    periods = PERIODS if effort.divide == 1 else 1
    parts, met = [], True
    for name, substeps in SUBSTEPS.items():
        period, kept = _measure(substeps, periods)
        met = met and abs(period / PERIOD - 1) <= 1e-3 and kept >= 0.98
        parts.append(
            f"{name}: period {100 * (period / PERIOD - 1):+.3f} %, energy {kept:.4f} after {periods} periods"
        )
    return Row(
        "chain of 32 links, automatic and 1/240 s steps: period within 0.1 %, energy after 10 periods ≥ 0.98",
        "; ".join(parts),
        met,
    )


def _measure(substeps: int | str, periods: int) -> tuple[float, float]:
    """Period [s] from interpolated zero crossings of the tip; energy, relative to what it was."""
    swings = Swing.of_chain()
    simulation = _at_rest_aside(swings, substeps)
    energy = swings.energy(simulation)
    step = simulation.step_length
    tip = [simulation.positions[-1, 0]]
    for _ in range(round(periods * PERIOD / step)):
        simulation.step()
        tip.append(simulation.positions[-1, 0])
    kept = swings.energy(simulation) / energy
    x = np.array(tip, dtype=np.float64)
    before = np.flatnonzero(x[:-1] * x[1:] < 0)
    crossings = step * (before + x[before] / (x[before] - x[before + 1]))
    period = 2 * np.diff(crossings).mean() if len(crossings) > 1 else np.inf
    return float(period), kept


def _at_rest_aside(swings: Swing, substeps: int | str) -> Simulation:
    """The chain at the turning point of its first mode, every link taut."""
    taut = LENGTH / LINKS
    points = [[0.0, 0.0, -bead * taut / (1 + STRAIN_LIMIT)] for bead in range(LINKS + 1)]
    links = [[bead, bead + 1] for bead in range(LINKS)]
    cloth: dict[str, Any] = {
        "network": {"points": points, "links": links, "mass": MASS},
        "stiffness": 0.0,
        "damping": 0.0,
        "air_drag": 0.0,
        "strain_limit": STRAIN_LIMIT,
        "pins": [{"vertices": [0]}],
    }
    scene = {"gravity": [0.0, 0.0, -GRAVITY], "cloth": [cloth], "solver": {"substeps": substeps}}
    simulation = Simulation(Scene(scene), threads=1)
    x = np.concatenate([[0.0], SWAY * swings.first_mode()])
    # Rounding must not lead over the limit.
    down = np.sqrt((taut * (1 - 1e-6)) ** 2 - np.diff(x) ** 2)
    z = -np.concatenate([[0.0], np.cumsum(down)])
    simulation.positions = np.column_stack([x, np.zeros_like(x), z])
    return simulation
