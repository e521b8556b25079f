"""``taut compare``."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taut.cli.arguments import OptionalScene, Sandbox
from taut.cli.console import STOPPED, Bars, asked_to_stop, expected_errors, fail

if TYPE_CHECKING:
    from taut.compare import Comparison
    from taut.compare.contact import Found, Method
    from taut.scene import Scene

_BUDGET = 60.0


def command(
    scene: OptionalScene = None,
    *,
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
    budget: Annotated[float, typer.Option(min=0.001, help="Seconds for each such search.")] = _BUDGET,
    contact: Annotated[
        bool,
        typer.Option(
            "--contact", help="Compare ways to handle contact; without a scene on small ones built in."
        ),
    ] = False,
    methods: Annotated[
        str,
        typer.Option(
            help="With --contact: some of ours, bridson, provot, penalty, none, or all but the last: all."
        ),
    ] = "all",
    scenes: Annotated[
        str,
        typer.Option(help="With --contact and no scene: some of ball, heap, layers, twist, or all."),
    ] = "all",
    film: Annotated[
        bool | None,
        typer.Option(help="Make the side-by-side film; default: yes, with --contact no.", show_default=False),
    ] = None,
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
        from taut.compare.contact import compare_contact
        from taut.errors import CompareError
        from taut.scene import Scene

        given = {"--filters": filters != "all", "--integrators": integrators is not None}
        given |= {"--no-equal-stretch": not equal_stretch, "--budget": budget != _BUDGET}
        only = {"--methods": methods != "all", "--scenes": scenes != "all"}
        for name, wrong in (given if contact else only).items():
            if wrong:
                raise CompareError(f"{name}: {'not together with' if contact else 'only with'} --contact")
        if scene is None and not contact:
            raise CompareError("no scene is named: name a file or a shipped scene, or compare --contact")
        told: list[bool] = []

        def watch(what: str, done: int, total: int, note: str) -> None:
            bars.update(what, done, total, note)
            if asked and not told:  # once: what is whole is still to be written
                told.append(True)
                raise KeyboardInterrupt

        conditions = Conditions(frames, threads, watch)
        changed = None if scene is None else Scene.load(scene, sandbox).with_settings(settings or [])
        found: Comparison | Found
        try:
            if contact:
                chosen = _scenes(scenes, changed, scene, settings or [])
                found = compare_contact(chosen, _methods(methods), out, conditions, bool(film), overwrite)
            else:
                assert changed is not None
                own = [changed.document["solver"]["integrator"]]
                pairs = choose(_list(filters), own if integrators is None else _list(integrators))
                options = Options(conditions, budget if equal_stretch else None, film is not False, overwrite)
                found = compare(changed, pairs, out, options)
        except KeyboardInterrupt:
            raise fail(f"stopped; {out} was not written", STOPPED) from None
        if not quiet:
            _show(found, out)
        if found.interrupted:
            raise fail(f"stopped; {out} has the methods that were done", STOPPED)


def _methods(names: str) -> "list[Method]":
    """Ways to handle contact."""
    from taut.compare.contact import choose

    return choose(_list(names))


def _scenes(names: str, given: "Scene | None", path: Path | None, settings: list[str]) -> "dict[str, Scene]":
    """The scene that was given, or small ones."""
    from taut.compare.contact import built_in
    from taut.errors import CompareError

    if given is None or path is None:
        return built_in(_list(names), settings)
    if names != "all":
        raise CompareError(f"--scenes: not together with a scene, here {path}")
    return {re.sub(r"[^\w-]+", "-", path.stem) or "scene": given}


def _list(text: str) -> list[str]:
    """The items of a list with commas."""
    return [item.strip() for item in text.split(",") if item.strip()]


def _show(found: "Comparison | Found", out: Path) -> None:
    from taut.cli.tables import comparison_table, contact_table, show
    from taut.compare import Comparison

    show(comparison_table(found) if isinstance(found, Comparison) else contact_table(found))
    typer.echo(f"{out / 'compare.md'}: all figures and pictures")
