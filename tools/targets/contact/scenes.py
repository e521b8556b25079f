"""What the scenes about contact are made of: sheets as grids and as irregular meshes, floors, bodies."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from taut import Scene, Simulation
from taut.bench.meshes import irregular_sheet

Fields = dict[str, Any]
FLOOR: Fields = {"name": "floor", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
SKIN = 0.001
"""What bodies keep off by themselves, where a scene does not say it [m]."""


@dataclass(slots=True)
class Stage:
    """A scene in the making: its fields, and the arrays that they name."""

    document: Fields = field(default_factory=dict)
    meshes: dict[str, tuple[ArrayLike, ArrayLike]] = field(default_factory=dict)
    paths: dict[str, ArrayLike] = field(default_factory=dict)

    def body(self, *bodies: Fields) -> "Stage":
        """With further bodies."""
        self.document.setdefault("body", []).extend(bodies)
        return self

    def cloth(self, name: str, **fields: Any) -> "Stage":
        """With another cloth; a `mesh` is given by its arrays."""
        if "mesh" in fields:
            self.meshes[name] = fields["mesh"]
            fields["mesh"] = name
        self.document.setdefault("cloth", []).append(fields | {"name": name})
        return self

    def simulation(self, threads: int = 2, without: tuple[str, ...] = (), **document: Any) -> Simulation:
        """At its start, with some fields of the scene set and some left out."""
        given = {name: value for name, value in (self.document | document).items() if name not in without}
        return Simulation(Scene(given, self.meshes, paths=self.paths), threads)


def sheet(across: int, size: tuple[float, float] | float = 1.0, mesh: bool = False, seed: int = 1) -> Fields:
    """Fields of a level rectangle, or square, round the origin with so many vertices along each side."""
    width, height = size if isinstance(size, tuple) else (size, size)
    if not mesh:
        corner = [-width / 2, -height / 2, 0.0]
        cells = [across - 1] * 2
        return {"grid": {"size": [width, height], "cells": cells, "origin": corner, "axes": ["x", "y"]}}
    vertices, faces = irregular_sheet((across - 1, across - 1), (width, height), seed)
    return {"mesh": (vertices - [width / 2, height / 2, 0.0], faces)}


def ball(center: ArrayLike, radius: float, **fields: Any) -> Fields:
    """A ball."""
    return {"name": "ball", "sphere": {"center": np.asarray(center).tolist(), "radius": radius}} | fields


def corner_up(center: ArrayLike, side: float, **fields: Any) -> Fields:
    """A cube that stands on one corner, another one up."""
    turned = [45.0, -float(np.degrees(np.arctan(np.sqrt(0.5)))), 0.0]
    cube = {"center": np.asarray(center).tolist(), "size": [side] * 3, "rotate": turned}
    return {"name": "box", "box": cube} | fields


def keyframes(times: ArrayLike, values: ArrayLike) -> list[Any]:
    """As scenes have them."""
    return [list(pair) for pair in zip(np.asarray(times).tolist(), np.asarray(values).tolist(), strict=True)]


def kind(mesh: bool) -> str:
    """For names of cases."""
    return "mesh" if mesh else "grid"
