"""What a page like docs/peers.md lists: settings to be run again without a search, and figures to be kept."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from search import Family, Settings, words

Row = dict[str, str]
"""A row of a table by the titles of its columns."""


class Earlier:
    """What a page says already: it is kept where there are no results of an engine."""

    def __init__(self, page: str) -> None:
        """Read it."""
        self._rows = list(_rows(page.splitlines()))
        self.kept: dict[str, set[str]] = {}
        """What was asked for and found: sizes by engine."""

    def cell(self, title: str, column: str) -> str | None:
        """The cell of an engine in an overview; None if there is none, or nothing in it."""
        for row in self._rows:
            if next(iter(row.values())) == title and row.get(column, "not run") != "not run":
                self.kept.setdefault(title, set()).update(
                    part for part in column.split(", ") if part.endswith("²")
                )
                return row[column]
        return None

    def details(self, columns: Sequence[str], title: str) -> list[Row]:
        """The rows of an engine in the table with these columns."""
        return [row for row in self._rows if list(row) == list(columns) and row["engine"] == title]

    def words(self) -> list[str]:
        """What was kept, as a sentence; none if that is nothing."""
        engines = [
            f"{title} ({', '.join(sorted(sizes, key=lambda size: int(size[:-1])))})"
            for title, sizes in self.kept.items()
        ]
        return [f"Kept from an earlier run: {'; '.join(engines)}."] if engines else []


class Listed:
    """The settings in a page's tables."""

    def __init__(self, page: Path) -> None:
        """Read them."""
        self._rows = list(_rows(page.read_text(encoding="utf-8").splitlines()))

    def free(self, title: str, size: int, families: Iterable[Family]) -> list[Settings]:
        """Settings of an engine without contact.

        Args:
            title: the engine's.
            size: particles along an edge.
            families: the engine's; what is in none of them is left out.

        Returns:
            Each once, as the search would have made it.
        """
        texts = self._texts("cheapest setting", engine=title, size=f"{size}²")
        found = [setting for text in texts for family in families if (setting := _member(family, text))]
        return [setting for index, setting in enumerate(found) if setting not in found[:index]]

    def contact(self, title: str, scene: str, size: int, tried: Iterable[Settings]) -> list[Settings]:
        """Those of the settings that are listed for an engine in a scene with contact."""
        texts = self._texts("setting", engine=title, scene=scene, size=f"{size}²")
        return [settings for settings in tried if words(settings) in texts]

    def _texts(self, column: str, **wanted: str) -> list[str]:
        return [row[column] for row in self._rows if column in row and wanted.items() <= row.items()]


def _rows(lines: Iterable[str]) -> Iterator[Row]:
    """Rows of all tables by the titles of their columns."""
    titles: list[str] = []
    for line in lines:
        cells = line.strip("| ").split(" | ")
        if not line.startswith("|"):
            titles = []
        elif not titles:
            titles = cells
        elif not set(line) <= set("|- "):
            yield dict(zip(titles, cells, strict=False))


def _member(family: Family, text: str) -> Settings | None:
    """The setting of a family that reads so."""
    efforts = [part.removeprefix(f"{family.effort} ") for part in text.split(", ")]
    settings = [family.at(int(effort)) for effort in efforts if effort.isdecimal()]
    return next((setting for setting in settings if words(setting) == text), None)
