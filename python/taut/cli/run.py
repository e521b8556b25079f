"""``taut run``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taut.cli.arguments import Sandbox, SceneArgument, Yes
from taut.cli.console import (
    BAD_INPUT,
    STOPPED,
    Bar,
    asked_to_stop,
    expected_errors,
    fail,
    make_folder_of,
    warn,
)

if TYPE_CHECKING:
    from taut.run import Existing, Progress, Recording
    from taut.simulation import Simulation

_QUICK = 1e9
"""Scenes with contact that need no more memory are built in a dry run [bytes]."""


def command(
    scene: SceneArgument,
    out: Annotated[
        Path | None,
        typer.Option(help="The cache to write; default: SCENE.zarr, in this folder.", metavar="CACHE.zarr"),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option(min=1, help="Frames in all, the initial state included; default: duration x fps."),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help="Change a field: solver.filter=none, cloth[0].pins=[].", metavar="PATH=VALUE"
        ),
    ] = None,
    threads: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Default: all cores. Results do not depend on it.")
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the cache after its last frame.")
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a cache that is there.")] = False,
    sandbox: Sandbox = False,
    yes: Yes = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", help="Only check the scene and say how much memory and disk it needs."),
    ] = False,
) -> None:
    """Simulate a scene and write its frames to a cache."""
    if resume and overwrite:
        raise fail("--resume goes on with a cache and --overwrite replaces it; give one of them", BAD_INPUT)
    existing: Existing = "resume" if resume else "overwrite" if overwrite else "refuse"
    out = Path(f"{scene.stem}.zarr") if out is None else out
    with expected_errors():
        from taut.cache import Cache, check_free, summarize
        from taut.cli.tables import needs_table, run_table, show
        from taut.scene import Scene
        from taut.simulation import Simulation

        if not resume:
            check_free(out, overwrite)
        asked = Scene.load(scene, sandbox).with_settings(settings or [])
        if dry_run:
            count = asked.frames if frames is None else frames
            needs = asked.needs(count)
            collides = asked.document.get("contact") is not None
            # What intersects at the start is known when all is built; that is quick unless it is large.
            is_built = collides and needs.memory <= _QUICK
            warn(Simulation(asked, threads=1).warnings if is_built else asked.warnings)
            return show(needs_table(needs, count))
        make_folder_of(out, yes)
        simulation = Simulation(asked, threads)
        if not quiet:
            warn(simulation.warnings)
        done = _record_with_bar(simulation, out, frames, existing, quiet)
        if quiet:
            return
        warn(done.notes)
        cache = Cache.open(done.path)
        if done.resumed_at == done.frames:
            typer.echo(f"{out} was finished already: it has {done.frames} frames")
        show([*run_table(cache, summarize(cache)), ("written", str(out))])


def _record_with_bar(
    simulation: "Simulation", out: Path, frames: int | None, existing: "Existing", quiet: bool
) -> "Recording":
    """Record; on Ctrl-C keep what is there and say how to go on."""
    from taut.run import record

    with Bar(out.name, quiet) as bar, asked_to_stop() as asked:

        def on_frame(now: "Progress") -> None:
            bar.update(now.frame + 1, now.frames, f"worst stretch {100 * now.worst_stretch:.2f} %")
            if asked:
                raise KeyboardInterrupt

        try:
            return record(simulation, out, frames, existing, on_frame)
        except KeyboardInterrupt:
            message = f"stopped; {out} has all frames so far: the same command with --resume goes on"
    raise fail(message, STOPPED)
