"""What a benchmark ran on: never the name of the host."""

import os
import platform
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from taut import _taut


@dataclass(frozen=True, slots=True)
class Machine:
    """A processor, and the version of taut on it."""

    processor: str
    """Model of the processor."""
    cores: int
    """Cores that this process may use [1]."""
    system: str
    """Operating system and architecture."""
    version: str
    """Version of taut."""
    revision: str
    """Git revision of the current folder, `+` if files differ from it; empty outside a repository."""

    @property
    def name(self) -> str:
        """Names the machine in file names: processor and cores."""
        words = re.sub(r"\((r|tm)\)", "", f"{self.processor} {self.cores} cores", flags=re.IGNORECASE)
        return re.sub(r"[^a-z0-9]+", "-", words.lower()).strip("-")

    def __str__(self) -> str:
        """For people."""
        return f"{self.cores} cores of {self.processor}, {self.system}"


def this_machine() -> Machine:
    """Describe the machine that this runs on."""
    affinity = getattr(os, "sched_getaffinity", None)
    cores = len(affinity(0)) if affinity else os.cpu_count() or 1
    system = f"{platform.system()} {platform.machine()}"
    return Machine(_processor(), cores, system, _taut.__version__, _revision())


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    if platform.system() == "Darwin":
        return _output("sysctl", "-n", "machdep.cpu.brand_string") or platform.machine()
    return platform.processor() or platform.machine()


def _revision() -> str:
    revision = _output("git", "rev-parse", "--short", "HEAD")
    changed = bool(revision) and bool(_output("git", "status", "--porcelain", "--untracked-files=no"))
    return revision + ("+" if changed else "")


def _output(*command: str) -> str:
    """What a command prints; nothing if it fails or is not there."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip()
