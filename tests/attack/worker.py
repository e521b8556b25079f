"""A process that judges the cases of one attack, in bounded memory and time."""

from __future__ import annotations

import multiprocessing
import os
import resource
import tempfile
import time
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random
from typing import Any

from tests.attack.catalogue import find
from tests.attack.frame import Case, Outcome

MEMORY = 6 << 30
"""Address space that a process may ask for [bytes]; threads reserve much more of it than they use."""
PATIENCE = 2.0
"""How long a process may take to end by itself [s]."""
LOOK = 0.5
"""How often the clock is looked at [s]."""
BUSY = 5
"""A case may take so many times its time where others keep the processors busy, or where it only waits."""
PRINTED = ("Traceback (most recent call last)", "panicked at", "was never retrieved", "was destroyed but")
"""What nobody should read in the output of a process."""


class Worker:
    """Starts the process when it is needed, and again when it has died."""

    def __init__(self, name: str, log: Path) -> None:
        """Prepare to judge cases of an attack; what its process prints goes to `log`."""
        self._name, self._attack, self._log = name, find(name), log
        self._process: Any = None
        self._pipe: Any = None
        self.resident = self.peak = 0
        """Memory of the process after the last case, and the most it ever had [bytes]."""

    def judge(self, seed: str | None = None, case: Case = None) -> Outcome:
        """What comes of a case, given or made from a seed."""
        if self._process is None:
            self._start()
        try:
            self._pipe.send((seed, case))
            if not self._answers():
                self.stop()
                return Outcome(f"took longer than {self._attack.seconds:g} s")
            outcome, self.resident, self.peak = self._pipe.recv()
        except (EOFError, ConnectionError):
            self._process.join(10)
            status = self._process.exitcode
            self.stop()
            return Outcome(f"the process died with status {status}: {tail(self._log)}")
        return outcome

    def _answers(self) -> bool:
        """Whether there is an answer in time: that of the processor, as others may be at work."""
        seconds = self._attack.seconds
        begin, start = processor_seconds(self._process.pid), time.monotonic()
        while not self._pipe.poll(LOOK):
            gone = time.monotonic() - start
            if gone > BUSY * seconds or (
                gone > seconds and processor_seconds(self._process.pid) - begin > seconds
            ):
                return False
        return True

    def stop(self) -> None:
        """End the process."""
        if self._process is not None:
            self._pipe.close()  # it ends when nobody asks any more
            self._process.join(PATIENCE)
            self._process.kill()
            self._process.join()
            self._process = None

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._log.parent.mkdir(parents=True, exist_ok=True)
        arguments = other, self._name, self._log
        self._process = context.Process(target=serve, args=arguments, daemon=True)
        self._process.start()
        other.close()


def processor_seconds(pid: int) -> float:
    """Processor time that a process has taken [s]; that of the clock where the system does not tell."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return time.monotonic()
    user, system = stat.rsplit(")", 1)[1].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def serve(pipe: Connection, name: str, log: Path) -> None:
    """Judge cases until nobody asks any more."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(output, 1)
    os.dup2(output, 2)
    with tempfile.TemporaryDirectory(prefix="taut-attack-") as folder:
        os.chdir(folder)
        attack = find(name)()
        while True:
            try:
                seed, case = pipe.recv()
            except EOFError:
                return
            before = os.path.getsize(log)
            try:
                outcome = attack.judge(attack.generate(Random(seed)) if seed is not None else case)
            except BaseException as error:
                place = traceback.extract_tb(error.__traceback__)[-1]
                text = f"{type(error).__name__}: {error} ({Path(place.filename).name}, {place.name})"
                outcome = Outcome(text[:2000])
            with log.open("rb") as printed:
                printed.seek(before)
                text = printed.read().decode(errors="replace")
            if not outcome.failure and any(word in text for word in PRINTED):
                outcome = Outcome(f"printed: {text.strip().splitlines()[-1][:500]}")
            pages = int(Path("/proc/self/statm").read_text().split()[1])
            peak = int(Path("/proc/self/status").read_text().partition("VmHWM:")[2].split()[0])
            pipe.send((outcome, pages * os.sysconf("SC_PAGE_SIZE"), 1024 * peak))


def tail(log: Path) -> str:
    """The last line that a process printed."""
    lines = log.read_text(errors="replace").strip().splitlines() if log.exists() else []
    return lines[-1][:500] if lines else "it printed nothing"
