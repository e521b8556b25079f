"""Rows that compare irregular meshes, sheets of other sizes and heavy tips with their converged motion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.targets.converged import ALL, MESHES, converged
from tools.targets.reference import path
from tools.targets.table import Effort, Row

WITHIN = 0.03  # of the peak speed, and of the size


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
