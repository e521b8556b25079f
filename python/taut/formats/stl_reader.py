"""STL, binary and text: triangles that share no vertices."""

import numpy as np

from taut.formats.polygons import Polygons, Vertices, refusal
from taut.formats.text import lines_of, quoted, reals
from taut.formats.triangles import check_size, joined

_HEAD = 84  # 80 bytes of anything, then the number of triangles
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("vertices", "<f4", (3, 3)), ("attributes", "<u2")])


def read_stl(name: str, data: bytes) -> Polygons:
    """Read an STL file; vertices of equal position are joined.

    Raises:
        MeshError: the file and line, what is wrong there and what is allowed.
    """
    declared = int.from_bytes(data[80:_HEAD], "little")
    needed = _HEAD + declared * _TRIANGLE.itemsize
    if len(data) >= _HEAD and len(data) == needed:
        check_size(name, 3 * declared, declared)
        vertices = np.frombuffer(data, _TRIANGLE, offset=_HEAD)["vertices"].astype(np.float64).reshape(-1, 3)
    elif data[:512].lstrip()[:5].lower() == b"solid" and b"\0" not in data:
        vertices = _read_text(name, data)
    elif len(data) < _HEAD:
        raise refusal(name, f"is cut short: the head of an STL file has {_HEAD} bytes, there are {len(data)}")
    else:
        wrong = f"declares {declared} triangles, which take {needed} bytes, but has {len(data)} bytes"
        raise refusal(name, f"is cut short or damaged: it {wrong}")
    faces = np.arange(len(vertices), dtype=np.int64).reshape(-1, 3)
    return joined(name, vertices, faces, "STL does not share vertices between triangles")


def _read_text(name: str, data: bytes) -> Vertices:
    """The vertices between ``solid`` and ``endsolid``, three for each ``endloop``, whatever else there is."""
    coordinates: list[list[float]] = []
    in_loop, in_solid, number = 0, False, 0
    for number, words in lines_of(data):
        where, word = f"{name}:{number}", words[0].lower()
        if word == "vertex":
            place = reals(words[1:])
            if place is None or len(place) != 3:
                raise refusal(where, f"{quoted(words)}: a vertex must have 3 finite numbers")
            coordinates.append(place)
            in_loop += 1
        elif word in ("endloop", "endfacet", "endsolid"):
            if in_loop != (3 if word == "endloop" else 0):
                raise refusal(
                    where, f"a triangle ends here with {in_loop} vertices: must be 3, and `endloop`"
                )
            in_loop = 0
        if word in ("solid", "endsolid"):
            in_solid = word == "solid"
    if in_solid or in_loop:
        raise refusal(f"{name}:{number}", "is cut short: it ends without `endsolid`")
    return np.array(coordinates, dtype=np.float64).reshape(-1, 3)
