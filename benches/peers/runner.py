"""Runs one case: writes the job, starts the engine's adapter, measures the frames."""

import json
import os
import platform
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from metric import measure
from sheet import FRAMES, Sheet
from store import WARM_UP, Case, Record

ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
SPARE_TIME = 300.0
"""Wall-clock time [s] that an adapter may take beyond four times its CPU time, mostly to start."""


def machine() -> str:
    """What the times are measured on."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    name = names[0] if names else platform.processor() or platform.machine()
    return f"{name}, {os.cpu_count()} cores, {platform.system()}"


def run(command: list[str], case: Case, environment: Path, seconds: float) -> Record:
    """Run a case to its end, or as far as it is worth it.

    Args:
        command: runs the engine's adapter.
        case: what to run.
        environment: the engine's environment.
        seconds: CPU time the frames may take [s]; a run that will not do with it is given up.

    Returns:
        The result, also of a failure.
    """
    return _run(command, case, environment, seconds, foresee=True)


def retime(command: list[str], case: Case, environment: Path, seconds: float) -> Record:
    """Time the first frames of a case again, for about this long [s]; the record has nothing but times."""
    record = _run(command, case, environment, seconds, foresee=False)
    if record.error is not None or len(record.cpu_ms) <= WARM_UP:
        raise RuntimeError(f"{case.key}: could not be timed again ({record.error or 'too few frames'})")
    return Record(case, record.cpu_ms, record.complete, seconds, record.start_seconds, machine=record.machine)


def _run(command: list[str], case: Case, environment: Path, seconds: float, foresee: bool) -> Record:
    sheet = Sheet(case.scene, case.size)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        job = {
            **sheet.as_job(),
            "settings": case.settings,
            "frames": FRAMES,
            "seconds": seconds,
            "foresee": foresee,
            "environment": str(environment),
            "output": str(folder / "frames.f32"),
            "report": str(folder / "report.json"),
        }
        (folder / "job.json").write_text(json.dumps(job))
        error = call([*command, str(folder / "job.json")], folder, 4 * seconds + SPARE_TIME)
        if error is not None:
            return Record(case, [], False, seconds, error=error, machine=machine())
        report = json.loads((folder / "report.json").read_text())
        frames = np.fromfile(folder / "frames.f32", np.float32).reshape(-1, case.size**2, 3)
    measured = measure(sheet, frames)
    blew_up = measured.worst_everywhere is None or float(np.abs(frames[-1]).max()) > 1e3
    return Record(
        case,
        cpu_ms=report["cpu_ms"],
        complete=len(frames) == FRAMES and not blew_up,
        seconds=seconds,
        start_seconds=report["start_seconds"],
        measured=measured,
        error="the cloth blew up" if blew_up else None,
        machine=machine(),
    )


def call(command: list[str], folder: Path, patience: float) -> str | None:
    """Run a command in a folder; return its last words if it failed."""
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env={**os.environ, **ONE_THREAD},
            capture_output=True,
            text=True,
            timeout=patience,
        )
    except subprocess.TimeoutExpired:
        return f"no end after {patience:.0f} s"
    if done.returncode == 0:
        return None
    lines = (done.stderr or done.stdout).strip().splitlines() or [f"exit status {done.returncode}"]
    return lines[-1][:300]
