"""Which boxes overlap: boxes are sorted into the cells of a grid, and those of one cell are looked at."""

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
Indices = NDArray[np.int64]
Boxes = tuple[Numbers, Numbers]
"""Lowest and highest corners [m], each of shape (n, 3)."""


def boxes_of(corners: Indices, *moments: Numbers) -> Boxes:
    """Boxes around features at all moments.

    Args:
        corners: vertices of each feature, shape (n, k).
        moments: places of all vertices [m], each of shape (vertices, 3).
    """
    lows = [places[corners].min(axis=1) for places in moments]
    highs = [places[corners].max(axis=1) for places in moments]
    return np.minimum.reduce(lows), np.maximum.reduce(highs)


def overlapping(first: Boxes, second: Boxes) -> tuple[Indices, Indices]:
    """Pairs of a box of the first kind and one of the second that overlap or touch.

    Returns:
        Indices into both kinds, each of shape (pairs,); every pair once.
    """
    nothing = np.zeros(0, np.int64)
    if not len(first[0]) or not len(second[0]):
        return nothing, nothing
    low = np.maximum(first[0].min(axis=0), second[0].min(axis=0))
    high = np.minimum(first[1].max(axis=0), second[1].max(axis=0))
    if (low > high).any():
        return nothing, nothing
    # Large triangles of bodies shall not make the cells large, so that medians count.
    sides = [float(np.median((box[1] - box[0]).max(axis=1))) for box in (first, second)]
    cell = max(*sides, 1e-3 * float((high - low).max()), 1e-30)
    counts = np.floor((high - low) / cell).astype(np.int64) + 1
    keys, owners, lows = zip(*(_cells(box, low, high, cell, counts) for box in (first, second)), strict=True)
    order = np.argsort(keys[1], kind="stable")
    sorted_keys, sorted_owners = keys[1][order], owners[1][order]
    begin = np.searchsorted(sorted_keys, keys[0], "left")
    many = np.searchsorted(sorted_keys, keys[0], "right") - begin
    here = np.repeat(np.arange(len(many)), many)
    there = begin[here] + np.arange(len(here)) - np.repeat(np.cumsum(many) - many, many)
    a, b = owners[0][here], sorted_owners[there]
    # Two boxes share many cells; the pair counts in the lowest of them.
    lowest = np.maximum(lows[0][a], lows[1][b])
    once = keys[0][here] == (lowest[:, 0] * counts[1] + lowest[:, 1]) * counts[2] + lowest[:, 2]
    a, b = a[once], b[once]
    for axis in range(3):  # one axis after the other: the first leaves few
        meet = (first[0][a, axis] <= second[1][b, axis]) & (second[0][b, axis] <= first[1][a, axis])
        a, b = a[meet], b[meet]
    return a, b


def _cells(
    boxes: Boxes, low: Numbers, high: Numbers, cell: float, counts: Indices
) -> tuple[Indices, Indices, Indices]:
    """Keys of all cells that boxes reach into, the box of each, and the lowest cell of each box."""
    inside = np.flatnonzero((boxes[0] <= high).all(axis=1) & (boxes[1] >= low).all(axis=1))
    begin, end = (
        np.clip(np.floor((corner - low) / cell).astype(np.int64), 0, counts - 1) for corner in boxes
    )
    size = (end - begin + 1)[inside]
    many = size.prod(axis=1)
    row = np.repeat(np.arange(len(inside)), many)
    place = np.arange(len(row)) - np.repeat(np.cumsum(many) - many, many)
    size, start = size[row], begin[inside][row]
    z = place % size[:, 2]
    y = place // size[:, 2] % size[:, 1]
    x = place // (size[:, 2] * size[:, 1])
    keys = ((start[:, 0] + x) * counts[1] + start[:, 1] + y) * counts[2] + start[:, 2] + z
    return keys, inside[row], begin
