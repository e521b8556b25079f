"""Polygons become triangles, and triangles that share no vertices get joined."""

import numpy as np

from taut.formats.polygons import Integers, Polygons, Vertices, check_numbers, refusal

MOST_TRIANGLES = 20_000_000
"""More are refused, and more vertices too [1]."""


def cut(name: str, vertices: Vertices, corners: Integers, counts: Integers) -> Polygons:
    """Checked polygons as triangles: first the triangles among them, then halves of quads, then fans.

    Raises:
        MeshError: a number is not finite, an index leads nowhere, or there is too much.
    """
    check_numbers(name, vertices, corners, counts)
    check_size(name, len(vertices), int((counts - 2).sum()))
    first = np.cumsum(counts) - counts
    quads = corners[first[counts == 4, None] + np.arange(4)]
    parts = [
        corners[first[counts == 3, None] + np.arange(3)],
        quads[:, [0, 1, 2]],
        quads[:, [2, 3, 0]],
        _fans(corners, first[counts > 4], counts[counts > 4]),
    ]
    faces = np.concatenate(parts)
    repairs: tuple[str, ...] = ()
    if len(faces) > len(counts):
        was = f"{len(counts)} became {len(faces)}"
        repairs = (f"faces were cut into triangles ({was}); OBJ keeps polygons whole",)
    return Polygons(vertices, faces.ravel(), np.full(len(faces), 3, dtype=np.int64), repairs)


def joined(name: str, vertices: Vertices, faces: Integers, why: str) -> Polygons:
    """Checked triangles, shape (triangles, 3), whose vertices of equal position become one.

    The first of each stays, in order; `why` they were apart is said.

    Raises:
        MeshError: a number is not finite, an index leads nowhere, or there is too much.
    """
    counts = np.full(len(faces), 3, dtype=np.int64)
    check_numbers(name, vertices, faces.ravel(), counts)
    # Adding zero makes -0 and 0 equal.
    _, first, group = np.unique(vertices + 0.0, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    repairs: tuple[str, ...] = ()
    if len(first) < len(vertices):
        repairs = (f"{len(vertices)} vertices were joined into {len(first)} where they coincide: {why}",)
    corners = rank[group.reshape(-1)][faces.ravel()]
    return Polygons(vertices[first[order]], corners, counts, repairs)


def check_size(name: str, vertices: int, triangles: int) -> None:
    """Refuse what is too much for a computer.

    Raises:
        MeshError: so it is.
    """
    for count, what in ((triangles, "triangles"), (vertices, "vertices")):
        if count > MOST_TRIANGLES:
            held = f"holds {count} {what}, at most {MOST_TRIANGLES} can be used"
            raise refusal(name, held, "export a coarser mesh")


def _fans(corners: Integers, first: Integers, counts: Integers) -> Integers:
    """Triangles (0, k, k + 1) of each polygon, shape (triangles, 3)."""
    triangles = counts - 2
    start = np.repeat(first, triangles)
    within = np.arange(len(start)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack([corners[start], corners[start + within + 1], corners[start + within + 2]], axis=-1)
