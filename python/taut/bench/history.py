"""What was measured before on a machine: one CSV file a machine, a line a row."""

import csv
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path

from taut.bench.machine import Machine
from taut.bench.measure import COLUMNS, Row

HISTORY = Path("benches") / "history"
"""Where the project keeps its history, from the root of the repository."""

_SAME = ("scene", "cells", "strain_limit", "threads", "frames")
"""Columns in which two rows must agree to be compared."""
_HEAD = ("date", "version", "revision", "processor", "cores", "system")


@dataclass(frozen=True, slots=True)
class History:
    """A CSV file of rows."""

    path: Path
    """The file; it need not be there yet."""

    @classmethod
    def of(cls, machine: Machine, folder: Path) -> "History":
        """The history of a machine in a folder."""
        return cls(folder / f"{machine.name}.csv")

    def append(self, row: Row, machine: Machine, at: datetime) -> None:
        """Add a row.

        Args:
            row: what was measured.
            machine: where.
            at: when, in universal time.

        Raises:
            OSError: the file cannot be written.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        new = not self.path.exists()
        head = [
            at.strftime("%Y-%m-%dT%H:%M:%SZ"),
            *(machine.version, machine.revision, machine.processor, machine.cores, machine.system),
        ]
        numbers = [f"{x:.6g}" if isinstance(x, float) else x for x in asdict(row).values()]
        with self.path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            if new:
                writer.writerow([*_HEAD, *COLUMNS])
            writer.writerow([*head, *numbers])

    def last_ratio(self, row: Row) -> float | None:
        """The ratio that was last measured for such a row; nothing if none was.

        Raises:
            OSError: the file is there and cannot be read.
        """
        if not self.path.exists():
            return None
        same = {name: f"{x:.6g}" if isinstance(x := getattr(row, name), float) else str(x) for name in _SAME}
        with self.path.open(newline="", encoding="utf-8") as file:
            found = [line for line in csv.DictReader(file) if all(line.get(n) == x for n, x in same.items())]
        return float(found[-1]["ratio"]) if found else None
