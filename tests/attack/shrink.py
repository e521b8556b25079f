"""A failing case is made smaller as long as it fails."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from tests.attack.frame import Case


def shrink(case: Case, fails: Callable[[Case], bool], seconds: float) -> Case:
    """The smallest case found within a time that still fails in the same way.

    Args:
        case: fails.
        fails: whether a case fails in that way.
        seconds: how long to look [s].
    """
    end = time.monotonic() + seconds
    tried = {repr(case)}
    while True:
        for smaller in variants(case):
            if time.monotonic() > end:
                return case
            if (text := repr(smaller)) not in tried:
                tried.add(text)
                if fails(smaller):
                    case = smaller
                    break
        else:
            return case


def variants(value: Case) -> Iterator[Case]:
    """Values that are a little smaller, those that lose most first."""
    match value:
        case dict():
            yield from ({key: kept for key, kept in value.items() if key != gone} for gone in value)
            for key, item in value.items():
                yield from ({**value, key: smaller} for smaller in variants(item))
        case list() | tuple() | str() | bytes():
            yield from _shorter(value)
            if isinstance(value, list | tuple):
                for index, item in enumerate(value):
                    for smaller in variants(item):
                        yield type(value)([*value[:index], smaller, *value[index + 1 :]])
        case bool() | None:
            return
        case int():
            yield from (smaller for smaller in (0, 1, value // 2) if abs(smaller) < abs(value))
        case float():
            simple = (0.0, 1.0, float(round(value, 0)) if abs(value) < 1e9 else 1e9, float(f"{value:.2g}"))
            yield from (smaller for smaller in simple if len(repr(smaller)) < len(repr(value)))


def _shorter(value: Case) -> Iterator[Case]:
    part = len(value)
    while part > 0:
        for start in range(0, len(value), part):
            yield value[:start] + value[start + part :]
        part //= 2
