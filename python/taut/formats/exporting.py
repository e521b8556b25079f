"""Export frames to a format by its name."""

from collections.abc import Callable, Mapping
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
    frames: Frames,
    to: str,
    out: str | Path,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
    like: Mapping[str, str | Path] | None = None,
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
        like: of ``obj``, for names of cloths the OBJ files that they were made of: their texture coordinates,
            groups, materials and faces (of any number of corners) are written again, and their normals where
            the cloth is.

    Raises:
        ExportError: the format is unknown, ``out`` exists or cannot be written, there is no frame, or a
            position is not finite; a file of `like` does not fit. Nothing is left behind.
        MeshError: a file of `like` cannot be read.
    """
    exporter = EXPORTERS.get(to)
    if exporter is None:
        raise ExportError(f"cannot export to {to!r}: the formats are {', '.join(EXPORTERS)}")
    if like:
        if to != "obj":
            raise ExportError(f"like: is for obj files, {to} has no place for groups and texture coordinates")
        own = {name: Path(path) for name, path in like.items()}
        return export_obj(frames, Path(out), overwrite, progress, own)
    exporter(frames, Path(out), overwrite, progress)
