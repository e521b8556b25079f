"""What `taut new` starts with: small scenes to change, one of them round a mesh of the user's."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.scene.meshes import resolve_path

_FLAT = 0.01
"""A mesh lower than this part of its breadth lies level [1]."""


def flag(title: str) -> dict[str, Any]:
    """A flag on its pole in the wind."""
    return {
        "title": title,
        "duration": 5.0,
        "wind": {"velocity": [8.0, 1.5, 0.0], "gust": {"strength": 0.3, "period": 1.7, "seed": 1}},
        "cloth": [
            {
                "name": "flag",
                "grid": {
                    "size": [1.5, 1.0],
                    "cells": [48, 32],
                    "origin": [0.0, 0.0, 1.0],
                    "axes": ["x", "z"],
                },
                "fabric": "nylon",
                "strain_limit": 0.05,
                "bending": "fabric",
                "pins": [{"edge": "left"}],
            }
        ],
    }


def hanging(title: str) -> dict[str, Any]:
    """A level cloth that is held by two corners and let go."""
    return {
        "title": title,
        "duration": 5.0,
        "cloth": [
            {
                "name": "sheet",
                "grid": {
                    "size": [1.0, 1.0],
                    "cells": [32, 32],
                    "origin": [0.0, 0.0, 1.5],
                    "axes": ["x", "y"],
                },
                "fabric": "cotton",
                "strain_limit": 0.05,
                "bending": "fabric",
                "pins": [{"corner": "top-left"}, {"corner": "top-right"}],
            }
        ],
    }


KINDS = {"flag": flag, "hanging": hanging}
"""What there is to choose from."""


def around_mesh(title: str, mesh: str, folder: Path, up: str) -> dict[str, Any]:
    """A mesh held where it is highest, or by two corners if it lies level, in a breeze.

    Args:
        title: of the scene.
        mesh: path of the mesh, from `folder`.
        folder: where the scene will lie.
        up: ``"y"`` or ``"z"``, the axis that points up in the mesh.

    Raises:
        SceneError: the mesh is missing.
        MeshError: it cannot be read.
    """
    from taut.formats import read_mesh

    vertices = read_mesh(resolve_path(mesh, folder, "--mesh")).vertices
    # Its pressure stays below the weight of cotton: what hangs sways, and is not blown inside out.
    breeze = [0.8, 0.4, 0.0] if up == "z" else [0.8, 0.0, 0.4]
    cloth = {"name": Path(mesh).stem, "mesh": mesh, "fabric": "cotton", "strain_limit": 0.05}
    cloth["bending"] = "fabric"
    scene: dict[str, Any] = {"title": title, "duration": 5.0, "up": up, "wind": {"velocity": breeze}}
    scene["wind"]["gust"] = {"strength": 0.3, "period": 1.7, "seed": 1}
    return scene | {"cloth": [cloth | {"pins": _pins(vertices, "xyz".index(up))}]}


def _pins(vertices: NDArray[np.float64], up: int) -> list[dict[str, Any]]:
    """Hold the highest hundredth of a mesh, or the ends of the far side of one that lies level."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = high - low
    margin = _FLAT * float(size.max())
    if size[up] > margin:
        bottom, top = low - margin, high + margin
        bottom[up] = high[up] - margin
        return [{"box": [_rounded(bottom, margin), _rounded(top, margin)]}]
    across = 3 - up  # y where z is up, z where y is
    ends = [high.copy(), high.copy()]
    ends[0][0] = low[0]
    for end in ends:
        end[across] = high[across]
    return [{"nearest": _rounded(end, margin)} for end in ends]


def _rounded(point: NDArray[np.float64], margin: float) -> list[float]:
    """Few digits, still well within the margin."""
    digits = max(0, 2 - int(np.floor(np.log10(margin)))) if margin > 0 else 3
    return [round(float(number), digits) for number in point]
