"""The row about fast balls: none may be found on the other side of a sheet."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from taut import Simulation

from tools.targets.contact.scenes import Fields, Stage, ball, kind, sheet
from tools.targets.contact.watch import Case, Found, Watch, measured, row
from tools.targets.table import Effort, Row

SPEEDS = (20.0, 100.0)  # [m/s]
RATES = (30, 60, 240)  # steps a second
RADIUS = 0.1  # of the ball [m]
BEFORE, BEHIND = 2.0, 0.3  # where its flight begins before the sheet, and ends behind it [m]
END = np.array([0.02, BEHIND, 0.5])
Points = NDArray[np.float64]
CLOTH: Fields = {"thickness": 0.004, "bending": "fabric"}
MORE = {
    "through": ("parts of steps with the ball behind the sheet", 1.0),
    "end": ("ball late at the end [mm]", 1e3),
}


def shots(effort: Effort) -> Row:
    """Balls of two speeds, steps of three lengths."""
    found = measured(_cases(effort), effort)
    target = (
        "ball of 20 and of 100 m/s at a hanging sheet of 33², steps of 1/30 to 1/240 s, grids and meshes: no "
        "intersection, no crossing, the limit kept, the ball never behind the sheet"
    )
    return row(target, found, MORE)


def _cases(effort: Effort) -> Iterator[Case]:
    across = effort.cells(32) + 1
    for speed in SPEEDS:
        for rate in RATES:
            for mesh in (False, True):
                name = f"{speed:g} m/s, {rate} steps a second, {kind(mesh)} of {across}²"
                yield name, partial(_measured, name, shot(across, mesh, speed, rate), speed, effort)


def shot(across: int, mesh: bool, speed: float, rate: int) -> Stage:
    """A sheet that hangs by its upper edge, and a ball that flies against its middle and stops."""
    way = BEFORE + BEHIND
    heavy = ball([0.02, -BEFORE, 0.5], RADIUS, move=[[0.1, [0, 0, 0]], [0.1 + way / speed, [0, way, 0]]])
    upper = [{"box": [[-2, -2, 0.9999], [2, 2, 1.1]]}]
    fields = CLOTH | sheet(across, mesh=mesh) | {"rotate": [90.0, 0, 0], "translate": [0, 0, 0.5]}
    solver = {"substeps": 1, "force_step": True}
    return Stage({"fps": rate, "solver": solver}).body(heavy).cloth("sheet", pins=upper, **fields)


def _measured(name: str, made: Stage, speed: float, effort: Effort) -> Found:
    simulation = made.simulation()
    vertices = len(simulation.mass)
    through, arrived = 0, False

    def look(simulation: Simulation) -> None:
        """At all parts of the flight: later the sheet flies on and wraps itself round the ball."""
        nonlocal through, arrived
        for moment in simulation.trace or ():
            if not arrived:
                places, centre = moment[:vertices], moment[vertices]
                through += behind(places[simulation.faces], centre)
                arrived = bool(np.linalg.norm(centre - END) < 1e-9)

    seconds = 0.8 if effort.whole else 0.25
    # Steps are cut where something so fast comes; that is no fault as long as the ball catches up.
    watch = Watch(name, simulation).run(round(seconds * simulation.scene.fps), each=look)
    if not arrived:
        watch.found.failed = watch.found.failed or "the ball never arrives"
    watch.found.add("through", through, 0)
    watch.found.add("end", float(np.linalg.norm(simulation.bodies["ball"].positions[0] - END)))
    return watch.done(cut=np.inf)


def behind(corners: Points, centre: Points) -> bool:
    """Whether triangles, shape (n, 3, 3), lie between the middle of the ball and where it came from."""
    flat = (corners - centre)[:, :, [0, 2]]
    sides = []
    for a in range(3):
        one, other = flat[:, a], flat[:, (a + 1) % 3]
        sides.append(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    around = np.sign(sides)
    meets = np.abs(around.sum(axis=0)) == 3
    # Where the line along y through the middle meets the triangle.
    weights = np.roll(np.array(sides), -1, axis=0)[:, meets]
    depth = (weights.T * (corners[meets, :, 1] - centre[1])).sum(axis=1) / weights.sum(axis=0)
    return bool((depth < 0).any())
