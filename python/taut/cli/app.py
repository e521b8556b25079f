"""The commands and their help; each loads what it needs when it is called, so that help is quick."""

import typer

from taut.cli import bench, compare, doctor, export, figures, info, new, render, run, scenes, schema, view

app = typer.Typer(
    help="Cloth that does not stretch: scene file in, moving cloth out.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


@app.callback(invoke_without_command=True)
def _options(version: bool = typer.Option(False, "--version", help="Print the version and stop.")) -> None:
    if version:
        from taut._taut import __version__

        typer.echo(f"taut {__version__}")
        raise typer.Exit


app.command("scenes")(scenes.command)
app.command("new")(new.command)
app.command("run")(run.command)
app.command("view")(view.command)
app.command("render")(render.command)
app.command("export")(export.command)
app.command("info")(info.command)
app.command("compare")(compare.command)
app.command("figures")(figures.command)
app.command("bench")(bench.command)
app.command("schema")(schema.command)
app.command("doctor")(doctor.command)


def main() -> None:
    """Run the command line. Exit status: 0 done, 1 failed on the way, 2 bad input, 130 stopped by Ctrl-C."""
    app()
