"""One writer for each cache: the folder itself is locked, so that no lock is left behind."""

import errno
import os
import sys
from pathlib import Path

from taut.errors import CacheError

_CANNOT_LOCK = (errno.EBADF, errno.EINVAL, errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)


class FolderLock:
    """A lock on a folder, gone with the process that holds it; it follows the folder when that is renamed.

    Where folders cannot be locked (Windows, some network disks) the lock always succeeds.
    """

    def __init__(self, folder: Path) -> None:
        """Lock an existing folder.

        Raises:
            CacheError: another process holds it.
            OSError: the folder cannot be opened.
        """
        self._handle: int | None = None
        if sys.platform == "win32":
            return
        import fcntl  # not there on Windows

        self._handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.release()
            raise CacheError(
                f"{folder} is being written by another run; wait for it or choose another name"
            ) from None
        except OSError as error:
            if error.errno not in _CANNOT_LOCK:
                self.release()
                raise

    def holds(self, folder: Path) -> bool:
        """Whether `folder` is still the folder that was locked, not another one of its name."""
        if self._handle is None:
            return folder.exists()
        try:
            return os.path.samestat(os.fstat(self._handle), folder.stat())
        except OSError:
            return False

    def release(self) -> None:
        """Let others write."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None
