"""What the adapters of Python engines share: read the job, step, time, write frames.

An adapter runs in its engine's own environment, which has NumPy beside the engine, and nothing else:

    python some_adapter.py JOB.json

The job names the cloth (``positions`` [m], ``masses`` [kg], ``pins``, ``edges``, ``triangles``), the
engine's ``settings``, how many ``frames`` of 1/60 s to make, the CPU ``seconds`` they may take, whether to
stop at once if they will not suffice (``foresee``), the ``environment`` folder, and two files to write:
``output`` gets the positions as float32, frame after frame, ``report`` the CPU time of each frame and of the
start.

A job with contact also names ``bodies`` (as ``contact/scenes.py`` writes them), the ``thickness`` [m] and the
``friction`` [1] of the cloth, the other ``diagonals`` of its quads, and its ``grid``: where the sheet starts,
how it is turned and moved. It makes ``least`` frames even if its time is used up before, and its positions
are written as float64.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

FPS = 60
GRAVITY = 9.81
FORESIGHT = 5
"""Frames after which the rest can be foreseen; retiming makes a few more than these."""
FAR = 1e3
"""A particle this far away [m] will not come back."""


class Job:
    """What to simulate."""

    def __init__(self, path: Path) -> None:
        """Read it from a file."""
        fields: dict[str, Any] = json.loads(path.read_text())
        self.positions = np.array(fields["positions"], np.float64)
        self.masses = np.array(fields["masses"], np.float64)
        self.pins: list[int] = fields["pins"]
        self.edges = np.array(fields["edges"], np.int64)
        self.triangles = np.array(fields["triangles"], np.int64)
        self.settings: dict[str, Any] = fields["settings"]
        self.frames: int = fields["frames"]
        self.seconds: float = fields["seconds"]
        self.foresee: bool = fields["foresee"]
        self.environment = Path(fields["environment"])
        self.output, self.report = Path(fields["output"]), Path(fields["report"])
        self.bodies: list[dict[str, Any]] = fields.get("bodies", [])
        self.thickness: float = fields.get("thickness", 0.0)
        self.friction: float = fields.get("friction", 0.0)
        self.diagonals = np.array(fields.get("diagonals", []), np.int64).reshape(-1, 2)
        self.grid: dict[str, list[float]] = fields.get("grid", {})
        self.least: int = fields.get("least", 2 * FORESIGHT)
        self.real: type[np.floating[Any]] = np.float64 if "bodies" in fields else np.float32


class Cloth(Protocol):
    """A cloth in an engine."""

    def frame(self) -> None:
        """Advance by 1/60 s."""

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3), in the job's order, z up."""


def serve(build: Callable[[Job], Cloth]) -> None:
    """Do the job that the command line names with the cloth that ``build`` makes."""
    job = Job(Path(sys.argv[1]))
    cloth = build(job)
    started = time.process_time()
    spent: list[float] = []
    with job.output.open("wb") as output:
        while len(spent) < job.frames:
            before = time.process_time()
            cloth.frame()
            spent.append(time.process_time() - before)
            frame = np.asarray(cloth.positions(), job.real)
            output.write(np.ascontiguousarray(frame).tobytes())
            if not np.isfinite(frame).all() or np.abs(frame).max() > FAR or _enough(job, spent):
                break
    times = [round(1e3 * seconds, 4) for seconds in spent]
    job.report.write_text(json.dumps({"start_seconds": round(started, 3), "cpu_ms": times}))


def _enough(job: Job, spent: list[float]) -> bool:
    """Whether the job's time is used up, or (if asked to foresee it) will not suffice."""
    if len(spent) < FORESIGHT:
        return False
    if job.foresee:
        return sum(spent[1:]) / (len(spent) - 1) * job.frames > job.seconds
    return sum(spent[1:]) > job.seconds and len(spent) >= job.least
