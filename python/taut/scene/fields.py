"""The fields of a scene as its one definition has them: names, descriptions, units, defaults, choices."""

import json
from dataclasses import dataclass
from functools import cache
from typing import Any

from taut import _taut


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a table of a scene."""

    name: str
    """As written in a scene."""
    description: str
    """What it means, with its unit in brackets."""
    default: Any
    """Its value when left out; None if there is none, or if it depends on other fields."""
    table: str | None
    """Name of the definition of the table or tables that it holds, if it holds any."""
    many: bool
    """Whether it holds a list of those tables."""
    choices: dict[str, str]
    """The words that it may be, with what each means; empty for anything but words."""


@cache
def _schema() -> dict[str, Any]:
    schema: dict[str, Any] = json.loads(_taut.scene_schema())
    return schema


def tables() -> list[str]:
    """Names of all tables, the scene first, each before those that it holds."""
    found = ["Scene"]
    for table in found:
        found += dict.fromkeys(
            field.table for field in fields(table) if field.table and field.table not in found
        )
    return found


def describe(table: str) -> str:
    """What a table is, in one or two sentences."""
    return str(_definition(table)["description"]).replace("\n\n", " ")


def fields(table: str = "Scene") -> list[Field]:
    """The fields of a table, in alphabetical order."""
    return [_field(name, schema) for name, schema in _definition(table)["properties"].items()]


def _definition(name: str) -> dict[str, Any]:
    schema: dict[str, Any] = _schema() if name == "Scene" else _schema()["$defs"][name]
    return schema


def _field(name: str, schema: dict[str, Any]) -> Field:
    reference = _reference(schema)
    many = reference is None and "items" in schema
    if many:
        reference = _reference(schema["items"])
    held = _definition(reference) if reference else {}
    words = {item["const"]: item["description"] for item in held.get("oneOf", ()) if "description" in item}
    table = reference if "properties" in held else None
    default = schema.get("default")
    return Field(
        name, schema["description"], default, table, many and table is not None, {} if many else words
    )


def _reference(schema: dict[str, Any]) -> str | None:
    """Name of the definition that a value follows, null aside."""
    for candidate in (schema, *schema.get("anyOf", ())):
        if "$ref" in candidate:
            return str(candidate["$ref"]).rsplit("/", 1)[-1]
    return None
