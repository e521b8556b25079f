"""``--set solver.filter=none``: single values changed in a scene's document."""

import re
import tomllib
from typing import Any

from taut.errors import SceneError

_PART = re.compile(r'(?P<dot>\.?)(?:(?P<bare>[A-Za-z0-9_-]+)|"(?P<quoted>[^"]*)")|\[(?P<index>\d{1,9})\]')
_WORD = re.compile(r"[A-Za-z_./][^\n]*")


def apply_setting(document: dict[str, Any], setting: str) -> None:
    """Change one value of `document`, in place.

    Args:
        document: a scene, resolved or not.
        setting: ``path=value``. A path is field names joined by dots; an element of a list is chosen
            by number, ``cloth[0]``, or, where the elements have names, by name, ``cloth.flag``. The
            value is written as in TOML; a bare word is text.

    Raises:
        SceneError: the path or the value cannot be read, or the path leads nowhere.
    """
    path, equals, text = setting.partition("=")
    if not equals:
        raise SceneError(f"--set {setting}: must read path=value, as in solver.filter=none")
    parts = _split(path.strip(), setting)
    value = _value(text.strip(), setting)
    place: Any = document
    for part, following in zip(parts, parts[1:], strict=False):
        place = _descend(place, part, following, setting)
    key = _locate(place, parts[-1], setting)
    place[key] = value


def _split(path: str, setting: str) -> list[str | int]:
    parts: list[str | int] = []
    at = 0
    while at < len(path):
        match = _PART.match(path, at)
        index = match and match["index"]
        starts_well = match is not None and (bool(parts) if index else bool(match["dot"]) == bool(parts))
        if match is None or not starts_well:
            raise SceneError(
                f"--set {setting}: cannot read the path at {path[at:]!r}; write it as cloth[0].strain_limit"
            )
        parts.append(int(index) if index else match["bare"] or match["quoted"] or "")
        at = match.end()
    if not parts:
        raise SceneError(
            f"--set {setting}: the path is empty; must read path=value, as in solver.filter=none"
        )
    return parts


def _value(text: str, setting: str) -> Any:
    try:
        document = tomllib.loads(f"value = {text}")
        if document.keys() == {"value"}:
            return document["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        if _WORD.fullmatch(text):
            return text
    raise SceneError(
        f'--set {setting}: {text!r} is not a value; write a number, true, a word, "text" or [a, list]'
    )


def _descend(place: Any, part: str | int, following: str | int, setting: str) -> Any:
    key = _locate(place, part, setting)
    if isinstance(place, dict) and key not in place:
        place[key] = [] if isinstance(following, int) else {}
    return place[key]


def _locate(place: Any, part: str | int, setting: str) -> Any:
    """Key or index of `part` in `place`, which may be new in a table."""
    if isinstance(place, dict) and isinstance(part, str):
        return part
    if not isinstance(place, list):
        raise SceneError(f"--set {setting}: {part!r} lies below a single value or is a number below a table")
    if isinstance(part, int):
        if part < len(place):
            return part
        raise SceneError(f"--set {setting}: [{part}] is out of range; there are {len(place)}, counted from 0")
    names = [item.get("name") if isinstance(item, dict) else None for item in place]
    if names.count(part) == 1:
        return names.index(part)
    known = ", ".join(str(name) for name in names if name) or "none has a name"
    raise SceneError(f"--set {setting}: {part!r} must be a number, as in [0], or one of the names: {known}")
