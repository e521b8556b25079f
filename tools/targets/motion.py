"""Rows about motion: the limit must not cost the cloth its swing. Compared with the converged motion."""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from taut.bench import Case

from tools.targets.reference import (
    FRAMES,
    SCENES,
    SHAPE_EVERY,
    SHAPES,
    STRAIN_LIMIT,
    path,
    reference,
    reference_shapes,
    shapes,
)
from tools.targets.table import Effort, Row


@cache
def default(scene: str, cells: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centre of mass [m] and its speed [m/s] at the settings of the rows about time."""
    return path(Case(scene, cells, STRAIN_LIMIT).simulation(), FRAMES)


def peak_speed(effort: Effort) -> Row:
    """Peak speed of the centre of mass."""
    parts, worst = [], 0.0
    for cells in (64, 128) if effort.divide == 1 else (32,):
        for scene in SCENES:
            found, expected = default(scene, cells)[1].max(), reference(scene, cells)[1].max()
            off = found / expected - 1
            worst = max(worst, abs(off))
            parts.append(f"{cells}² {scene} {100 * off:+.1f} % ({found:.2f} / {expected:.2f} m/s)")
    target = "peak speed of the centre of mass against the converged motion, 64² and 128²: within 3 %"
    return Row(target, "; ".join(parts), worst <= 0.03)


def path_of_the_centre(effort: Effort) -> Row:
    """How far the centre of mass leaves the converged path in the first second."""
    cells, parts, worst = 64 if effort.divide == 1 else 32, [], 0.0
    for scene in SCENES:
        apart = np.linalg.norm(default(scene, cells)[0] - reference(scene, cells)[0], axis=1)
        worst = max(worst, apart.max())
        parts.append(f"{scene} {100 * apart.max():.1f} % at {apart.argmax() / 60:.2f} s")
    target = "path of the centre of mass, 65 x 65 particles, first second: within 2 % of the cloth's size"
    return Row(target, f"{cells}²: " + "; ".join(parts), worst <= 0.02)


def heavy_tip(effort: Effort) -> Row:
    """How far a sheet with a heavy corner leaves the converged motion: centre of mass, and all of it."""
    cells, scene = 64 if effort.divide == 1 else 32, SHAPES[0]
    found = shapes(Case(scene, cells, STRAIN_LIMIT).simulation(), cells, FRAMES)
    centre, particles = (
        np.linalg.norm(now - then, axis=-1)
        for now, then in zip(found, reference_shapes(scene, cells), strict=True)
    )
    shape = np.sqrt((particles**2).mean(axis=1))
    reached = (
        f"{cells}²: centre of mass {100 * centre.max():.1f} % at {centre.argmax() / 60:.2f} s; particles "
        f"{100 * shape.max():.1f} % root mean square at {shape.argmax() * SHAPE_EVERY / 60:.1f} s"
    )
    target = (
        "0.2 kg at the free corner of a 0.2 kg sheet: path and shape follow the converged motion for a "
        "second: within 2 % of the size"
    )
    return Row(target, reached, max(centre.max(), shape.max()) <= 0.02)
