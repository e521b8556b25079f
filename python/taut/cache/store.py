"""Files that are whole or not there, also after a kill or a power cut."""

import os
import sys
import uuid
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

UNFINISHED = ".partial"
"""How names of files and folders end that are being written; a later writer clears them away."""

_AT_A_TIME = 10
"""Files that are flushed at the same time [1]; a disk answers several almost as fast as one."""


class DurableFolder:
    """A folder to which each file is written beside its place, flushed and renamed."""

    def __init__(self, root: Path) -> None:
        """Write below `root`."""
        self.root = root
        self._unflushed: set[Path] = set()

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

    def write_all(self, files: Mapping[str, bytes]) -> None:
        """Write several files; none is being written any more when this returns or raises.

        Raises:
            OSError: one of them cannot be written; others may be.
        """
        if len(files) == 1:
            self.write(*next(iter(files.items())))
            return
        with ThreadPoolExecutor(_AT_A_TIME) as pool:
            list(pool.map(self.write, files, files.values()))

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
