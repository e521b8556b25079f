"""A section of the page: a figure of the paper, its claim, and what was measured."""

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["holds", "holds in part", "does not hold"]


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture in the folder `pictures`."""

    name: str
    """File name."""
    caption: str
    """What is seen, for those who do not see it, too."""
    dark: str | None = None
    """File name of the same for dark pages, where there is one."""
    wide: bool = False
    """Whether it is a strip, to be scrolled sideways on a narrow page."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A line of the table: what was measured, one text for each column."""

    what: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Section:
    """A figure of the paper."""

    number: str
    """As in "Fig. 5"."""
    title: str
    claim: str
    """What the paper says about it, in our words."""
    setting: str
    """What we have simulated."""
    verdict: Verdict
    reading: str
    """What the figures say about the claim."""
    columns: tuple[str, ...]
    """Of the table."""
    findings: tuple[Finding, ...]
    pictures: tuple[Picture, ...]
    numbers: dict[str, float | None]
    """The same figures for programs; names end in their unit where they have one."""
