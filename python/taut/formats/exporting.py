"""Export frames to a format by its name."""

from collections.abc import Callable
from pathlib import Path

from taut.formats.obj_writer import export_obj
from taut.formats.pc2 import export_pc2
from taut.formats.ply_writer import export_ply
from taut.formats.writing import ExportError
from taut.frames import Frames, Progress

EXPORTERS: dict[str, Callable[[Frames, Path, bool, Progress | None], None]] = {
    "obj": export_obj,
    "pc2": export_pc2,
    "ply": export_ply,
}
"""The formats that :func:`export` knows, by name; each is called with frames, out, overwrite, progress."""


def export(
    frames: Frames, to: str, out: str | Path, *, overwrite: bool = False, progress: Progress | None = None
) -> None:
    """Write every frame in another format; vertices keep their order, coordinates and up axis.

    Args:
        frames: what to export.
        to: one of the :data:`EXPORTERS`: ``obj`` and ``ply`` fill a folder with one file a frame, ``pc2``
            writes one file. Beside ``obj`` files there is ``bodies.obj`` if the scene has bodies, or
            ``bodies_0000.obj`` and so on if they may move; the other formats leave them out.
        out: the folder or file to make.
        overwrite: replace what an earlier export left there.
        progress: told how many frames are done and how many there are.

    Raises:
        ExportError: the format is unknown, ``out`` exists or cannot be written, there is no frame, or a
            position is not finite. Nothing is left behind.
    """
    exporter = EXPORTERS.get(to)
    if exporter is None:
        raise ExportError(f"cannot export to {to!r}: the formats are {', '.join(EXPORTERS)}")
    exporter(frames, Path(out), overwrite, progress)
