"""Scenes with one value that nobody would give: each must run within its limits, or be refused by name."""

from __future__ import annotations

import copy
import math
import random
import re
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut import Scene, SceneError, Simulation

from tests.attack.frame import Outcome

PATIENCE = 5.0
"""A scene of a few vertices may take so much of the processor to be built and to make a few steps [s]."""

STEPS = 4
LONGEST = 1000
"""A message that tells what a step follows from lists some twenty fields, each cut short [characters]."""

ROUNDING = 1e-4
"""How far over its limit a spring may seem, as its length is measured from places in single precision [1]."""

NUMBERS: tuple[Any, ...] = (
    *(1e-45, 1.4e-45, 1e-38, 1e-30, 1e-20, 1e-10, 1e-6, 1e-3, 1e3, 1e6, 1e10, 1e20, 1e30, 1e38, 1e300),
    *(0, -0.0, -1, -1e-30, 1, 2**31, 2**64, 10**400, -(10**400), math.nan, math.inf, -math.inf),
)
OTHERS: tuple[Any, ...] = (
    "",
    "nonsense",
    "\ud800",
    "x" * 100_000,
    True,
    None,
    [],
    [1],
    [[]],
    {},
    {"": 1},
    {"no": {}},
)

_GRID: dict[str, Any] = {
    "title": "grid",
    "duration": 1.0,
    "fps": 60.0,
    "gravity": [0.0, 0.0, -9.81],
    "gravity_keyframes": [[0.02, [0.0, 1.0, -9.0]]],
    "wind": {
        "velocity": [3.0, 1.0, 0.0],
        "keyframes": [[0.01, [4.0, 1.0, 0.0]]],
        "gust": {"strength": 0.3, "period": 1.7, "seed": 1},
        "elements": [
            {"kind": "uniform", "velocity": [0.5, 0.0, 0.0]},
            {"kind": "vortex", "centre": [0.5, 0.2, 0.5], "axis": [0, 0, 1], "circulation": 1.0, "core": 0.1},
            {"kind": "source", "centre": [0.2, -0.5, 0.5], "flow": 1.0, "core": 0.1},
        ],
        "density": 1.2,
    },
    "cloth": [
        {
            "name": "sheet",
            "grid": {"size": [0.6, 0.4], "cells": [6, 4], "origin": [0.0, 0.0, 1.0], "axes": ["x", "z"]},
            "scale": 1.0,
            "rotate": [0.0, 10.0, 0.0],
            "translate": [0.0, 0.0, 0.1],
            "strain_limit": 0.05,
            "strain_limit_keyframes": [[0.5, 0.04]],
            "density": 0.2,
            "stiffness": 20.0,
            "shear_stiffness": 10.0,
            "flexion_stiffness": 0.01,
            "bending": 1e-5,
            "damping": 0.005,
            "air_drag": 0.1,
            "drag_coefficient": 1.2,
            "lift_coefficient": 1.0,
            "friction_coefficient": 0.01,
            "pins": [{"corner": "top-left", "move": [[0.0, [0, 0, 0]], [0.2, [0.01, 0.0, 0.0]]]}],
            "weights": [{"corner": "bottom-right", "mass": 0.01}],
        }
    ],
    "solver": {"substeps": "auto", "iterations": 200, "tolerance": 0.001},
}
_NETWORK: dict[str, Any] = {
    "fps": 60.0,
    "cloth": [
        {
            "network": {
                "points": [[0.1 * bead, 0.0, 1.0] for bead in range(5)],
                "links": [[bead, bead + 1] for bead in range(4)],
                "mass": [0.003, 0.003, 0.003, 0.003, 0.02],
            },
            "strain_limit": 0.05,
            "stiffness": 100.0,
            "bending": 1e-5,
            "pins": [{"vertices": [0]}],
            "weights": [{"nearest": [0.4, 0.0, 1.0], "mass": 0.01}],
        },
        {"network": {"points": [[0.0, 1.0, 0.0], [0.0, 1.2, 0.0]], "links": [[0, 1]], "mass": 0.001}},
    ],
}
_CURVES: dict[str, Any] = {
    "wind": {"velocity": [2.0, 1.0, 0.0], "law": "drag_lift", "model": "triangle"},
    "cloth": [
        {
            "grid": {"size": [0.6, 0.4], "cells": [6, 4], "axes": ["x", "y"]},
            "density": 0.2,
            "curves": {
                "tension": [[0, 0], [0.03, 1.5], [0.05, 40.0]],
                "tension_weft": [[0, 0], [0.04, 1.5], [0.06, 40.0]],
                "shear": [[0, 0], [0.1, 0.5], [0.3, 2.0]],
                "bending": [[0, 0], [50.0, 1e-4], [100.0, 1.5e-4]],
            },
            "pins": [{"edge": "left"}, {"box": [[-1.0, -1.0, -1.0], [0.01, 1.0, 1.0]]}],
        }
    ],
}
_MESH: dict[str, Any] = {
    "wind": {"velocity": [2.0, 1.0, 0.0], "gust": {}},
    "cloth": [
        {
            "mesh": "sheet",
            "scale": 0.5,
            "rotate": [90.0, 0.0, 0.0],
            "translate": [0.0, 0.0, 1.0],
            "density": 0.2,
            "bending": "fabric",
            "pins": [{"vertices": [0, 1]}],
            "weights": [{"vertices": [12], "mass": 0.002}],
        }
    ],
}
_BODIES: dict[str, Any] = {
    "contact": {"self": False},
    "cloth": [
        {
            "grid": {"size": [0.4, 0.4], "cells": [4, 4], "axes": ["x", "y"], "origin": [0.0, 0.0, 1.0]},
            "density": 0.2,
            "thickness": 0.002,
            "friction": 0.4,
            "pins": [{"corner": "top-left"}],
        }
    ],
    "body": [
        {
            "name": "ball",
            "sphere": {"center": [0.2, 0.2, 0.0], "radius": 0.1},
            "friction": 0.2,
            "thickness": 0.002,
            "turn": {"axis": [0.0, 0.0, 1.0], "point": [0.2, 0.2, 0.0], "angle": [[0.5, 90.0], [1.0, 0.0]]},
            "move": [[0.0, [0.0, 0.0, 0.0]], [1.0, [0.1, 0.0, 0.0]]],
        },
        {"capsule": {"from": [-1.0, 0.0, 0.0], "to": [-0.9, 1.0, 0.3], "radius": 0.05}},
        {"box": {"center": [1.0, 0.0, 0.0], "size": [0.1, 0.2, 0.3], "rotate": [0.0, 0.0, 45.0]}},
        {"plane": {"point": [0.0, 0.0, -1.0], "normal": [0.0, 0.0, 1.0]}, "move": [[1.0, [0.0, 0.0, 0.1]]]},
        {"mesh": "sheet", "scale": 0.5, "rotate": [90.0, 0.0, 0.0], "translate": [0.0, 0.0, -0.5]},
    ],
}
BASES: dict[str, dict[str, Any]] = {
    "grid": _GRID,
    "network": _NETWORK,
    "curves": _CURVES,
    "mesh": _MESH,
    "bodies": _BODIES,
}

