"""The writing side of a cache. A kill at any moment leaves whole frames only.

A frame becomes part of the cache in three moves, each of them a rename of flushed files:

1. The chunks of its arrays are written where no reader looks yet: beyond the shapes that are on disk.
2. The ``zarr.json`` of each array gets the greater shape, `positions` last.
3. The ``zarr.json`` of the group gets the shapes of all arrays ("consolidated metadata"), the new
   ``state_hash`` and a checksum. This one rename is the commit for everybody who opens the group.

Zarr encodes in memory; files are written here. So nothing is still being written after a disk has failed.
"""

import errno
import json
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.abc.buffer import Buffer
from zarr.storage import MemoryStore, StorePath

from taut.cache import layout, metadata, place
from taut.cache.header import Frame, Header
from taut.cache.lock import FolderLock
from taut.cache.reader import Cache
from taut.cache.recover import check_same_run, last_whole_frame
from taut.cache.store import DurableFolder
from taut.errors import CacheError, CacheWriteError

FIRST_INTERVAL, LONGEST_INTERVAL = 0.02, 0.5
"""Frames of this much wall-clock time become part of the cache together [s]. The interval doubles from the
first to the longest, so that even a run that is killed again and again, soon after its start, moves on."""

MOST_BYTES = 64 * 2**20
"""Positions waiting for the next commit take less than this [bytes]."""

_BEYOND = 2**31 - 1
"""Frames that an array seems to have while chunks are written beyond its shape on disk."""

_NOTHING_LEFT = "no frame is kept, nothing was left behind"


