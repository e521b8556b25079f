"""Runs one case with contact: writes the job, starts the adapter, has the oracle judge the frames."""

import json
import math
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from contact.oracle import Oracle
from contact.results import Outcome
from contact.scenes import FRAMES, ContactSheet
from runner import call, machine
from store import Case

LEAST = 45
"""Frames that every run makes, however slow: 0.75 s, in which the sheet falls and lands."""
SPARE_TIME = 3600.0
"""Wall-clock time [s] that an adapter may take beyond its CPU time: a guard against what hangs."""


@cache
def _judged(scene: str, size: int) -> tuple[ContactSheet, Oracle]:
    sheet = ContactSheet(scene, size)
    return sheet, Oracle(sheet)


def run(command: list[str], case: Case, environment: Path, seconds: float, least: int = LEAST) -> Outcome:
    """Run a case until its last frame, or until its time is used up.

    Args:
        command: runs the engine's adapter.
        case: what to run.
        environment: the engine's environment.
        seconds: CPU time for the frames [s].
        least: frames that are made even if that is not enough.

    Returns:
        The result, also of a failure.
    """
    return _run(command, case, environment, seconds, least, judged=True)


def least_seconds(run: Outcome | None) -> float:
    """CPU time that timing a run again takes at least [s]."""
    return math.inf if run is None else sum(run.cpu_ms[:LEAST]) / 1e3


def retime(command: list[str], case: Case, environment: Path, seconds: float) -> Outcome:
    """Time the frames of a case again, for about this long [s]; the result has nothing but times."""
    outcome = _run(command, case, environment, seconds, LEAST, judged=False)
    if outcome.error is not None:
        raise RuntimeError(f"{case.key}: could not be timed again ({outcome.error})")
    return outcome


def _run(
    command: list[str], case: Case, environment: Path, seconds: float, least: int, judged: bool
) -> Outcome:
    sheet, oracle = _judged(case.scene, case.size)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        job = {
            **sheet.as_job(),
            "settings": case.settings,
            "frames": FRAMES,
            "seconds": seconds,
            "foresee": False,
            "least": least,
            "environment": str(environment),
            "output": str(folder / "frames.f64"),
            "report": str(folder / "report.json"),
        }
        (folder / "job.json").write_text(json.dumps(job))
        error = call([*command, str(folder / "job.json")], folder, seconds + SPARE_TIME)
        if error is not None:
            return Outcome(case, [], seconds, error=error, machine=machine())
        cpu_ms = json.loads((folder / "report.json").read_text())["cpu_ms"]
        if not judged:
            return Outcome(case, cpu_ms, seconds, machine=machine())
        frames = np.fromfile(folder / "frames.f64", np.float64).reshape(-1, case.size**2, 3)
    touch = oracle.measure(frames)
    blew_up = None if touch.finite else "the cloth blew up"
    return Outcome(case, cpu_ms, seconds, touch, blew_up, machine())
