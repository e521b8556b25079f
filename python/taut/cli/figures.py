"""``taut figures``."""

from pathlib import Path
from typing import Annotated

import typer

from taut.cli.console import STOPPED, Bars, expected_errors, fail


def command(
    out: Annotated[Path, typer.Option(help="The folder to write.", metavar="DIR")],
    quick: Annotated[bool, typer.Option("--quick", help="Tiny cloths, to try it out.")] = False,
    threads: Annotated[int | None, typer.Option(min=1, max=1024, help="Default: all cores.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an earlier page.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Make the figures of the paper again: a page with each claim and what is measured."""
    with expected_errors(), Bars(quiet) as bars:
        from taut.figures import Options, make_figures

        try:
            sections = make_figures(out, Options(quick, threads, overwrite, bars.update))
        except KeyboardInterrupt:
            raise fail(f"stopped; {out} was not written", STOPPED) from None
    if not quiet:
        for section in sections:
            typer.echo(f"{section.number}: the claim {section.verdict}")
        typer.echo(f"{out / 'index.html'}: the page")
