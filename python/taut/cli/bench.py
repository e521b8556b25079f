"""``taut bench``."""

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from taut.cli.console import BAD_INPUT, FAILED, expected_errors, fail, warn

if TYPE_CHECKING:
    from taut.bench import Case, Window

Item = TypeVar("Item", str, int, float)


def command(
    scenes: Annotated[
        str, typer.Option(help="What to measure; `mesh` is an irregular mesh, and a grid as large beside it.")
    ] = "one-corner,two-corners,flag,mesh",
    sizes: Annotated[str, typer.Option(help="Cells along a side; one particle more.")] = "32,64,128,256",
    mesh_sizes: Annotated[str, typer.Option(help="The same for meshes; 223 makes 50,176 vertices.")] = "223",
    limits: Annotated[str, typer.Option(help="Strain limits in per cent.")] = "1,10",
    threads: Annotated[str, typer.Option(help="Worker threads.")] = "1,2",
    frames: Annotated[int, typer.Option(min=1, help="Frames of a row, from the start of the scene.")] = 60,
    seconds: Annotated[
        float, typer.Option(min=0.001, help="Time for a row; no further frame is begun after it.")
    ] = 2.0,
    repeats: Annotated[
        int, typer.Option(min=1, help="Most runs of the same frames within that time; medians count.")
    ] = 5,
    full: Annotated[
        bool, typer.Option("--full", help="Sizes to 512, limits 1, 5 and 10 %, up to a minute a row.")
    ] = False,
    csv: Annotated[Path | None, typer.Option(help="Append the rows to this file, too.")] = None,
    history: Annotated[
        Path | None, typer.Option(help="Folder of the history. Default: benches/history, if it is there.")
    ] = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="Show the last ratio of the same row in the history.")
    ] = False,
) -> None:
    """Time whole scenes against one plain spring-force pass."""
    if full:
        sizes, limits, seconds = "32,64,128,256,512", "1,5,10", 60.0
    with expected_errors():
        from taut.bench import SCENES, Window, plan
        from taut.simulated import MOST_THREADS

        chosen = _list("scenes", scenes, str)
        for name in chosen:
            if name not in SCENES:
                raise fail(
                    f"--scenes {name}: there is no such scene; there are {', '.join(SCENES)}", BAD_INPUT
                )
        shares = [limit / 100 for limit in _list("limits", limits, float)]
        workers = _list("threads", threads, int)
        for count in workers:
            if not 1 <= count <= MOST_THREADS:
                raise fail(f"--threads {count}: must be 1 to {MOST_THREADS}", BAD_INPUT)
        grids, meshes = _list("sizes", sizes, int), _list("mesh-sizes", mesh_sizes, int)
        cases = plan(chosen, grids, meshes, shares, workers)
        try:
            _measure(cases, Window(frames, seconds, repeats), csv, history, compare)
        except OSError as error:
            raise fail(f"cannot write {error.filename}: {error.strerror}", FAILED) from None


def _list(option: str, text: str, kind: Callable[[str], Item]) -> list[Item]:
    """The items of a list with commas."""
    try:
        return [kind(item) for item in text.split(",")]
    except ValueError:
        raise fail(f"--{option} {text}: must be numbers with commas between them", BAD_INPUT) from None


_HEAD = (
    "scene        size  limit  threads  frames  steps  cycles   ms/frame  ns/particle/step"
    "   worst  cuts  yardstick   ratio"
)


def _measure(
    cases: "list[Case]", window: "Window", csv: Path | None, folder: Path | None, compare: bool
) -> None:
    """Measure every row, show it and keep it."""
    from taut.bench import HISTORY, History, measure, this_machine

    machine = this_machine()
    folder = folder or (HISTORY if HISTORY.is_dir() else None)
    past = None if folder is None else History.of(machine, folder)
    typer.echo(f"{machine}, taut {machine.version} {machine.revision}")
    typer.echo(_HEAD + ("  before" if compare else ""))
    disturbed = 0
    for case in cases:
        row = measure(case, window)
        disturbed += row.disturbed
        line = (
            f"{row.scene:11} {row.cells:5} {100 * row.strain_limit:4g} % {row.threads:8} {row.frames:7}"
            f" {row.steps_per_frame:6} {row.cycles_per_frame:7.1f} {row.ms_per_frame:10.2f}"
            f" {row.ns_per_particle_step:17.1f} {100 * row.worst_stretch:6.2f} % {row.cuts:4}"
            f" {row.yardstick_ms:7.3f} ms {row.ratio:7.1f}"
        )
        before = past.last_ratio(row) if past is not None and compare else None
        typer.echo(line + ("" if before is None else f"{before:8.1f}"))
        now = datetime.now(UTC)
        for kept_in in (past, None if csv is None else History(csv)):
            if kept_in is not None:
                kept_in.append(row, machine, now)
    kept = "not kept: there is no folder benches/history here" if past is None else f"kept in {past.path}"
    typer.echo("ms/frame: mean of the frames; yardstick: one plain spring-force pass on one thread;")
    typer.echo(f"ratio: frame / yardstick; {kept}")
    if disturbed:
        warn([f"{disturbed} rows of one thread took too long: something else kept the processor busy"])
