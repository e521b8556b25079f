"""``taut doctor``."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from taut.cli.console import FAILED, expected_errors


def command(as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False) -> None:
    """Say what this machine has for taut, and what to do about what it lacks (exit status 1)."""
    from taut.doctor import examine

    with expected_errors():
        findings = examine(Path.cwd())
    if as_json:
        typer.echo(json.dumps([asdict(finding) for finding in findings], indent=2))
    else:
        table = Table(show_header=False, box=None, pad_edge=False)
        table.add_column(no_wrap=True)
        table.add_column(style="bold", no_wrap=True)
        table.add_column(overflow="fold")
        for finding in findings:
            mark = Text("ok", "green") if finding.fine else Text("!!", "bold red")
            table.add_row(mark, finding.name, finding.text)
            if not finding.fine:
                table.add_row("", "", Text(finding.remedy, "yellow"))
        Console(markup=False, highlight=False).print(table)
    if not all(finding.fine for finding in findings):
        raise typer.Exit(FAILED)
