"""Files and folders that appear whole or not at all: write beside, flush, rename."""

import errno
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


class OutputError(RuntimeError):
    """Something cannot be written. The text names the file, the reason and a remedy."""


@contextmanager
def whole_file(out: Path, overwrite: bool, error: type[OutputError] = OutputError) -> Iterator[Path]:
    """Hand out a path to write to; what stands there at the end becomes ``out``.

    Args:
        out: the file to make; its folder is made if need be.
        overwrite: replace an existing file (at the very end, in one move).
        error: the kind of error to raise.

    Raises:
        OutputError: ``out`` exists, or cannot be written; then nothing is left behind.
    """
    if out.is_dir():
        raise error(f"{out} is a folder: name a file")
    if out.exists() and not overwrite:
        raise error(f"{out} exists already: choose another name, or ask for it to be overwritten")
    part = _beside(out)
    try:
        with _explained(out, error):
            out.parent.mkdir(parents=True, exist_ok=True)
            yield part
            _flush(part)
            os.replace(part, out)
            _flush(out.parent)
    finally:
        with suppress(OSError):
            part.unlink()


@contextmanager
def whole_folder(
    out: Path, overwrite: bool, ours: Callable[[str], bool], error: type[OutputError] = OutputError
) -> Iterator[Path]:
    """Hand out an empty folder to fill; at the end it becomes ``out``.

    Args:
        out: the folder to make; the folder it lies in is made if need be.
        overwrite: replace an existing folder, if it holds nothing but files that ``ours`` recognises.
        ours: whether a file name is one that this export writes.
        error: the kind of error to raise.

    Raises:
        OutputError: ``out`` exists, or cannot be written; then nothing is left behind.
    """
    _check_replaceable(out, overwrite, ours, error)
    part = _beside(out)
    try:
        with _explained(out, error):
            part.mkdir(parents=True)
            yield part
            for path in part.iterdir():
                _flush(path)
            _flush(part)
            _move_folder(part, out)
            _flush(out.parent)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _check_replaceable(
    out: Path, overwrite: bool, ours: Callable[[str], bool], error: type[OutputError]
) -> None:
    if not out.exists():
        return
    if not out.is_dir():
        raise error(f"{out} is a file: this format fills a folder, choose another name")
    names = sorted(path.name for path in out.iterdir())
    if names and not overwrite:
        raise error(f"{out} exists already: choose another name, or ask for it to be overwritten")
    for name in names:
        if not ours(name):
            raise error(f"{out} holds {name!r}, which no export wrote: choose another folder")


def _move_folder(part: Path, out: Path) -> None:
    """Rename ``part`` to ``out``; a folder that stood there is put back if that fails."""
    if not out.exists():
        os.rename(part, out)
        return
    old = out.with_name(f"{part.name}.old")
    os.rename(out, old)
    try:
        os.rename(part, out)
    except OSError:
        os.rename(old, out)
        raise
    shutil.rmtree(old)


def _beside(out: Path) -> Path:
    # The suffix stays last: picture and film libraries choose the format by it.
    return out.with_name(f".{out.stem}.{os.getpid()}.part{out.suffix}")


def _flush(path: Path) -> None:
    """Wait until a file or folder is on the disk."""
    if path.is_dir() and os.name == "nt":
        return  # Windows has no handle on a folder to flush.
    handle = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def _explained(out: Path, error: type[OutputError]) -> Iterator[None]:
    try:
        yield
    except OSError as cause:
        full = cause.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
        remedy = "free some space or choose another disk" if full else "choose another place"
        reason = cause.strerror or str(cause)
        raise error(f"{out} cannot be written: {reason}; {remedy} (nothing was left behind)") from cause
