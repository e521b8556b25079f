"""The folder of a cache: put in place whole, replaced only on demand, cleared of what a kill left."""

import json
import os
import shutil
import uuid
from contextlib import suppress
from pathlib import Path

from taut.cache.lock import FolderLock
from taut.cache.store import UNFINISHED, flush_folder
from taut.errors import CacheError


def check_free(path: Path, overwrite: bool = False) -> None:
    """Make sure that a new cache may be put at `path`.

    Args:
        path: where.
        overwrite: allow a cache that is there; anything else is never replaced.

    Raises:
        CacheError: something is there that must stay.
    """
    if not os.path.lexists(path):
        return
    if not overwrite:
        raise CacheError(
            f"{path} exists already; go on with it (--resume), replace it (--overwrite) or take another name"
        )
    if not _is_cache(path):
        raise CacheError(f"{path} exists and is no cache, so it is not overwritten; choose another name")


def _is_cache(path: Path) -> bool:
    try:
        found = json.loads((path / "zarr.json").read_bytes())["attributes"]["format"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return isinstance(found, str) and found.startswith("taut-cache/")


def beside(path: Path) -> Path:
    """A new name in the same folder, for what is not yet (or no longer) the cache."""
    return path.with_name(f".{path.name}.{uuid.uuid4().hex}{UNFINISHED}")


def move_into_place(built: Path, path: Path, overwrite: bool) -> None:
    """Rename a complete folder to `path`.

    Raises:
        CacheError: something is there that must stay, or is being written.
        OSError: the disk failed; what was at `path` is still there.
    """
    check_free(path, overwrite)
    if not overwrite or not path.exists():
        os.rename(built, path)
        flush_folder(path.parent)
        return
    lock, old = FolderLock(path), beside(path)
    try:
        os.rename(path, old)
        try:
            os.rename(built, path)
        except OSError:
            os.rename(old, path)
            raise
        flush_folder(path.parent)
        shutil.rmtree(old, ignore_errors=True)
    finally:
        lock.release()


def clear_leftovers(path: Path) -> None:
    """Delete what killed runs left beside `path` and in it; what a living run is writing stays."""
    for found in path.parent.iterdir():
        if found.name.startswith(f".{path.name}.") and found.name.endswith(UNFINISHED):
            with suppress(CacheError, OSError):
                lock = FolderLock(found)
                shutil.rmtree(found, ignore_errors=True)
                lock.release()


def clear_unfinished_files(path: Path) -> None:
    """Delete the files that a killed run had not finished; the caller holds the lock of `path`."""
    for found in path.rglob(f"*{UNFINISHED}"):
        found.unlink(missing_ok=True)
