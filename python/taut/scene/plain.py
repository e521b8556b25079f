"""Turns what people put into a scene (NumPy, tuples, TOML values) into plain JSON values."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from taut.errors import SceneError

DEEPEST = 64
"""Levels of nesting that a scene may have; the deepest field lies at 7."""

_LONGEST = 60
"""Longer quotations of what a user wrote are cut [characters]."""

_MOST_DIGITS = 308
"""Whole numbers with more digits have no place in a double."""


def plain(value: Any, field: str = "scene", depth: int = 0) -> Any:
    """Return `value` as dicts, lists, strings, booleans and finite numbers.

    Args:
        value: a mapping, sequence, NumPy array or scalar, string, boolean or number.
        field: where it stands, for errors.
        depth: levels above it.

    Raises:
        SceneError: a number is not finite, or a value has no place in a scene; the field is named.
    """
    if depth > DEEPEST:
        raise SceneError(f"{field}: nested more than {DEEPEST} levels deep; no field of a scene is")
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {
            _key(key, field): plain(item, f"{field}.{_shown(key)}", depth + 1) for key, item in value.items()
        }
    if isinstance(value, list | tuple):
        return [plain(item, f"{field}[{index}]", depth + 1) for index, item in enumerate(value)]
    if isinstance(value, str):
        return _text(value, field)
    if isinstance(value, int):
        if abs(value) >= 10**_MOST_DIGITS:
            raise SceneError(
                f"{field}: is a whole number of more than {_MOST_DIGITS} digits; no field takes one"
            )
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            raise SceneError(f"{field} = {value}: must be a finite number")
        return value
    kind = type(value).__name__
    raise SceneError(
        f"{field} = {shorten(repr(value))}: is a {kind}; "
        "must be a number, text, true, false, a list or a table"
    )


def shorten(text: str, longest: int = _LONGEST) -> str:
    """What a user wrote, cut where it would fill the screen, after `longest` characters."""
    return text if len(text) <= longest else f"{text[:longest]}..."


def _shown(key: object) -> str:
    """A field name for errors."""
    text = str(key)
    return shorten(text if text.isprintable() and text else ascii(text))


def _key(key: object, field: str) -> str:
    if not isinstance(key, str):
        kind = type(key).__name__
        raise SceneError(f"{field}: the field name {shorten(repr(key))} is a {kind}; must be text")
    return _text(key, f"{field}: a field name")


def _text(text: str, field: str) -> str:
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise SceneError(
            f"{field} = {shorten(ascii(text))}: character {error.start} is half of a surrogate pair, "
            "which is no text; leave it out"
        ) from None
    return text
