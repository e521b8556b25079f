"""Runs that are killed, and go on."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from pathlib import Path
from random import Random
from typing import Any, ClassVar

from taut import Cache, CacheError, Scene, Simulation, record

from tests.attack.frame import Attack, Case, Outcome

FRAMES = 120
SCENE: dict[str, Any] = {
    "duration": FRAMES / 60,
    "wind": {"velocity": [8.0, 1.5, 0.0], "gust": {}},
    "cloth": [{"grid": {"cells": [6, 4]}, "pins": [{"edge": "left"}]}],
}
SCRIPT = """\
import json, sys, taut
scene = taut.Scene(json.loads(sys.argv[1]))
taut.record(taut.Simulation(scene, 1), sys.argv[2], existing="resume")
"""
INTEGRATORS = ["euler", "bdf2", "verlet"]


class Resumes(Attack):
    """Kills at any moment."""

    name: ClassVar[str] = "resumes"
    promise: ClassVar[str] = "runs killed at any moment: whole frames only, the same bits at the end"
    unit: ClassVar[str] = "kills"
    short: ClassVar[int] = 1

    def __init__(self) -> None:
        """Nothing is known of runs that are not killed yet."""
        self._hashes: dict[str, str] = {}

    def generate(self, random: Random) -> Case:
        """When it is killed, after it has begun to write [s]."""
        kills = [round(random.uniform(0, 0.8), 4) for _ in range(random.randint(1, 3))]
        return {"integrator": random.choice(INTEGRATORS), "kills": kills}

    def judge(self, case: Case) -> Outcome:
        """Run, kill, go on, compare."""
        integrator = case["integrator"]
        document = {**SCENE, "solver": {"integrator": integrator}}
        if integrator not in self._hashes:
            self._hashes[integrator] = _end(document, Path(f"{integrator}.zarr"))
        out = Path("killed.zarr")
        shutil.rmtree(out, ignore_errors=True)
        for delay in case["kills"]:
            if failure := _killed(document, out, delay):
                return Outcome(failure)
        if out.exists() and not any(out.iterdir()):
            return Outcome("an empty folder is left")
        if _end(document, out) != self._hashes[integrator]:
            return Outcome("a run that was killed ends with other bits")
        return Outcome(looked_at=len(case["kills"]))


def _end(document: dict[str, Any], out: Path) -> str:
    record(Simulation(Scene(document), 1), out, existing="resume")
    return str(Cache.open(out).attributes["state_hash"])


def _killed(document: dict[str, Any], out: Path, delay: float) -> str:
    run = subprocess.Popen([sys.executable, "-c", SCRIPT, json.dumps(document), str(out)])
    begun = time.monotonic()
    while not out.exists() and run.poll() is None and time.monotonic() < begun + 30:
        time.sleep(0.01)
    time.sleep(delay)
    run.kill()
    run.wait()
    try:
        cache = Cache.open(out)
    except CacheError as error:
        return "" if not out.exists() else f"what was killed cannot be read: {error}"
    whole = all(cache.is_whole(frame) for frame in range(cache.frames))
    return "" if whole else "a frame of what was killed is not whole"
