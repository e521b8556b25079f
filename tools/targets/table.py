"""Rows of the table of targets, and the table in the documents."""

from dataclasses import dataclass
from pathlib import Path

from taut.bench import Window, this_machine

ROOT = Path(__file__).resolve().parent.parent.parent
BEGIN, END = "<!-- targets: begin -->\n", "<!-- targets: end -->"


@dataclass(frozen=True, slots=True)
class Row:
    """A target and what was reached."""

    target: str
    """What was asked for."""
    reached: str
    """What was measured, with where."""
    met: bool
    """Whether all that was measured meets the target."""


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is measured."""

    divide: int = 1
    """Cells along a side are divided by this [1]."""
    frames: int = 300
    """Frames that are timed, 5 s of them [1]."""
    seconds: float = 25.0
    """No frame is begun after this much time in one measurement [s]."""
    steps: float = 1.0
    """Steps of each case of the bound are multiplied by this [1]."""

    def cells(self, cells: int) -> int:
        """Cells along a side [1]."""
        return max(1, cells // self.divide)

    @property
    def window(self) -> Window:
        """What is timed where nothing else limits it."""
        return Window(self.frames, self.seconds, repeats=3)


FULL = Effort()
QUICK = Effort(divide=16, frames=5, seconds=1.0, steps=0.05)


def markdown(rows: dict[str, Row], disturbed: bool) -> str:
    """The table, and what it was measured on."""
    lines = ["| target | reached | met | `make targets ROW=` |", "|---|---|---|---|"]
    for name, row in rows.items():
        lines.append(f"| {row.target} | {row.reached} | {'yes' if row.met else '**no**'} | `{name}` |")
    machine = this_machine()
    note = " The machine was busy with something else: times are too long." if disturbed else ""
    return "\n".join([*lines, "", f"taut {machine.version} {machine.revision} on {machine}.{note}"]) + "\n"


def write(table: str) -> None:
    """Replaces the table in the documents."""
    for document in (ROOT / "README.md", ROOT / "docs" / "targets.md"):
        head, rest = document.read_text().split(BEGIN)
        document.write_text(head + BEGIN + table + END + rest.split(END)[1])
