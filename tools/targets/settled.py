"""Rows that compare irregular meshes, sheets of other sizes and heavy tips with their converged motion."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tools.targets.converged import ALL, MESHES, PENDULUMS, SCALES, TIPS, converged
from tools.targets.record import Motion
from tools.targets.reference import path
from tools.targets.table import Effort, Row

WITHIN = 0.03  # of the peak speed, and of the size
STEPS = (4, 8, 16, 32, 64)  # a frame


@dataclass(frozen=True, slots=True)
class Off:
    """How far a motion is off the converged one."""

    speed: float
    """Of the peak speed of the centre of mass, relative [1]."""
    path: float
    """Of its place in any frame, in sizes of the cloth [1]."""

    @property
    def worst(self) -> float:
        """The larger one."""
        return max(abs(self.speed), self.path)

    def __str__(self) -> str:
        """For the table."""
        return f"peak {100 * self.speed:+.1f} %, path {100 * self.path:.1f} %"


def compared(
    found: tuple[NDArray[np.float64], NDArray[np.float64]],
    expected: tuple[NDArray[np.float64], NDArray[np.float64]],
    size: float,
) -> Off:
    """Peak speed and path of two motions of the same frames."""
    apart = np.linalg.norm(found[0] - expected[0], axis=1).max() / size
    return Off(float(found[1].max() / expected[1].max() - 1), float(apart))


def off(name: str, solver: dict[str, object] | None = None) -> Off:
    """How far the default settings are off the motion of that name in the file."""
    one = ALL[name]
    return compared(path(one.trial.simulation(solver), one.frames), converged(name), one.trial.extent)


def mesh_motion(effort: Effort) -> Row:
    """Irregular meshes against converged sweeps on the same meshes."""
    names = [name for name in MESHES if effort.divide == 1 or name.endswith("33²")]
    found = {name: off(name) for name in names}
    held = sum(one.worst <= WITHIN for one in found.values())
    reached = f"{held} of {len(found)} hold it: " + "; ".join(f"{name} {one}" for name, one in found.items())
    target = (
        "irregular meshes, first second: peak speed of the centre of mass within 3 % of the converged "
        "motion of the same mesh, path within 3 % of the size"
    )
    return Row(target, reached, held == len(found), spread=f"worst of {len(found)}")


def scales(effort: Effort) -> Row:
    """A doll's cloth and a sail: motion, cuts and cycles."""
    parts, met = [], True
    for name, one in SCALES.items():
        if effort.divide > 1 and one.frames > 60:
            continue
        simulation = one.trial.simulation()
        found = Motion.of(simulation, one.frames)
        again = one.trial.simulation()
        cuts = sum(again.step(again.substeps).cuts for _ in range(one.frames))
        apart = off(name)
        hard, usual = float(np.percentile(found.cycles, 95)), float(np.median(found.cycles))
        met = met and apart.worst <= WITHIN and cuts == 0
        parts.append(f"{name} {apart}, {cuts} cuts, cycles a step {usual:.3g} (95 %: {hard:.3g})")
    target = (
        "sheets of 0.1 and 20 m that fall from one corner, 33², a second scaled by the root of the size: "
        "peak speed within 3 % of the converged motion, path within 3 % of the size, no cuts"
    )
    return Row(target, "; ".join(parts), met, spread=f"worst of {len(SCALES)}")


def tips(effort: Effort) -> Row:
    """Heavy tips at automatic steps and at more and more of them."""
    parts, met = [], True
    steps = STEPS if effort.whole else STEPS[:2]
    for name in TIPS:
        automatic = off(name)
        errors = [off(name, {"substeps": substeps}).worst for substeps in steps]
        # Below half a per cent the converged motion is no better than what is compared with it.
        shrinks = all(after <= 1.02 * before or after <= 0.005 for before, after in pairwise(errors))
        met = met and automatic.worst <= WITHIN and shrinks
        worst = ", ".join(f"{100 * error:.1f}" for error in errors)
        parts.append(f"{name} {automatic}; at {steps[0]} to {steps[-1]} steps {worst} %")
    target = (
        "0.05 to 0.5 kg at the free corner of a 0.2 kg sheet, first second, automatic steps: peak speed and "
        "path within 3 %; the larger of both shrinks with every doubling from 4 to 64 steps a frame"
    )
    return Row(target, "; ".join(parts), met, spread=f"worst of {len(TIPS)}")


def swing(effort: Effort) -> Row:
    """Period of hanging sheets, and how much of the swing is left, against the converged motion."""
    parts, met = [], True
    for name, one in PENDULUMS.items():
        centre, _ = path(one.trial.simulation(), one.frames)
        expected, _ = converged(name)
        fps = one.trial.simulation().scene.fps
        apart = period(centre[:, 1], fps) / period(expected[:, 1], fps) - 1
        last = round(2 * fps)
        kept = float(np.ptp(centre[-last:, 1]) / np.ptp(expected[-last:, 1]))
        met = met and abs(apart) <= 0.01 and kept >= 0.95
        parts.append(f"{name}: period {100 * apart:+.2f} %, swing {kept:.3f} of the converged one after 5 s")
    target = (
        "sheets of 33² that swing from their upper edge, from 10 degrees aside, 5 s without drag: period "
        "within 1 % of the converged motion, at least 0.95 of its swing left"
    )
    return Row(target, "; ".join(parts), met)


def period(place: NDArray[np.float64], fps: float) -> float:
    """Twice the mean time between passages through zero [s]; infinite if there are less than two."""
    before = np.flatnonzero(place[:-1] * place[1:] < 0)
    crossings = (before + place[before] / (place[before] - place[before + 1])) / fps
    return float(2 * np.diff(crossings).mean()) if len(crossings) > 1 else float("inf")
