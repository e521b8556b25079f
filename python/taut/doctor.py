"""What this machine has for taut, and what to do about what it lacks."""

import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from taut import _taut

LEAST_SPACE = 2e9
"""Free disk space below which a remedy is named [bytes]; 600 frames of 256 x 256 vertices take up to 1 GB."""

_REGISTERS = {16: "AVX-512", 8: "AVX2", 4: "NEON"}


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at."""

    name: str
    """What."""
    text: str
    """What was found."""
    remedy: str = ""
    """What to do about it; empty where all is well."""

    @property
    def fine(self) -> bool:
        """Whether nothing needs doing."""
        return not self.remedy


def examine(folder: Path) -> list[Finding]:
    """Look at everything; takes a few seconds.

    Args:
        folder: where caches and films would be written.
    """
    looks: list[Callable[[], Finding]] = [
        versions,
        processor,
        vector_registers,
        speed,
        rendering,
        film_encoder,
        lambda: disk(folder),
    ]
    return [look() for look in looks]


def versions() -> Finding:
    """Versions of taut, Python and the system."""
    system = f"{platform.system()} {platform.release()} {platform.machine()}"
    return Finding("taut", f"{_taut.__version__}, Python {platform.python_version()}, {system}")


def processor() -> Finding:
    """The processor, and how many threads a run takes by default."""
    from taut.bench import this_machine

    machine = this_machine()
    all_cores = os.cpu_count() or machine.cores
    share = "" if machine.cores == all_cores else f" (of {all_cores}: this process may not use the others)"
    return Finding("processor", f"{machine.processor}, {machine.cores} threads{share}")


def vector_registers() -> Finding:
    """The vector registers that the engine uses."""
    lanes = _taut.simd_lanes()
    if lanes > 1:
        return Finding("vector registers", f"{_REGISTERS.get(lanes, 'yes')}: {lanes} numbers at once")
    remedy = "the engine works, one number at a time; a processor with AVX2 or NEON is faster"
    return Finding("vector registers", "none that the engine knows", remedy)


def speed() -> Finding:
    """How fast the shipped flag runs on all threads, after a few frames."""
    from taut.scene import Scene
    from taut.simulation import Simulation

    simulation = Simulation(Scene.load("flag"))
    simulation.run(frames=5)
    frames = 15
    start = time.perf_counter()
    simulation.run(frames=frames)
    per_frame = (time.perf_counter() - start) / frames
    real_time = 1 / simulation.scene.fps / per_frame
    size = f"{len(simulation.positions)} vertices"
    return Finding(
        "speed", f"the flag ({size}) takes {1e3 * per_frame:.1f} ms a frame, {real_time:.2g} x real time"
    )


def rendering() -> Finding:
    """Whether pictures can be made, and by which device."""
    name = "pictures"
    display = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    shown = "" if display or sys.platform in ("darwin", "win32") else "; no display, none is needed"
    command = [sys.executable, "-m", "taut.render.probe"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        return Finding(name, "the renderer did not answer within two minutes", _OPENGL)
    if done.returncode == 0:
        return Finding(name, done.stdout.strip().splitlines()[-1] + shown)
    words = done.stderr.strip().splitlines() or ["no message"]
    return Finding(name, f"cannot be rendered: {words[-1]} (status {done.returncode})", _OPENGL)


_OPENGL = (
    "OpenGL in software will do: on Debian and Ubuntu `apt install libegl1 libgl1-mesa-dri`, "
    "on Fedora `dnf install mesa-libEGL mesa-dri-drivers`; simulating works without"
)


def film_encoder() -> Finding:
    """Whether films can be written, and by what."""
    import imageio_ffmpeg  # type: ignore[import-untyped]

    name = "films"
    remedy = (
        "`pip install --force-reinstall imageio-ffmpeg` brings an encoder, or let IMAGEIO_FFMPEG_EXE name "
        "an ffmpeg with libx264; stills work without"
    )
    try:
        encoder = imageio_ffmpeg.get_ffmpeg_exe()
        known = subprocess.run([encoder, "-hide_banner", "-encoders"], capture_output=True, text=True)
    except (RuntimeError, OSError) as error:
        return Finding(name, f"there is no ffmpeg that runs: {str(error).splitlines()[0]}", remedy)
    if "libx264" not in known.stdout:
        return Finding(name, f"{encoder} has no encoder for H.264 (libx264)", remedy)
    return Finding(name, f"H.264 by ffmpeg {imageio_ffmpeg.get_ffmpeg_version()}")


def disk(folder: Path) -> Finding:
    """Free space in a folder, and whether it can be written to."""
    name, free = "disk", shutil.disk_usage(folder).free
    text = f"{free / 1e9:.1f} GB free in {folder}"
    if not os.access(folder, os.W_OK):
        return Finding(
            name,
            f"{folder} cannot be written to",
            "run taut in a folder of yours, or give --out a path there",
        )
    if free < LEAST_SPACE:
        remedy = "make room, or write elsewhere with --out; a cache takes up to 24 bytes a vertex and frame"
        return Finding(name, text, remedy)
    return Finding(name, text)
