"""PC2 point caches: all positions of all frames in one file, for Blender's Mesh Cache and others."""

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.formats.polygons import MeshError
from taut.formats.writing import ExportError, checked_frames
from taut.frames import Frames, Progress
from taut.output import whole_file

# Little-endian: signature, version, points, start [frames], sampling [frames per sample], samples.
_HEAD = struct.Struct("<12siiffi")
_SIGNATURE = b"POINTCACHE2\0"


def export_pc2(frames: Frames, out: Path, overwrite: bool, progress: Progress | None) -> None:
    """Write the positions of all frames to the file ``out``, vertices in their order.

    Start and sampling count frames, as is the custom: 0 and 1. The format has float32 only, which tells
    places 100 km from the origin 8 mm apart.

    Raises:
        ExportError: see :func:`taut.formats.export`.
    """
    with whole_file(out, overwrite, ExportError) as part, part.open("wb") as file:
        for frame, positions in checked_frames(frames, progress):
            if frame == 0:
                file.write(_HEAD.pack(_SIGNATURE, 1, len(positions), 0.0, 1.0, frames.frames))
            file.write(positions.astype("<f4", copy=False).tobytes())


def read_pc2(path: str | Path) -> tuple[float, float, NDArray[np.float32]]:
    """Read a PC2 file: start [frames], sampling [frames per sample], positions, shape (samples, points, 3).

    Raises:
        MeshError: the file cannot be opened, is no PC2 file, or is not as long as its header says.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise MeshError(f"{path}: cannot be opened: {error.strerror or error}") from error
    if len(data) < _HEAD.size or not data.startswith(_SIGNATURE):
        raise MeshError(f"{path}: is not a PC2 file (it must begin with `POINTCACHE2`)")
    _, version, points, start, sampling, samples = _HEAD.unpack_from(data)
    if version != 1 or points < 0 or samples < 0:
        counts = f"version {version}, {points} points, {samples} samples"
        raise MeshError(f"{path}: has a damaged PC2 header: {counts}")
    needed = _HEAD.size + 12 * points * samples
    if len(data) != needed:
        raise MeshError(f"{path}: has {len(data)} bytes, its header promises {needed}; write it again")
    positions = np.frombuffer(data, dtype="<f4", offset=_HEAD.size).reshape(samples, points, 3)
    return start, sampling, positions
