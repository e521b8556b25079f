"""``taut compare``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taut.cli.arguments import Sandbox, SceneArgument
from taut.cli.console import STOPPED, Bars, asked_to_stop, expected_errors, fail

if TYPE_CHECKING:
    from taut.compare import Comparison


def command(
    scene: SceneArgument,
    out: Annotated[Path, typer.Option(help="The folder to write.", metavar="DIR")],
    filters: Annotated[str, typer.Option(help="Names that solver.filter allows, or all.")] = "all",
    integrators: Annotated[
        str | None,
        typer.Option(help="Names that solver.integrator allows, or all; default: the scene's own."),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option(min=2, help="Frames of each run, the initial state included; default: duration x fps."),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="Change a field of the scene for all of them.", metavar="PATH=VALUE"),
    ] = None,
    equal_stretch: Annotated[
        bool, typer.Option(help="Search the settings with which each method keeps the limit, too.")
    ] = True,
    budget: Annotated[float, typer.Option(min=0.001, help="Seconds for each such search.")] = 60.0,
    film: Annotated[bool, typer.Option(help="Make the side-by-side film.")] = True,
    threads: Annotated[int | None, typer.Option(min=1, max=1024, help="Default: all cores.")] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an earlier comparison that is there.")
    ] = False,
    sandbox: Sandbox = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Run a scene with several methods: tables, plots, stills and a film side by side."""
    with expected_errors(), Bars(quiet) as bars, asked_to_stop() as asked:
        from taut.compare import Conditions, Options, choose, compare
        from taut.scene import Scene

        changed = Scene.load(scene, sandbox).with_settings(settings or [])
        schemes = [changed.document["solver"]["integrator"]] if integrators is None else _list(integrators)
        methods = choose(_list(filters), schemes)
        told: list[bool] = []

        def watch(what: str, done: int, total: int, note: str) -> None:
            bars.update(what, done, total, note)
            if asked and not told:  # once: what is whole is still to be written
                told.append(True)
                raise KeyboardInterrupt

        conditions = Conditions(frames, threads, watch)
        options = Options(conditions, budget if equal_stretch else None, film, overwrite)
        try:
            found = compare(changed, methods, out, options)
        except KeyboardInterrupt:
            raise fail(f"stopped; {out} was not written", STOPPED) from None
        if not quiet:
            _show(found, out)
        if found.interrupted:
            raise fail(f"stopped; {out} has the methods that were done", STOPPED)


def _list(text: str) -> list[str]:
    """The items of a list with commas."""
    return [item.strip() for item in text.split(",") if item.strip()]


def _show(found: "Comparison", out: Path) -> None:
    from taut.cli.tables import comparison_table, show

    show(comparison_table(found))
    typer.echo(f"{out / 'compare.md'}: all figures and pictures")