class CacheWriter:
    """Adds frames to a cache that nobody else writes; made by :meth:`create` or :meth:`resume`.

    In a ``with`` statement, all frames that were appended are in the cache at its end, whatever ended it.
    """

    def __init__(self, path: Path, lock: FolderLock, frames: int) -> None:
        """Go on after `frames` frames of the cache at `path`, whose lock is handed over.

        Raises:
            CacheError: it is damaged.
        """
        self.notes: list[str] = []
        """What was found and repaired, one sentence each."""
        self._path = path
        self._lock = lock
        self._folder = DurableFolder(path)
        self._document = metadata.read(path)
        self._nodes: dict[str, Any] = self._document["consolidated_metadata"]["metadata"]
        self._encoded: dict[str, Buffer] = {}
        self._arrays = {name: self._longer(name) for name in layout.growing(self._nodes)}
        summed = self._nodes.get(layout.CHECKSUMS, {"attributes": {"arrays": []}})
        self._summed: list[str] = summed["attributes"]["arrays"]
        written = Cache.open(path) if frames else None
        self._begun = {name: self._rows_of_last_chunk(written, name, frames) for name in self._arrays}
        self._vertices: int = self._nodes["positions"]["shape"][1]
        self._cloths = len(self._document["attributes"]["cloths"])
        self._committed = frames
        self._pending: list[dict[str, Any]] = []
        self._interval = FIRST_INTERVAL
        self._last_commit = time.monotonic()
        self._broken = False

    @classmethod
    def create(cls, path: str | Path, header: Header, first: Frame, overwrite: bool = False) -> Self:
        """Make a new cache that holds one frame. It appears complete or not at all.

        Args:
            path: where; missing folders above it are made.
            header: what is the same in all frames.
            first: the initial state.
            overwrite: replace a cache that is there; anything else is never replaced.

        Raises:
            CacheError: something is there already.
            CacheWriteError: the disk is full, say; nothing is left behind.
        """
        path = Path(path)
        place.check_free(path, overwrite)
        if path.is_symlink():
            path = path.resolve()
        built = place.beside(path)
        lock: FolderLock | None = None
        try:
            with _explained(path, _NOTHING_LEFT):
                path.parent.mkdir(parents=True, exist_ok=True)
                place.clear_leftovers(path)
                built.mkdir()
                lock = FolderLock(built)
                folder = DurableFolder(built)
                folder.write_all(layout.empty(header))
                folder.flush()
                writer = cls(built, lock, frames=0)
                writer.append(first)
                writer.commit()
                place.move_into_place(built, path, overwrite)
                return cls(path, lock, frames=1)
        except BaseException:
            shutil.rmtree(built, ignore_errors=True)
            if lock is not None:
                lock.release()
            raise

    @classmethod
    def resume(cls, path: str | Path, header: Header) -> Self:
        """Go on with a cache after its last whole frame.

        Raises:
            CacheError: there is none, it is being written, belongs to another scene or has no whole frame.
            CacheWriteError: the disk is full, say.
        """
        path = Path(path)
        Cache.open(path)  # says what is wrong with a path that is no cache
        with _explained(path, "its frames are as they were"):
            lock = FolderLock(path)
            try:
                return cls._resume_locked(path, lock, header)
            except BaseException:
                lock.release()
                raise

    @classmethod
    def _resume_locked(cls, path: Path, lock: FolderLock, header: Header) -> Self:
        if not lock.holds(path):
            raise CacheError(f"{path} was just replaced by another run; look at it before going on")
        place.clear_unfinished_files(path)
        cache = Cache.open(path)
        check_same_run(cache, header)
        whole = last_whole_frame(cache) + 1
        writer = cls(path, lock, whole)
        writer._document["attributes"].update(header.attributes)
        if whole < cache.frames:
            writer._forget_from(whole, cache)
        return writer

    @property
    def frames(self) -> int:
        """Frames in the cache, together with those that the next commit adds [1]."""
        return self._committed + len(self._pending)

    def append(self, frame: Frame) -> None:
        """Add a frame; at least twice a second what was added becomes part of the cache.

        Raises:
            ValueError: an array has another shape than the cache or a number that is not finite.
            CacheWriteError: the disk is full, say; earlier frames stay readable.
        """
        for name in layout.STATE:
            values = getattr(frame, name)
            if values.shape != (self._vertices, 3) or not np.isfinite(values).all():
                raise ValueError(
                    f"{name}: must be finite and of shape {(self._vertices, 3)}, not {values.shape}"
                )
        row = _numbers(frame, self._cloths)
        sums = [layout.checksum(name, self.frames, row[name]) for name in self._summed]
        self._pending.append(row | {layout.CHECKSUMS: np.array(sums, np.uint32)})
        moved = ("positions", layout.BODY_POSITIONS)
        full = sum(row[name].nbytes for row in self._pending for name in moved if name in row) >= MOST_BYTES
        if full or time.monotonic() - self._last_commit >= self._interval:
            self.commit()
            self._interval = min(2 * self._interval, LONGEST_INTERVAL)

    def commit(self) -> None:
        """Make every frame that was appended part of the cache.

        Raises:
            CacheWriteError: the disk is full, say; earlier frames stay readable.
        """
        if not self._pending:
            return
        frames = self.frames
        with self._writing():
            small: dict[str, bytes] = {}
            for name, array in self._arrays.items():
                files = self._encoded_rows(name, frames)
                if array.chunks[0] > 1:
                    small |= files  # a file or two of each array: together they are flushed at the same time
                else:
                    self._folder.write_all(files)
            self._folder.write_all(small)
            self._folder.flush()
            self._publish(frames, self._pending[-1]["diagnostics/state_hash"])
        self._committed, self._pending = frames, []
        self._last_commit = time.monotonic()

    def close(self) -> None:
        """Commit, and let others write.

        Raises:
            CacheWriteError: the disk is full, say; earlier frames stay readable.
        """
        try:
            if not self._broken:
                self.commit()
        finally:
            self._lock.release()

    def __enter__(self) -> Self:
        """Return this writer."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _longer(self, name: str) -> zarr.Array[Any]:
        document = self._nodes[name]
        # Only local positions that stand for positions stay off the disk, see `layout.LOCAL`.
        with zarr.config.set({"array.write_empty_chunks": name != layout.LOCAL}):
            memory = StorePath(MemoryStore(self._encoded), name)
            return layout.array(memory, {**document, "shape": [_BEYOND, *document["shape"][1:]]})

    def _rows_of_last_chunk(self, written: Cache | None, name: str, frames: int) -> NDArray[Any]:
        """Rows of the chunk that the next frame goes to: it is written anew with each commit."""
        array = self._arrays[name]
        begun = frames % array.chunks[0]
        if begun == 0 or written is None:
            return np.empty((0, *array.shape[1:]), array.dtype)
        return written.rows(name, frames - begun, frames)

    def _encoded_rows(self, name: str, frames: int) -> dict[str, bytes]:
        """The chunks that hold what was appended to an array, by the names of their files."""
        array = self._arrays[name]
        rows = np.concatenate([self._begun[name], np.stack([row[name] for row in self._pending])])
        array[frames - len(rows) : frames] = rows
        files = {key: content.to_bytes() for key, content in self._encoded.items()}
        self._encoded.clear()
        self._begun[name] = rows[len(rows) - frames % array.chunks[0] :].copy()
        return files

    def _publish(self, frames: int, state_hash: int) -> None:
        for name in self._arrays:
            self._nodes[name]["shape"][0] = frames
            self._folder.write(f"{name}/{metadata.FILE}", json.dumps(self._nodes[name]).encode())
        self._document["attributes"]["state_hash"] = f"{state_hash:016x}"
        self._folder.write(metadata.FILE, metadata.encoded(self._document))
        self._folder.flush()

    def _forget_from(self, frames: int, cache: Cache) -> None:
        self.notes.append(
            f"{self._path}: frames {frames} to {cache.frames - 1} were damaged and are simulated again"
        )
        with self._writing():
            self._publish(frames, int(cache.diagnostics["state_hash"][frames - 1]))

    @contextmanager
    def _writing(self) -> Iterator[None]:
        last = self._committed - 1
        kept = f"frames 0 to {last} are kept: go on with --resume" if last >= 0 else _NOTHING_LEFT
        try:
            with _explained(self._path, kept):
                yield
        except CacheWriteError:
            self._broken = True
            raise


def _numbers(frame: Frame, cloths: int) -> dict[str, Any]:
    """What a frame adds to each of :data:`taut.cache.layout.GROWING`; copied, for the arrays may be views."""
    own = {"ms": frame.ms, "state_hash": int(frame.state_hash, 16)}
    numbers: dict[str, Any] = {"time": np.float64(frame.report.time)}
    for name, kind in layout.DIAGNOSTICS.items():
        number = own[name] if name in own else getattr(frame.report, name)
        numbers[f"diagnostics/{name}"] = np.dtype(kind).type(number)
    names = layout.STATE if frame.past is None else (*layout.STATE, layout.PAST)
    numbers |= {name: np.array(getattr(frame, name), np.float32) for name in names}
    if frame.bodies is not None:
        numbers[layout.BODY_POSITIONS] = np.array(frame.bodies, np.float32)
    same = frame.local_positions is None
    local = np.full_like(frame.positions, np.nan) if same else frame.local_positions
    origins = np.zeros((cloths, 3)) if frame.origins is None else frame.origins
    return numbers | {layout.LOCAL: np.array(local), layout.ORIGINS: np.array(origins)}


@contextmanager
def _explained(path: Path, consequence: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        # A disk takes only so many files, too.
        remedy = "; free some space or delete some files" if full else ""
        reason = error.strerror or str(error)
        raise CacheWriteError(
            f"cannot write {error.filename or path}: {reason}{remedy}; {consequence}"
        ) from error
