"""Binary PLY: a folder with one file a frame, the stretch at every vertex included."""

from pathlib import Path

import numpy as np

from taut.formats.writing import Places, write_folder
from taut.frames import Frames, Progress, links, vertex_stretch

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def export_ply(frames: Frames, out: Path, overwrite: bool, progress: Progress | None) -> None:
    """Write one PLY a frame into the folder ``out``: positions, ``stretch``, triangles, links as edges.

    Positions are ``float``, and ``double`` in frames that ``float`` would round far from the origin.
    ``stretch`` of a vertex is the largest |X_uv| / L - 1 of the springs that meet there.

    Raises:
        ExportError: see :func:`taut.formats.export`.
    """
    edges = np.ascontiguousarray(frames.springs[links(frames)], dtype="<i4")
    faces = np.zeros(len(frames.faces), dtype=_FACE)
    faces["count"] = 3
    faces["corners"] = frames.faces
    title = " ".join(frames.title.split()).encode("ascii", "replace").decode()

    def write(stem: Path, frame: int, positions: Places) -> None:
        vertices = np.zeros(len(positions), dtype=[("position", positions.dtype, 3), ("stretch", "<f4")])
        vertices["position"] = positions
        vertices["stretch"] = vertex_stretch(frames, frame)
        kind = "float" if positions.dtype == np.float32 else "double"
        head = _header(f"{title}: frame {frame}", kind, len(vertices), len(faces), len(edges))
        with stem.with_suffix(".ply").open("wb") as file:
            file.write(head.encode("ascii"))
            for block in (vertices, faces, edges):
                file.write(block.tobytes())

    write_folder(frames, out, write, overwrite, progress)


def _header(comment: str, kind: str, vertices: int, faces: int, edges: int) -> str:
    lines = ["ply", "format binary_little_endian 1.0", f"comment {comment}", f"element vertex {vertices}"]
    lines += [f"property {kind} {name}" for name in "xyz"] + ["property float stretch"]
    if faces:
        lines += [f"element face {faces}", "property list uchar int vertex_indices"]
    if edges:
        lines += [f"element edge {edges}", "property int vertex1", "property int vertex2"]
    return "\n".join([*lines, "end_header", ""])
