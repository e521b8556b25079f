"""A scene as a TOML file that explains itself: every field with its meaning, its unit and its value."""

import json
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from taut.scene.fields import Field, describe, fields
from taut.scene.scene import Scene

_WIDTH = 110

_HEAD = """\
# {title}: a scene of taut. All units are SI.
#
#   taut run {name}.toml
#   taut render {name}.zarr --out {name}.mp4
#
# A line like `#fps = 60.0` is a field that is left at its value: take the # away to change it.
"""


def commented(scene: Scene, given: Mapping[str, Any], name: str) -> str:
    """Write a scene as TOML with a comment on every field.

    The comments come from the schema of scenes, the values of what is not given from the resolved scene, so
    neither can go stale.

    Args:
        scene: the scene, checked.
        given: what it was made of; these fields are set, all others are shown as comments.
        name: of the file, without its extension.
    """
    head = _HEAD.format(title=scene.title, name=name)
    return head + "\n".join(_table("", "Scene", given, scene.document)) + "\n"


def _table(path: str, table: str, given: Mapping[str, Any], resolved: Mapping[str, Any]) -> Iterator[str]:
    """The lines of a table without its header; tables in it become sections after its own fields."""
    known = {field.name: field for field in fields(table)}
    sections: list[Field] = []
    absent: list[Field] = []
    for field in (known[name] for name in dict.fromkeys((*given, *resolved, *known))):
        value = given.get(field.name)
        as_section = field.table is not None and (not field.many or not path)
        if as_section and (value is not None or isinstance(resolved.get(field.name), dict)):
            sections.append(field)
        elif value is not None:
            yield ""
            yield from _comment(_meaning(field))
            yield f"{field.name} = {toml(value)}"
        elif field.table is None and resolved.get(field.name) is not None:
            yield ""
            yield from _comment(_meaning(field))
            yield f"#{field.name} = {toml(resolved[field.name])}"
        else:
            absent.append(field)
    if absent:
        yield ""
        yield "# Also possible here:"
        for field in absent:
            yield from _comment(f"{field.name}: {_meaning(field)}", "  ")
    for field in sections:
        yield from _sections(path, field, given.get(field.name), resolved[field.name])


def _sections(path: str, field: Field, given: Any, resolved: Any) -> Iterator[str]:
    """A table, or a list of tables, under its own header."""
    inner = f"{path}.{field.name}".removeprefix(".")
    header = f"[[{inner}]]" if field.many else f"[{inner}]"
    pairs = zip(given, resolved, strict=True) if field.many else [(given or {}, resolved)]
    for one, full in pairs:
        yield ""
        yield ""
        yield from _comment(describe(field.table or "") if field.many else field.description)
        yield header
        yield from _table(inner, field.table or "", one, full)


def _meaning(field: Field) -> str:
    """Description of a field; of words the choices too, of tables what is in them."""
    if field.table is not None:
        parts = ", ".join(part.name for part in fields(field.table))
        kind = "A list of tables" if field.many else "A table"
        about = describe(field.table).removeprefix(field.description).strip()
        return f"{field.description} {kind} of {parts}. {about}".strip()
    untold = [word for word in field.choices if f'"{word}"' not in field.description]
    if untold:
        return f"{field.description} One of {', '.join(map(json.dumps, field.choices))}."
    return field.description


def _comment(text: str, indent: str = "") -> list[str]:
    lead = f"# {indent}"
    return textwrap.wrap(
        text,
        _WIDTH,
        initial_indent=lead,
        subsequent_indent=lead + indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def toml(value: Any) -> str:
    """A value of plain JSON kind as TOML, on one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False)
