"""The row about what pulls hard: moving pins, heavy knots, meshes in wind. The bound, and no lost motion."""

import numpy as np
from taut import SimulationError
from taut.bench.trials import Shape, Trial

from tools.targets.converged import PULLED
from tools.targets.limit import Tally
from tools.targets.settled import off
from tools.targets.table import Effort, Row

WITHIN = 0.03  # of the peak speed, and of the size
SHAPES: tuple[Shape, ...] = ("mesh", "quads", "grid")
SECONDS = 3


def held(effort: Effort) -> Row:
    """Springs over their limit, cuts, and the motion against the converged one."""
    tally, cuts, waiting, failed = Tally(), 0, 0, []
    cases = list(_cases(effort))
    for name, trial in cases:
        simulation = trial.simulation()
        try:
            for _ in range(SECONDS * 60 * simulation.substeps if effort.divide == 1 else effort.frames):
                report = simulation.step()
                cuts, waiting = cuts + report.cuts, waiting + report.held_back_pins
                tally.add(simulation)
        except SimulationError as error:
            failed.append(f"{name}: {error}")
        if not np.isfinite(simulation.positions).all():
            failed.append(f"{name}: not finite")
    lost = {name: off(name) for name in PULLED} if effort.divide == 1 else {}
    met = not tally.over and not failed and all(one.worst <= WITHIN for one in lost.values())
    parts = [
        f"{tally.over} of {tally.measured:.2g} springs over, worst {tally.worst:+.0e}, {cuts} cuts "
        f"({waiting} of them for pins) in {len(cases)} cases, speeds up to {tally.fastest:.0f} m/s",
        *failed,
        *(f"{name} {one}" for name, one in lost.items()),
    ]
    target = (
        "moving pins, nets with heavy knots, meshes in wind of 8 to 30 m/s, λ 1 to 10 %, 0.1 to 20 m: every "
        "spring of every step within 1e-5 of its limit, all finite; nets and moving pins within 3 % of the "
        "converged motion"
    )
    return Row(target, "; ".join(parts), met, spread=f"worst of {len(cases)}")


def _cases(effort: Effort) -> list[tuple[str, Trial]]:
    """Name and what."""
    vertices = effort.vertices(33)
    found = [(name, one.trial) for name, one in PULLED.items()]
    for size in (0.1, 1.0, 20.0):
        for limit in (0.01, 0.05, 0.1):
            found.append((f"net of {size:g} m", Trial("net", vertices, limit, size=size)))
            for shape in SHAPES:
                wind = {"velocity": [30.0, 5.0, 0.0], "gust": {}}
                gale = Trial("storm", vertices, limit, shape, size=size, document={"wind": wind})
                found.append((f"{shape} of {size:g} m in a gale", gale))
    for seed in (1, 2, 3):
        for scene in ("flag", "cape", "skirt"):
            found.append((scene, Trial(scene, vertices, 0.03, seed=seed)))
    return found
