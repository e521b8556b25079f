"""``taut info``."""

import csv
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taut.cli.console import BAD_INPUT, expected_errors, fail

if TYPE_CHECKING:
    from taut.cache import Cache


def command(
    cache: Annotated[Path, typer.Argument(help="A cache that `taut run` wrote.", metavar="CACHE.zarr")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    as_csv: Annotated[
        bool, typer.Option("--csv", help="Print the numbers of each frame, a line each, for a spreadsheet.")
    ] = False,
) -> None:
    """Print the numbers of a run: sizes, worst stretch, speed .."""
    with expected_errors():
        from taut.cache import Cache, summarize
        from taut.cli.tables import full_table, show

        if as_json and as_csv:
            raise fail("--json prints the numbers of a run and --csv those of frames; give one", BAD_INPUT)
        opened = Cache.open(cache)
        if as_csv:
            return _print_csv(opened)
        summary = summarize(opened)
        if as_json:
            numbers = {name: _or_null(value) for name, value in asdict(summary).items()}
            typer.echo(json.dumps(numbers, indent=2, allow_nan=False))
        else:
            show(full_table(opened, summary))


def _print_csv(cache: "Cache") -> None:
    """Time and diagnostics, a column each, with their names in the first line."""
    columns = {"frame": range(cache.frames), "time": cache.time.tolist()}
    columns |= {name: values.tolist() for name, values in cache.diagnostics.items()}
    lines = csv.writer(sys.stdout, lineterminator="\n")
    lines.writerow(columns)
    lines.writerows(zip(*columns.values(), strict=True))


def _or_null(value: object) -> object:
    """JSON has no infinity: the stretch of a cloth that was torn apart becomes null."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
