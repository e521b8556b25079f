"""Scenes for judging: grids and irregular meshes of the same cloth, of any size and number of vertices."""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from taut.bench.meshes import (
    CAPE_DROP,
    CAPE_HEM,
    DROP,
    HEM,
    NECK,
    WAIST,
    cape,
    irregular_sheet,
    skirt,
    weighted_net,
)
from taut.bench.shirt import shirt, shoulders
from taut.scene import Scene
from taut.simulation import Simulation

Shape = Literal["grid", "mesh", "quads"]

TRIALS = ("one-corner", "two-corners", "pendulum", "flag", "storm", "skirt", "cape", "shirt", "net")
"""Names of the scenes. A pendulum is a sheet that hangs by its upper edge, first 10 degrees aside. There are
no grids of a shirt and a net; a skirt's and a cape's is a panel with as many vertices that hangs by its upper
edge, at first at the slope of the garment's side."""

_FABRICS = {"flag": "nylon", "storm": "nylon", "cape": "wool"}
_WINDS = {"flag": [8.0, 1.5, 0.0], "storm": [15.0, 3.0, 0.0], "cape": [0.5, -3.0, 0.0]}
_SLENDER = 1.5
"""Length of a flag over its height [1]."""


@dataclass(frozen=True)
class Trial:
    """A scene, on a grid or a mesh."""

    scene: str
    """One of :data:`TRIALS`."""
    vertices: int
    """Of the cloth; of sheets, flags, nets and shirts roughly [1]."""
    strain_limit: float
    """Lambda [1]."""
    shape: Shape = "mesh"
    """Of what it is made."""
    seed: int = 1
    """Of the mesh."""
    size: float = 1.0
    """Length of a side, or the factor on a garment [m]."""
    threads: int = 1
    """Worker threads [1]."""
    cloth: dict[str, Any] = field(default_factory=dict, hash=False)
    """Further fields of the cloth."""
    document: dict[str, Any] = field(default_factory=dict, hash=False)
    """Further fields of the scene."""

    @property
    def across(self) -> int:
        """Vertices along a side of a square grid with as many [1]."""
        return int(np.rint(np.sqrt(self.vertices)))

    @property
    def cells(self) -> int:
        """Cells along a side of a square grid with as many vertices [1]."""
        return self.across - 1

    @property
    def extent(self) -> float:
        """Length by which motion is measured: from where it is held to the far end [m]."""
        if self.scene in ("skirt", "cape"):
            return float(np.hypot(*_slope(self.scene))) * self.size
        if self.scene in ("flag", "storm"):
            return _SLENDER * self.size
        return self.size

    def simulation(self, solver: dict[str, Any] | None = None, fps: float = 60.0) -> Simulation:
        """Return the scene at its start.

        Args:
            solver: fields of the scene's solver; the defaults when left out.
            fps: frames per second [1/s].

        Raises:
            SceneError: the size or the strain limit is out of range.
            ValueError: there is no such scene, or no grid of it.
        """
        if self.scene not in TRIALS or (self.scene in ("shirt", "net") and self.shape == "grid"):
            raise ValueError(f"{self.shape} of {self.scene!r}: must be one of {', '.join(TRIALS)}")
        shape, mesh = self._shape()
        cloth = {
            "name": "cloth",
            "fabric": _FABRICS.get(self.scene, "cotton"),
            "density": 0.2,
            "strain_limit": self.strain_limit,
            "pins": self._pins(),
            **shape,
            **self.cloth,
        }
        if self.scene == "net":
            del cloth["density"]
        given: dict[str, Any] = {"title": self.scene, "fps": fps, "solver": solver or {}, "cloth": [cloth]}
        if self.scene in _WINDS:
            gust = {"strength": 0.3, "period": 1.7, "seed": 1}
            given["wind"] = {"velocity": _WINDS[self.scene], "gust": gust}
        return Simulation(Scene(given | self.document, mesh), self.threads)

    def _shape(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Fields of the cloth that say what it is made of, and the mesh that they name."""
        if self.scene == "net":
            return {"network": weighted_net(self.across, self.size, self.seed), "stiffness": 20.0}, {}
        if self.scene == "shirt":
            return _named(shirt(self.vertices, self.size, self.seed))
        if self.scene in ("skirt", "cape") and self.shape != "grid":
            garment = skirt if self.scene == "skirt" else cape
            return _named(garment(self.vertices, self.size, self.seed))
        cells, size = self._rectangle()
        if self.shape != "grid":
            vertices, faces = irregular_sheet(cells, size, self.seed, quads=self.shape == "quads")
            if self._hangs():
                vertices = vertices - [0.0, size[1], 0.0]
            fields, mesh = _named((vertices, faces))
            # Meshes of sheets lie in the plane of x and y; a flag stands.
            turned = {"rotate": [90.0 + self._aside(), 0.0, 0.0]} if self._stands() else {}
            return fields | turned, mesh
        grid = {"size": size, "cells": cells, "axes": ["x", "z" if self._stands() else "y"]}
        if self._hangs():
            return {"grid": grid | {"origin": [0, 0, -size[1]]}, "rotate": [self._aside(), 0.0, 0.0]}, {}
        return {"grid": grid}, {}

    def _rectangle(self) -> tuple[tuple[int, int], tuple[float, float]]:
        """Cells and size of a sheet, a flag or a panel."""
        if self.scene in ("flag", "storm"):
            along = round(self.across * np.sqrt(_SLENDER))
            return (along - 1, round(self.vertices / along) - 1), (_SLENDER * self.size, self.size)
        if self.scene in ("skirt", "cape"):
            return (self.across - 1, self.across - 1), (self.extent, self.extent)
        return (self.across - 1, self.across - 1), (self.size, self.size)

    def _hangs(self) -> bool:
        """Whether it is a panel that hangs by its upper edge."""
        return self.scene in ("pendulum", "skirt", "cape")

    def _aside(self) -> float:
        """How far a panel is turned away from the vertical at first [degrees]."""
        if self.scene == "pendulum":
            return 10.0
        return float(np.degrees(np.arctan2(*_slope(self.scene)))) if self._hangs() else 0.0

    def _stands(self) -> bool:
        return self.scene not in ("one-corner", "two-corners")

    def _pins(self) -> list[dict[str, Any]]:
        """What holds it, by places: edges and corners have names on grids only."""
        size, thin = self.size, 1e-4 * self.size
        low, high = [-2 * size] * 3, [2 * size] * 3
        corners: list[dict[str, Any]] = [{"nearest": [0.0, 0.0, 0.0]}, {"nearest": [0.0, size, 0.0]}]
        if self.scene == "shirt":
            return [{"box": box} for box in shoulders(size)]
        if self.scene == "one-corner":
            return corners[:1]
        if self.scene in ("two-corners", "net"):
            return corners
        if self.scene in ("flag", "storm"):
            return [{"box": [low, [thin, *high[1:]]]}]
        return [{"box": [[*low[:2], -thin], high]}]


def _slope(scene: str) -> tuple[float, float]:
    """How far a garment's side goes outwards and down [m]."""
    return (HEM - WAIST, DROP) if scene == "skirt" else (CAPE_HEM - NECK, CAPE_DROP)


def _named(mesh: tuple[Any, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    return {"mesh": "cloth"}, {"cloth": mesh}
