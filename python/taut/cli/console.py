"""What goes to the terminal besides results: errors, warnings, bars. All of it to standard error."""

import os
import signal
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import FrameType, TracebackType
from typing import Self

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

BAD_INPUT = 2
FAILED = 1
STOPPED = 130


def stderr() -> Console:
    """A console on standard error."""
    return Console(stderr=True)


def warn(warnings: Iterable[str]) -> None:
    """Print warnings in yellow."""
    console = stderr()
    for text in warnings:
        console.print(Text(f"warning: {text}", style="yellow"), soft_wrap=True)


def fail(message: str, status: int) -> typer.Exit:
    """Print one error in red; raise what this returns."""
    stderr().print(Text("error: ", style="bold red").append(message, style="default"), soft_wrap=True)
    return typer.Exit(status)


@contextmanager
def expected_errors() -> Iterator[None]:
    """Turn the errors that taut raises on purpose into one red line and an exit status.

    With ``TAUT_TRACEBACK=1`` in the environment they keep their traceback.
    """
    from taut.errors import CacheError, CacheWriteError, CompareError, SceneError, SimulationError
    from taut.formats import MeshError, OutputError

    expected = (
        CacheError,
        CacheWriteError,
        CompareError,
        SceneError,
        SimulationError,
        MeshError,
        OutputError,
    )
    try:
        yield
    except expected as error:
        if os.environ.get("TAUT_TRACEBACK") == "1":
            raise
        cut_short = isinstance(error, OutputError) and error.__cause__ is not None
        on_the_way = cut_short or isinstance(error, CacheWriteError | SimulationError)
        raise fail(str(error), FAILED if on_the_way else BAD_INPUT) from None


def make_folder_of(out: Path, yes: bool) -> None:
    """Have a folder for what will be written, if it is not there: ask, or be told by `yes`."""
    folder = out.parent
    if folder.is_dir() or os.path.lexists(folder):  # what else may be wrong is told by who writes
        return
    if not yes:
        if not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise fail(f"--out {out}: there is no folder {folder}; make it, or let --yes make it", BAD_INPUT)
        typer.confirm(f"There is no folder {folder}. Make it?", abort=True, err=True)
    try:
        folder.mkdir(parents=True)
    except OSError as error:
        raise fail(f"--out {out}: the folder {folder} cannot be made: {error.strerror}", FAILED) from None


class Bar:
    """A progress bar with the time that is left; used in ``with``, it appears with the first progress."""

    def __init__(self, name: str, quiet: bool = False) -> None:
        """Name what is being made; a quiet bar is never seen."""
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        self._progress = Progress(
            *columns, TextColumn("{task.fields[note]}"), console=stderr(), disable=quiet
        )
        self._task = self._progress.add_task(name, note="")
        self._seen = False

    def update(self, done: int, total: int, note: str = "") -> None:
        """Show that `done` of `total` frames are done."""
        if not self._seen:
            self._progress.start()
            self._seen = True
        self._progress.update(self._task, completed=done, total=total, note=note)

    def __enter__(self) -> Self:
        """Return this bar."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the bar as it stands."""
        if self._seen:
            self._progress.stop()


class Bars:
    """A bar for each thing that is made, one after the other; used in ``with``."""

    def __init__(self, quiet: bool = False) -> None:
        """Quiet bars are never seen."""
        self._quiet = quiet
        self._stack = ExitStack()
        self._name = ""
        self._bar: Bar | None = None

    def update(self, name: str, done: int, total: int, note: str = "") -> None:
        """Show that `done` of `total` frames of the thing of this name are done."""
        if self._bar is None or name != self._name:
            self._stack.close()
            self._name, self._bar = name, self._stack.enter_context(Bar(name, self._quiet))
        self._bar.update(done, total, note)

    def __enter__(self) -> Self:
        """Return these bars."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the last bar as it stands."""
        self._stack.close()


@contextmanager
def asked_to_stop() -> Iterator[list[int]]:
    """Collect Ctrl-C, so that the frame in hand is finished first; a second one stops at once."""
    asked: list[int] = []

    def on_signal(number: int, frame: FrameType | None) -> None:
        if asked:
            raise KeyboardInterrupt
        asked.append(number)

    before = signal.signal(signal.SIGINT, on_signal)
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)
