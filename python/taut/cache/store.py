"""Files that are whole or not there, also after a kill or a power cut."""

import asyncio
import os
import sys
import uuid
from pathlib import Path

from zarr.abc.buffer import Buffer
from zarr.storage import LocalStore

UNFINISHED = ".partial"
"""How names of files and folders end that are being written; a later writer clears them away."""


class DurableStore(LocalStore):
    """A folder to which each value is written beside its place, flushed and renamed."""

    def __init__(self, root: Path | str, *, read_only: bool = False) -> None:
        """Open a folder."""
        super().__init__(root, read_only=read_only)
        self._unflushed: set[Path] = set()

    async def set(self, key: str, value: Buffer) -> None:
        """Write a value: a reader sees the old one or the new one, never a part."""
        await asyncio.to_thread(self.set_sync, key, value)

    async def set_if_not_exists(self, key: str, value: Buffer) -> None:
        """Write a value unless there is one; not meant for several writers at a time."""
        if not await self.exists(key):
            await self.set(key, value)

    def set_sync(self, key: str, value: Buffer) -> None:
        """Like :meth:`set`."""
        self.write(key, value.to_bytes())

    def write(self, key: str, value: bytes) -> None:
        """Write a file below the folder, whole or not at all; :meth:`flush` makes its name last, too.

        Raises:
            OSError: the disk is full, the folder is gone ..; the old file is as it was.
        """
        path = self.root / key
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_name(f".{path.name}.{uuid.uuid4().hex}{UNFINISHED}")
        try:
            with beside.open("xb") as file:
                file.write(value)
                file.flush()
                os.fsync(file.fileno())
            beside.replace(path)
        except BaseException:
            beside.unlink(missing_ok=True)
            raise
        self._unflushed.add(path.parent)

    def flush(self) -> None:
        """Make everything written so far last through a power cut.

        Raises:
            OSError: the disk failed.
        """
        while self._unflushed:
            flush_folder(self._unflushed.pop())


def flush_folder(folder: Path) -> None:
    """Make the names in a folder last through a power cut."""
    if sys.platform == "win32":
        return  # Windows cannot open folders; NTFS keeps a journal of names
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
