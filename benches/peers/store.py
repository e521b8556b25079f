"""Results as lines of JSON, so that a search that was interrupted goes on where it was."""

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from metric import Measured
from search import Settings

WARM_UP = 5
"""First frames whose time does not count: they compile and fill caches."""


@dataclass(frozen=True)
class Case:
    """What a result belongs to."""

    engine: str
    version: str
    settings: Settings
    scene: str
    size: int

    @property
    def key(self) -> str:
        """The same for equal cases."""
        return json.dumps(asdict(self), sort_keys=True)


@dataclass(frozen=True)
class Record:
    """A run of a case, or a shorter one that only timed it anew."""

    case: Case
    cpu_ms: list[float]
    """CPU time of each frame [ms], all threads of the process."""
    complete: bool
    """Whether it reached the last frame."""
    seconds: float
    """CPU time it was allowed [s]."""
    start_seconds: float | None = None
    """CPU time until the first frame began [s]."""
    measured: Measured | None = None
    """None if it only timed a case, or failed."""
    error: str | None = None
    """Why it failed, if it did: the engine's last words, or that it blew up."""
    machine: str = ""
    """What it ran on."""
    retimed: list[float] = field(default_factory=list)
    """CPU time of the first frames, measured later [ms]; not in the file."""

    @property
    def cpu_seconds(self) -> float:
        """CPU time it took, as far as it is known [s]."""
        return (self.start_seconds or 0.0) + sum(self.cpu_ms) / 1e3

    @property
    def cost(self) -> float:
        """CPU time of a frame [ms], mean over all frames after the warm-up.

        Where it was timed anew, the same frames of both are compared, so that a shorter run will do.
        """
        old, new = self.cpu_ms[WARM_UP:], self.retimed[WARM_UP : len(self.cpu_ms)]
        mean = sum(old) / len(old) if old else sum(self.cpu_ms) / max(1, len(self.cpu_ms))
        share = sum(new) / sum(old[: len(new)]) if old and new else 1.0
        return mean * share


class Store:
    """The file of results."""

    def __init__(self, path: Path) -> None:
        """Read what is there; the newest line of a case is the one that counts."""
        self._path = path
        self._runs: dict[str, Record] = {}
        self._timings: dict[str, Record] = {}
        self._machine = ""
        text = path.read_text() if path.exists() else ""
        for line in text.splitlines():
            # A line that was cut off when the command was killed is no result.
            with suppress(json.JSONDecodeError):
                self._take(_from_json(line))
        if text and not text.endswith("\n"):
            path.write_text(text + "\n")

    def _take(self, record: Record) -> None:
        key = record.case.key
        self._machine = record.machine
        if record.measured is None and record.error is None:
            self._timings[key] = record
        else:
            self._runs.pop(key, None)
            self._runs[key] = record
            self._timings.pop(key, None)

    def add(self, record: Record) -> None:
        """Append a record."""
        fields = asdict(record)
        del fields["retimed"]
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a") as file:
            file.write(json.dumps(fields) + "\n")
        self._take(record)

    def run_of(self, case: Case) -> Record | None:
        """The run of a case with its own times."""
        return self._runs.get(case.key)

    def get(self, case: Case) -> Record | None:
        """The run of a case with its newest times."""
        run, timing = self._runs.get(case.key), self._timings.get(case.key)
        return run if run is None or timing is None else replace(run, retimed=timing.cpu_ms)

    def of(self, engine: str, version: str, size: int) -> Iterator[Record]:
        """All runs of an engine's version at a size, with their own times."""
        for record in self._runs.values():
            case = record.case
            if (case.engine, case.version, case.size) == (engine, version, size):
                yield record

    def sizes(self, engine: str, version: str) -> list[int]:
        """Sizes that an engine's version was run at, ascending."""
        cases = [record.case for record in self._runs.values()]
        return sorted({case.size for case in cases if (case.engine, case.version) == (engine, version)})

    @property
    def machine(self) -> str:
        """What the newest result was measured on."""
        return self._machine

    def newest(self, engine: str, scene: str, size: int) -> Record | None:
        """The run of an engine in a scene that was added last, whatever its version."""
        found = None
        for record in self._runs.values():
            case = record.case
            if (case.engine, case.scene, case.size) == (engine, scene, size):
                found = record
        return found


def _from_json(line: str) -> Record:
    fields = json.loads(line)
    fields["case"] = Case(**fields["case"])
    if fields["measured"] is not None:
        fields["measured"] = Measured(**fields["measured"])
    return Record(**fields)
