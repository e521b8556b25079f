"""The settings that a page like docs/peers.md lists: to run those again, elsewhere, without a search."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from search import Family, Settings, words


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


def _rows(lines: Iterable[str]) -> Iterator[dict[str, str]]:
    """Rows of all tables by the titles of their columns."""
    titles: list[str] = []
    for line in lines:
        cells = line.strip("| ").split(" | ")
        if not line.startswith("|"):
            titles = []
        elif not titles:
            titles = cells
        else:
            yield dict(zip(titles, cells, strict=False))


def _member(family: Family, text: str) -> Settings | None:
    """The setting of a family that reads so."""
    efforts = [part.removeprefix(f"{family.effort} ") for part in text.split(", ")]
    settings = [family.at(int(effort)) for effort in efforts if effort.isdecimal()]
    return next((setting for setting in settings if words(setting) == text), None)
