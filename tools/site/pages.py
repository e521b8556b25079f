"""What the program itself says of its commands and of the fields of a scene, as Markdown."""

import json

from taut.cli.app import app
from taut.scene.fields import Field, describe, fields, tables
from typer.testing import CliRunner


def commands() -> str:
    """Every command with the help that it prints."""
    lines: list[str] = []
    for command in app.registered_commands:
        shown = CliRunner().invoke(
            app, [str(command.name), "--help"], prog_name="taut", env={"COLUMNS": "100"}
        )
        lines += [f"## taut {command.name}", "", "```text", shown.stdout.strip(), "```", ""]
    return "\n".join(lines)


def scene_fields() -> str:
    """Every field of a scene, table by table."""
    lines: list[str] = []
    for table in tables():
        lines += [f"## {table}", "", describe(table), "", "| field | meaning | default |", "|---|---|---|"]
        lines += [_row(field) for field in fields(table)]
        lines.append("")
    return "\n".join(lines)


def _row(field: Field) -> str:
    meaning = field.description
    if field.table is not None:
        meaning += f" {'A list of' if field.many else 'A'} [{field.table}](#{field.table.lower()})."
    elif field.choices:
        meaning += "<br>" + "<br>".join(f'`"{word}"`: {about}' for word, about in field.choices.items())
    shown = field.default is not None and field.table is None
    default = f"`{json.dumps(field.default)}`" if shown else ""
    return f"| `{field.name}` | {meaning.replace('|', chr(92) + '|')} | {default} |"
