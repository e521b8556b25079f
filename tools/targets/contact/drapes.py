"""The row about sheets on a ball, on the corner of a cube and on a ball that spins."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from taut import Simulation

from tools.targets.contact.scenes import FLOOR, Fields, Stage, ball, corner_up, kind, sheet
from tools.targets.contact.watch import Case, Found, Watch, measured, row
from tools.targets.record import Motion, rms
from tools.targets.rest import CALMING
from tools.targets.table import Effort, Row

ON = ("ball", "corner", "spinning ball")
ACROSS = (65, 129)
SECONDS = 6.0  # [s], when a sheet must have come to lie
REST = 2e-5  # [m], root mean square of second differences
DRAPE = 0.01  # of the size: height of the centre of mass, and the heights of all vertices
TURNED = 0.1  # of the angle by which a sheet on a ball that turns has turned at 4 x finer steps
FINER = 4  # times as many steps, of what a drape is compared with
CLOTH: Fields = {"thickness": 0.004, "bending": "fabric", "air_drag": CALMING}
MORE = {
    "rest": ("second differences [mm]", 1e3),
    "drape": ("centre of mass off 4 x finer steps [% of the size]", 100.0),
    "profile": ("heights off [%]", 100.0),
    "turned": ("angle off [%]", 100.0),
}


def drapes(effort: Effort) -> Row:
    """What comes to lie, and what is turned under it."""
    found = measured(_cases(effort), effort)
    target = (
        "sheets of 1 m, 65² and 129², grids and irregular meshes, on a ball, on the corner of a cube, on a "
        "ball of friction 0.4 that turns by 180 degrees/s: no intersection, no crossing, the limit kept, "
        "≤ 1 % of the steps in contact cut; after 6 s second differences ≤ 0.02 mm root mean square (not on "
        "the one that turns), drapes of 65² within 1 % of the size of those at 4 x finer steps, and turned "
        "by within 10 % of the same angle after 3 s"
    )
    return row(target, found, MORE)


def _cases(effort: Effort) -> Iterator[Case]:
    for across in ACROSS[: 2 if effort.whole else 1]:
        for on in ON:
            for mesh in (False, True):
                size = effort.cells(across - 1) + 1
                name = f"{on}, {kind(mesh)} of {size}²"
                yield name, partial(_measured, name, on, size, mesh, effort)


def stage(on: str, across: int, mesh: bool) -> Stage:
    """A sheet above something, a little off its middle."""
    if on == "corner":
        body = corner_up([0, 0, 0.4], 0.4)
        top = 0.4 + 0.2 * np.sqrt(3)
    else:
        turn = {"axis": [0, 0, 1], "point": [0, 0, 0], "angle": [[1, 0], [101, 18000]]}
        body = ball([0, 0, 0.4], 0.3, friction=0.4, **({"turn": turn} if on == "spinning ball" else {}))
        top = 0.7
    place = [0.03, -0.01, float(top) + 0.08]
    fields = CLOTH | {"friction": 0.4} | sheet(across, mesh=mesh)
    return Stage({"fps": 60}).body(FLOOR, body).cloth("sheet", translate=place, **fields)


def _measured(name: str, on: str, across: int, mesh: bool, effort: Effort) -> Found:
    frames = effort.length(SECONDS)
    made = stage(on, across, mesh)
    watch = Watch(name, made.simulation()).run(frames)
    profile = heights(watch.simulation)
    if not watch.found.failed and on != "spinning ball":
        watch.found.add("rest", rms(Motion.of(watch.simulation, 31).shaking()), REST)
    found = watch.done()
    if not found.failed and across <= ACROSS[0]:
        finer = made.simulation(solver={"substeps": FINER * watch.simulation.substeps})
        if on == "spinning ball":
            within = min(frames, effort.length(SECONDS / 2))
            angle, expected = turned(made.simulation(), within), turned(finer, within)
            found.add("turned", abs(angle - expected) / max(abs(expected), 1.0), TURNED)
        else:
            finer.run(frames)
            other = heights(finer)
            found.add("drape", abs(float(profile.mean() - other.mean())), DRAPE)
            found.add("profile", float(np.sqrt(((profile - other) ** 2).mean())), DRAPE)
    return found


def turned(simulation: Simulation, frames: int) -> float:
    """How far all vertices turn round a vertical axis through their centre in so many frames [degrees]."""
    total, before = 0.0, None
    for _ in range(frames):
        simulation.step(simulation.substeps)
        places = simulation.exact_positions[:, :2]
        arms = (places - places.mean(axis=0)) @ np.array([1.0, 1.0j])
        if before is not None:
            total += float(np.angle((before.conj() * arms).sum(), deg=True))
        before = arms
    return total


def heights(simulation: Simulation) -> NDArray[np.float64]:
    """Of all vertices, in rising order [m]: folds may lie elsewhere and be as high."""
    return np.sort(simulation.exact_positions[:, 2])
