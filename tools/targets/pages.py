"""Rows as text: the table in docs/targets.md, and the sections of docs/targets-detail.md.

Both pages are read before they are written, so that rows which are not measured again stay as they are.
Lines and sections are text, by the names of their rows.
"""

import re
from collections.abc import Iterable, Mapping

from tools.targets.table import Row

BEGIN, END = "<!-- targets: begin -->\n", "<!-- targets: end -->"
COLUMNS = ("target", "reached", "met", "threads", "spread", "measured with", "`make targets ROW=`")
HEAD = """# Targets in full

What stands in one line in [the table](targets.md), case by case; that line says what it was measured with.
`make targets` writes this page.

"""


def line(name: str, row: Row, measured_with: str) -> str:
    """A row as a line of the table."""
    met = "yes" if row.met else "**no**"
    return _joined((row.target, row.reached, met, row.threads, row.spread, measured_with, f"`{name}`"))


def section(name: str, row: Row) -> str:
    """What a row says in full; nothing where its line says it all."""
    return f"## {name}\n\n{row.target}\n\n{row.detail}" if row.detail else ""


def table(lines: Mapping[str, str]) -> str:
    """Lines under the names of the columns."""
    return "\n".join([_joined(COLUMNS), "|---" * len(COLUMNS) + "|", *lines.values()]) + "\n"


def lines_of(page: str) -> dict[str, str]:
    """The lines of the table on a page, by name.

    Raises:
        ValueError: The page has no table between its marks.
    """
    text = _split(page)[1]
    found = dict(re.findall(r"^(\|.*\| `([\w-]+)` \|)$", text, re.MULTILINE))
    found = {name: row for row, name in found.items()}
    if "| measured with |" not in text and (machine := re.search(r"^taut (.*)\.$", text, re.MULTILINE)):
        # A table of one engine named it once, below.
        for name, row in found.items():
            found[name] = row.removesuffix(f"`{name}` |") + f"{machine[1]} | `{name}` |"
    return found


def sections_of(page: str) -> dict[str, str]:
    """The sections of the page of details, by name."""
    parts = re.split(r"^(?=## )", page, flags=re.MULTILINE)[1:]
    return {part.split("\n", 1)[0].removeprefix("## "): part.rstrip("\n") + "\n" for part in parts}


def with_lines(page: str, renewed: Mapping[str, str], order: Iterable[str]) -> str:
    """The page of targets with some lines renewed; rows that never were measured are named below the table.

    Raises:
        ValueError: The page has no table between its marks.
    """
    head, _, rest = _split(page)
    lines = _renewed(lines_of(page), renewed, order := list(order))
    missing = ", ".join(f"`{name}`" for name in order if name not in lines)
    note = f"\nNot measured yet: {missing}.\n" if missing else ""
    return head + BEGIN + table(lines) + note + END + rest


def with_sections(page: str, renewed: Mapping[str, str], order: Iterable[str]) -> str:
    """The page of details with some sections renewed."""
    return HEAD + "\n".join(_renewed(sections_of(page), renewed, order).values())


def _renewed(old: Mapping[str, str], new: Mapping[str, str], order: Iterable[str]) -> dict[str, str]:
    """In the order of the rows, without names that no row has and without empty text."""
    both = {**old, **new}
    return {name: both[name] for name in order if both.get(name)}


def _split(page: str) -> tuple[str, str, str]:
    """What comes before the table, it, and what comes after."""
    head, begin, rest = page.partition(BEGIN)
    text, end, rest = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"docs/targets.md: the table must stand between {BEGIN.strip()} and {END}")
    return head, text, rest


def _joined(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"
