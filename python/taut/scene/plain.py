"""Turns what people put into a scene (NumPy, tuples, TOML values) into plain JSON values."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from taut.errors import SceneError

DEEPEST = 64
"""Levels of nesting that a scene may have; the deepest field lies at 7."""


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
        return {_key(key, field): plain(item, f"{field}.{key}", depth + 1) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, f"{field}[{index}]", depth + 1) for index, item in enumerate(value)]
    if isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            raise SceneError(f"{field} = {value}: must be a finite number")
        return value
    kind = type(value).__name__
    raise SceneError(
        f"{field} = {value!r}: is a {kind}; must be a number, text, true, false, a list or a table"
    )


def _key(key: object, field: str) -> str:
    if not isinstance(key, str):
        raise SceneError(f"{field}: the field name {key!r} is a {type(key).__name__}; must be text")
    return key
