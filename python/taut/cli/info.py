"""``taut info``."""

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from taut.cli.console import expected_errors


def command(
    cache: Annotated[Path, typer.Argument(help="A cache that `taut run` wrote.", metavar="CACHE.zarr")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Print the numbers of a run: sizes, worst stretch, speed .."""
    with expected_errors():
        from taut.cache import Cache, summarize
        from taut.cli.tables import full_table, show

        opened = Cache.open(cache)
        summary = summarize(opened)
        if as_json:
            numbers = {name: _or_null(value) for name, value in asdict(summary).items()}
            typer.echo(json.dumps(numbers, indent=2, allow_nan=False))
        else:
            show(full_table(opened, summary))


def _or_null(value: object) -> object:
    """JSON has no infinity: the stretch of a cloth that was torn apart becomes null."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
