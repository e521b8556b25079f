"""The row about places far from the origin: the same motion there."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut import Scene, SceneError, Simulation, SimulationError
from taut.bench.trials import Trial

from tools.targets.table import Effort, Row

AWAY = (100e3, -100e3, 100e3)  # [m]
WITHIN = 0.01  # of the size, the path of the centre of mass
SECONDS = 1.5
LIMIT = 0.01


@dataclass(frozen=True, slots=True)
class Moved:
    """What is compared of a motion."""

    centre: NDArray[np.float64]
    """Displacement of the centre of mass [m], shape (frames, 3)."""
    stretch: float
    """Worst after any step, as the engine reports it [1]."""
    cuts: int
    """By the certificate [1]."""


def far(effort: Effort) -> Row:
    """Sheets and a chain at the origin and 100 km off it, along each axis."""
    parts, met = [], True
    for name, size in (("grid", 1.0), ("mesh", 1.0), ("chain", 0.2)):
        try:
            near, away = (_moved(_scene(name, place, effort), effort) for place in (None, AWAY))
        except (SceneError, SimulationError) as error:
            parts.append(f"{name}: {error}")
            met = False
            continue
        apart = float(np.linalg.norm(near.centre - away.centre, axis=1).max()) / size
        held = apart <= WITHIN and away.stretch <= LIMIT + 1e-5 and away.cuts <= near.cuts
        met = met and held
        parts.append(
            f"{name} {100 * apart:.2g} %, worst stretch {100 * away.stretch:.4g} %, cuts {away.cuts} against "
            f"{near.cuts}"
        )
    target = (
        "100 km from the origin along each axis, a sheet of 100² vertices at 1 % and a chain of 20 x 1 cm: "
        "centre of mass within 1 % of the size of its path at the origin, the limit kept, no more cuts"
    )
    return Row(target, "; ".join(parts), met)


def _scene(name: str, place: tuple[float, float, float] | None, effort: Effort) -> Simulation:
    moved: dict[str, Any] = {} if place is None else {"translate": list(place)}
    if name == "chain":
        points = [[0.01 * bead, 0.0, 0.0] for bead in range(21)]
        links = [[bead, bead + 1] for bead in range(20)]
        network = {"points": points, "links": links, "mass": 0.003}
        held = {"strain_limit": LIMIT, "pins": [{"vertices": [0]}]}
        return Simulation(Scene({"cloth": [{"network": network, **held, **moved}]}), 1)
    trial = Trial("one-corner", effort.vertices(100), LIMIT, "grid" if name == "grid" else "mesh")
    start = trial.simulation()
    corner = int(np.flatnonzero(start.pinned)[0])
    cloth = {"pins": [{"vertices": [corner]}], **moved}
    return Trial("one-corner", trial.vertices, LIMIT, trial.shape, cloth=cloth).simulation()


def _moved(simulation: Simulation, effort: Effort) -> Moved:
    mass = simulation.mass.astype(np.float64)
    # Single precision tells places 100 km away 8 mm apart.
    start = simulation.exact_positions
    centre, stretch, cuts = [], -1.0, 0
    for _ in range(round(SECONDS * 60) if effort.divide == 1 else effort.frames):
        report = simulation.step(simulation.substeps)
        stretch, cuts = max(stretch, report.worst_stretch_in_steps), cuts + report.cuts
        centre.append(mass @ (simulation.exact_positions - start) / mass.sum())
    return Moved(np.array(centre), stretch, cuts)
