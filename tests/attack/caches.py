"""Caches with mistakes in their files."""

from __future__ import annotations

import shutil
from pathlib import Path
from random import Random
from typing import Any, ClassVar

import numpy as np
from taut import Cache, CacheError, CacheWriteError, Scene, Simulation, record

from tests.attack.edits import edit, edited
from tests.attack.frame import Attack, Case, Outcome

FRAMES = 6
SCENE: dict[str, Any] = {
    "title": "Damaged",
    "duration": FRAMES / 60,
    "wind": {"velocity": [3.0, 1.0, 0.0]},
    "cloth": [
        {"grid": {"cells": [6, 4]}, "pins": [{"edge": "left"}], "translate": [9e3, 0, 0]},
        {"name": "near", "grid": {"cells": [3, 3]}, "pins": [{"corner": "top-left"}]},
    ],
    "body": [
        {"name": "crate", "box": {"center": [0, 50, 0], "size": [1, 1, 1]}},
        {"name": "ball", "sphere": {"center": [0, -50, 0], "radius": 1}, "move": [[1.0, [0, 0, 1]]]},
    ],
}
CONSTANT = ("time", "faces", "springs", "pins", "spring_kind", "rest_length", "strain_limit")
MOVING = ("positions", "velocities", "origins", "local_positions", "exact_positions", "past", "stretch")


class Caches(Attack):
    """Files of a cache are changed, lost or mixed up."""

    name: ClassVar[str] = "caches"
    promise: ClassVar[str] = "files of caches: damage is seen, and a run that goes on ends with the same bits"
    unit: ClassVar[str] = "arrays"
    short: ClassVar[int] = 10

    def __init__(self) -> None:
        """Record what is to be damaged."""
        self._whole = Path("whole.zarr").absolute()
        if not self._whole.exists():
            record(Simulation(Scene(SCENE), 1), self._whole)
        self._truth = read(self._whole)

    def generate(self, random: Random) -> Case:
        """Mistakes in one or two files."""
        damage: list[list[Any]] = []
        for _ in range(random.choice([1, 1, 1, 2])):
            which = round(random.random(), 6)
            match random.choice(["edit", "edit", "edit", "lose", "mix"]):
                case "edit":
                    damage.append(
                        [which, "edit", [edit(random, []) for _ in range(random.choice([1, 1, 3]))]]
                    )
                case "lose":
                    damage.append([which, "lose", 0])
                case _:
                    damage.append([which, "mix", round(random.random(), 6)])
        return {"damage": damage, "resume": random.random() < 0.3}

    def judge(self, case: Case) -> Outcome:
        """Read all of it, or go on."""
        copied = Path("copied.zarr").absolute()
        shutil.rmtree(copied, ignore_errors=True)
        shutil.copytree(self._whole, copied)
        files = sorted(path for path in copied.rglob("*") if path.is_file())
        for which, kind, how in case["damage"]:
            path = files[int(which * len(files))]
            if kind == "lose":
                path.unlink(missing_ok=True)
            elif path.exists():
                other = (
                    self._whole / files[int(how * len(files))].relative_to(copied) if kind == "mix" else None
                )
                path.write_bytes(other.read_bytes() if other else edited(path.read_bytes(), how))
        try:
            if case["resume"]:
                record(Simulation(Scene(SCENE), 1), copied, existing="resume")
            found = read(copied)
        except (CacheError, CacheWriteError):
            return Outcome(refused=True)
        for name, value in self._truth.items():
            if not same(found.get(name), value):
                return Outcome(f"{name} reads otherwise, and nothing is said")
        return Outcome(looked_at=len(found))


def read(path: Path) -> dict[str, Any]:
    """All that a cache says.

    Raises:
        CacheError: it is damaged, and says so.
    """
    cache = Cache.open(path)
    found: dict[str, Any] = {name: getattr(cache, name) for name in CONSTANT}
    found |= {f"diagnostics {name}": numbers for name, numbers in cache.diagnostics.items()}
    found |= {"frames": cache.frames, "attributes": cache.attributes, "title": cache.title}
    found.pop("diagnostics ms", None)
    for frame in range(cache.frames):
        found |= {f"{name} {frame}": getattr(cache, name)(frame) for name in MOVING}
        for name, body in cache.bodies(frame).items():
            found |= {f"{name} {frame}": body.positions, f"{name} {frame} triangles": body.triangles}
    return found


def same(found: Any, true: Any) -> bool:
    """Whether two values are the same, bit by bit."""
    if isinstance(true, np.ndarray):
        return (
            isinstance(found, np.ndarray) and found.dtype == true.dtype and np.array_equal(found, true, True)
        )
    if isinstance(true, dict) and isinstance(found, dict):
        # Threads and the title may change when a run goes on.
        return {**found, "threads": 1} == {**true, "threads": 1}
    return bool(found == true)
