"""What the head of a mesh file promises, compared with what the file can hold at all.

A general reader takes a truncated text file for a smaller mesh, and a hostile glTF for an invitation to
allocate; these checks come before it.
"""

import json
import re
from typing import Any

from taut.formats.polygons import MeshError

_GLB_HEAD = 20  # magic, version, length; then length and kind of the first chunk, which is JSON


def declared_counts(extension: str, data: bytes) -> tuple[int, int] | None:
    """Return how many vertices and faces a PLY or OFF file declares (others: ``None``).

    Raises:
        MeshError: there is no such declaration, or a text file has fewer lines than it needs.
    """
    if extension == "ply":
        return _declared_ply(data)
    if extension == "off":
        return _declared_off(data)
    return None


def _declared_ply(data: bytes) -> tuple[int, int]:
    head, separator, body = data.partition(b"end_header")
    if not head.startswith(b"ply") or not separator:
        raise MeshError("has no PLY header (`ply` .. `end_header`)")
    elements = re.findall(rb"^element\s+(\w+)\s+(\d+)\s*$", head, re.MULTILINE)
    counts = {name: int(count) for name, count in elements}
    if re.search(rb"^format\s+ascii", head, re.MULTILINE):
        _check_lines(body, sum(counts.values()))
    return counts.get(b"vertex", 0), counts.get(b"face", 0)


def _declared_off(data: bytes) -> tuple[int, int]:
    text = re.sub(rb"#[^\r\n]*", b"", data)
    found = re.search(rb"OFF\s+(\d+)\s+(\d+)[^\r\n]*", text)
    if not found:
        raise MeshError("has no OFF header (`OFF`, then the numbers of vertices, faces and edges)")
    vertices, faces = int(found[1]), int(found[2])
    _check_lines(text[found.end() :], vertices + faces)
    return vertices, faces


def _check_lines(body: bytes, needed: int) -> None:
    """Each vertex and each face of a text file is one line."""
    present = sum(1 for line in body.splitlines() if line.strip())
    if present < needed:
        raise MeshError(f"is cut short: its header declares {needed} lines, there are {present}")


def check_gltf(extension: str, data: bytes) -> None:
    """Refuse a glTF file that declares more numbers than it has bytes.

    Raises:
        MeshError: so it is, or the file is no glTF.
    """
    text = data
    if extension == "glb":
        if data[:4] != b"glTF":
            raise MeshError("is not a binary glTF file")
        text = data[_GLB_HEAD : _GLB_HEAD + int.from_bytes(data[12:16], "little")]
    try:
        document: Any = json.loads(text)
        counts = [accessor["count"] for accessor in document.get("accessors", [])]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise MeshError(f"its JSON is damaged ({type(error).__name__})") from error
    if not all(isinstance(count, int) and count >= 0 for count in counts) or sum(counts) > len(data):
        raise MeshError(f"declares more numbers than its {len(data)} bytes can hold")
