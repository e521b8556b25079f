"""Results of runs with contact, as lines of JSON: a command that was interrupted goes on where it was."""

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from contact.oracle import Touch
from store import WARM_UP, Case


@dataclass(frozen=True)
class Outcome:
    """A run of a case, or one that only timed its first frames again."""

    case: Case
    cpu_ms: list[float]
    """CPU time of each frame [ms], all threads of the process."""
    seconds: float
    """CPU time after which it was ended [s]."""
    touch: Touch | None = None
    """What the oracle saw; None if it was only timed, or made no frame."""
    error: str | None = None
    """Why it failed, if it did."""
    machine: str = ""
    """What it ran on."""

    @property
    def cost(self) -> float:
        """CPU time of a frame [ms], mean over all frames after the warm-up."""
        return self.cost_until(len(self.cpu_ms))

    def cost_until(self, frames: int) -> float:
        """The same over the first frames only."""
        counted = self.cpu_ms[WARM_UP:frames] or self.cpu_ms[:frames]
        return sum(counted) / max(1, len(counted))


class Results:
    """The file of results."""

    def __init__(self, path: Path) -> None:
        """Read what is there; the newest run of a case counts, with the timings after it."""
        self._path = path
        self._runs: dict[str, Outcome] = {}
        self._timings: dict[str, list[Outcome]] = {}
        self.machine = ""
        """What the newest result was measured on."""
        self.missing: dict[str, str] = {}
        """Engines that could not be installed when it was last tried, and why: one sentence."""
        text = path.read_text() if path.exists() else ""
        for line in text.splitlines():
            # A line that was cut off when the command was killed is no result.
            with suppress(json.JSONDecodeError):
                self._read(json.loads(line))
        if text and not text.endswith("\n"):
            path.write_text(text + "\n")

    def add(self, outcome: Outcome) -> None:
        """Append a result."""
        self._write(asdict(outcome))
        self._take(outcome)

    def miss(self, engine: str, reason: str) -> None:
        """Append that an engine cannot be installed."""
        self._write({"missing": engine, "reason": reason})
        self.missing[engine] = reason

    def found(self, engine: str) -> None:
        """Append that it can be installed now, if that was not so before."""
        if self.missing.pop(engine, None) is not None:
            self._write({"missing": engine, "reason": None})

    def _write(self, fields: dict[str, Any]) -> None:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a") as file:
            file.write(json.dumps(fields) + "\n")

    def _read(self, fields: dict[str, Any]) -> None:
        if "missing" not in fields:
            self._take(_outcome(fields))
        elif fields["reason"] is None:
            self.missing.pop(fields["missing"], None)
        else:
            self.missing[fields["missing"]] = fields["reason"]

    def _take(self, outcome: Outcome) -> None:
        key = outcome.case.key
        self.machine = outcome.machine or self.machine
        if outcome.touch is None and outcome.error is None:
            self._timings.setdefault(key, []).append(outcome)
        else:
            self._runs.pop(key, None)
            self._runs[key] = outcome
            self._timings.pop(key, None)

    def get(self, case: Case) -> Outcome | None:
        """The newest run of a case."""
        return self._runs.get(case.key)

    def newest(self, engine: str, scene: str, size: int) -> Outcome | None:
        """The run of an engine in a scene that was added last, whatever its version."""
        found = None
        for outcome in self._runs.values():
            case = outcome.case
            if (case.engine, case.scene, case.size) == (engine, scene, size):
                found = outcome
        return found

    def of(self, engine: str, version: str) -> Iterator[Outcome]:
        """All runs of an engine's version."""
        for outcome in self._runs.values():
            if (outcome.case.engine, outcome.case.version) == (engine, version):
                yield outcome

    def costs(self, case: Case, frames: int | None = None) -> list[float]:
        """CPU time of a frame [ms] in the run of a case and in each timing after it.

        Args:
            case: what was run.
            frames: how many of the first frames count; None: all.

        Returns:
            A mean for each. A timing that made fewer frames is compared with the same frames of the run.
        """
        run = self._runs[case.key]
        cost = run.cost_until(len(run.cpu_ms) if frames is None else frames)
        timings = self._timings.get(case.key, [])
        return [cost, *(cost * _ratio(run, timing) for timing in timings)]


def _ratio(run: Outcome, timing: Outcome) -> float:
    """How much dearer the same frames were in a timing."""
    both = min(len(run.cpu_ms), len(timing.cpu_ms))
    before = run.cost_until(both)
    return timing.cost_until(both) / before if before > 0 else 1.0


def _outcome(fields: dict[str, Any]) -> Outcome:
    fields["case"] = Case(**fields["case"])
    if fields["touch"] is not None:
        fields["touch"] = Touch(**fields["touch"])
    return Outcome(**fields)