INTEGRATORS = ("euler", "forward_euler", "midpoint", "rk4", "verlet", "implicit_euler", "bdf2")
FILTERS = (
    *("coarse_to_fine", "none", "sequential", "sweeps", "provot"),
    *("rods", "fast_projection", "tethers", "xpbd"),
)

Path = tuple[str | int, ...]


@dataclass(frozen=True)
class Mutant:
    """A scene of which some values were replaced."""

    base: str
    changes: tuple[tuple[Path, Any], ...]
    document: dict[str, Any]

    @property
    def fields(self) -> list[str]:
        """Where the values stand, as errors write it: ``cloth[0].grid.size[1]``."""
        return [_written(path) for path, _ in self.changes]

    def __str__(self) -> str:
        changes = [f"{_written(path)} = {repr(value)[:40]}" for path, value in self.changes]
        solver = [self.document["solver"].get(name, "-") for name in ("integrator", "filter")]
        return f"{self.base}, {'/'.join(solver)}: {', '.join(changes)}"


def _written(path: Path) -> str:
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return "".join(parts).removeprefix(".")


def places(value: Any, path: Path = ()) -> Iterator[Path]:
    """Where every single value of a document stands."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from places(item, (*path, key))
    elif path:
        yield path


def mutant(base: str, changes: Mapping[Path, Any], solver: Mapping[str, str] | None = None) -> Mutant:
    """The scene `base` with other values at some places."""
    document = copy.deepcopy(BASES[base])
    document["solver"] = document.get("solver", {}) | dict(solver or {})
    for path, value in changes.items():
        place: Any = document
        for part in path[:-1]:
            place = place[part]
        place[path[-1]] = value
    return Mutant(base, tuple(changes.items()), document)


@cache
def solvers(base: str) -> list[dict[str, str]]:
    """Integrators and filters that suit a base as it is."""
    pairs = [{"integrator": one, "filter": other} for one in INTEGRATORS for other in FILTERS]
    return [pair for pair in pairs if _is_fine(base, pair)]


def _is_fine(base: str, solver: dict[str, Any]) -> bool:
    try:
        Simulation(_scene(mutant(base, {}, solver)), threads=1)
    except SceneError:
        return False
    return True


def every_mutant() -> Iterator[Mutant]:
    """Every value of every base replaced by every number, with the solver that scenes have by default."""
    for base, document in BASES.items():
        for path in places(document):
            for value in (*NUMBERS, *OTHERS):
                yield mutant(base, {path: value})


def mutants(seed: int, count: int) -> Iterator[Mutant]:
    """Scenes with one to three values replaced at random, under random integrators and filters.

    Args:
        seed: the same seed gives the same scenes.
        count: how many.
    """
    random_ = random.Random(seed)
    for _ in range(count):
        base = random_.choice(list(BASES))
        solver = random_.choice(solvers(base)) if random_.random() < 0.5 else {}
        paths = random_.sample(list(places(BASES[base])), random_.choice((1, 1, 2, 3)))
        values = NUMBERS if len(paths) > 1 or random_.random() < 0.8 else OTHERS
        changes = {path: _drawn(random_, _value(BASES[base], path), values) for path in paths}
        yield mutant(base, changes, solver)


def _value(document: Any, path: Path) -> Any:
    for part in path:
        document = document[part]
    return document


def _drawn(random_: random.Random, given: Any, values: tuple[Any, ...]) -> Any:
    drawn = random_.random()
    if drawn < 0.2:
        return random_.choice(values)
    if drawn < 0.3:
        return random_.choice((1, 1, 1, -1)) * 10 ** random_.uniform(-46, 39)
    number = given if type(given) in (int, float) and given else 1.0
    scaled = number * 10 ** random_.gauss(0, 2)
    return round(min(scaled, 40 * given)) if type(given) is int else scaled  # few cells keep scenes fast


def judge(scene: Mutant) -> Outcome:
    """What becomes of a scene.

    It is to be refused with an error that names the field, in a few lines; or to make a few steps in bounded
    time, with finite places and, under ``coarse_to_fine``, no spring over its limit.
    """
    began = time.process_time()
    try:
        simulation = Simulation(_scene(scene), threads=1)
        for _ in range(STEPS):
            simulation.step()
            _check_time(began)
    except SceneError as error:
        return Outcome(_wrong_with_refusal(scene, str(error)), refused=True)
    except Exception as error:
        return Outcome(f"{scene}: {type(error).__name__}: {error}"[:400])
    try:
        _check_time(began)
    except TimeoutError as error:
        return Outcome(f"{scene}: {error}")
    return Outcome(_wrong_with_state(scene, simulation), looked_at=len(simulation.springs))


def _scene(scene: Mutant) -> Scene:
    vertices = [[0.2 * x, 0.2 * y, 0.01 * ((3 * x + y) % 4)] for y in range(5) for x in range(5)]
    corners = [5 * y + x for y in range(4) for x in range(4)]
    faces = [[a + step for step in steps] for a in corners for steps in ((0, 1, 6), (0, 6, 5))]
    return Scene(scene.document, {"sheet": (vertices, faces)})


def _check_time(began: float) -> None:
    took = time.process_time() - began
    if took > PATIENCE:
        raise TimeoutError(f"took {took:.1f} s")


def _wrong_with_refusal(scene: Mutant, message: str) -> str:
    if len(message) > LONGEST:
        return f"{scene}: is refused in {len(message)} letters: {message[:100]} .."
    if "\n" in message or "did you mean `" in message and not re.search(r"did you mean `\w+`\?", message):
        return f"{scene}: is refused oddly: {message}"
    # A list may be named as a whole.
    names = {re.sub(r"(?<!^cloth)(?<!^body)\[\d+\].*", "", field) for field in scene.fields}
    if not any(name in message for name in names):
        return f"{scene}: is refused without its name: {message}"
    return ""


def _wrong_with_state(scene: Mutant, simulation: Simulation) -> str:
    places, report = simulation.local_positions, simulation.report
    if not (np.isfinite(places).all() and np.isfinite(simulation.velocities).all()):
        return f"{scene}: is not finite"
    energies = report.kinetic_energy, report.elastic_energy, report.potential_energy
    if not np.isfinite(energies).all():
        return f"{scene}: its energies are {energies}"
    if scene.document["solver"].get("filter", "coarse_to_fine") != "coarse_to_fine":
        return ""
    ends = places[simulation.springs].astype(np.float64)
    stretch = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) / simulation.rest_length - 1
    held = simulation.pinned[simulation.springs].all(axis=1)
    limits = _limits(scene.document, simulation)
    over = (stretch - limits)[~held & np.isfinite(limits)]
    if over.size and not over.max() <= ROUNDING:
        return f"{scene}: a spring is {over.max()} over its limit"
    return ""


def _limits(document: dict[str, Any], simulation: Simulation) -> NDArray[np.float64]:
    """The limit of each spring at the end of the frame in hand [1]."""
    limits = simulation.strain_limit.astype(np.float64)
    fps = simulation.scene.fps
    end = math.ceil(simulation.time * fps * (1 - 1e-9)) / fps
    for cloth, given in zip(simulation.cloths, document["cloth"], strict=True):
        keys = given.get("strain_limit_keyframes", ())
        first = simulation.springs[:, 0]
        own = (
            (first >= cloth.first_vertex) & (first < cloth.first_vertex + cloth.vertices) & (limits < np.inf)
        )
        if keys and own.any():
            times, values = zip((0.0, limits[own][0]), *keys, strict=True)
            limits[own] = np.interp(end, times, values)
    return limits
