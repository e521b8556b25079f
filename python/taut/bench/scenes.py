"""What is measured: scenes of any size, built from the same fields as scene files."""

import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.scene import Scene
from taut.simulation import Simulation

SCENES = ("one-corner", "two-corners", "heavy-tip", "flag", "mesh")
"""Names of the scenes; two are like the one-corner drop: `heavy-tip` has the mass of the sheet once more at
its free corner, `mesh` is an irregular mesh that was imported from a file."""

_PINS: dict[str, list[dict[str, Any]]] = {
    "one-corner": [{"corner": "bottom-left"}],
    "two-corners": [{"corner": "bottom-left"}, {"corner": "top-left"}],
    "heavy-tip": [{"corner": "bottom-left"}],
    "flag": [{"edge": "left"}],
}


_WEIGHTS: dict[str, list[dict[str, Any]]] = {"heavy-tip": [{"corner": "top-right", "mass": 0.2}]}


@dataclass(frozen=True, slots=True)
class Case:
    """A scene at a size."""

    scene: str
    """One of :data:`SCENES`."""
    cells: int
    """Cells along the shorter side [1]; one particle more. A mesh has as many vertices as that grid."""
    strain_limit: float
    """Lambda [1]."""
    threads: int = 1
    """Worker threads [1]."""

    def simulation(self, solver: dict[str, Any] | None = None, fps: float = 60.0) -> Simulation:
        """Return the scene at its start.

        Args:
            solver: fields of the scene's solver; the defaults when left out.
            fps: frames per second [1/s].

        Raises:
            SceneError: the size or the strain limit is out of range.
        """
        document: dict[str, Any] = {"title": self.scene, "fps": fps, "solver": solver or {}}
        if self.scene == "mesh":
            return self._from_file(document)
        if self.scene == "flag":
            gust = {"strength": 0.3, "period": 1.7, "seed": 1}
            document["wind"] = {"velocity": [8.0, 1.5, 0.0], "gust": gust}
            grid = {"size": [1.5, 1.0], "cells": [self.cells * 3 // 2, self.cells], "axes": ["x", "z"]}
            document["cloth"] = [self._cloth(grid=grid, fabric="nylon", pins=_PINS["flag"])]
        else:
            grid = {"size": [1.0, 1.0], "cells": [self.cells, self.cells], "axes": ["x", "y"]}
            held = {"pins": _PINS[self.scene], "weights": _WEIGHTS.get(self.scene, [])}
            document["cloth"] = [self._cloth(grid=grid, fabric="cotton", **held)]
        return Simulation(Scene(document), self.threads)

    def _from_file(self, document: dict[str, Any]) -> Simulation:
        """The mesh goes through a file, as a user's would."""
        vertices, faces = irregular_square(self.cells)
        corner = int(np.argmin(vertices.sum(axis=1)))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "square.obj"
            lines = ("v %.9g %.9g %.9g\n" * len(vertices)) % tuple(vertices.ravel())
            path.write_text(lines + ("f %d %d %d\n" * len(faces)) % tuple((faces + 1).ravel()))
            pins = [{"vertices": [corner]}]
            document["cloth"] = [self._cloth(mesh=path.name, fabric="cotton", pins=pins)]
            return Simulation(Scene(document, folder=folder), self.threads)

    def _cloth(self, **fields: Any) -> dict[str, Any]:
        return {"name": "cloth", "density": 0.2, "strain_limit": self.strain_limit, **fields}


def plan(
    scenes: Iterable[str],
    cells: Iterable[int],
    mesh_cells: Iterable[int],
    strain_limits: Iterable[float],
    threads: Iterable[int],
) -> list[Case]:
    """Return every combination; after a mesh comes the drop of a grid with as many vertices.

    Args:
        scenes: some of :data:`SCENES`.
        cells: sizes of the grids.
        mesh_cells: sizes of the meshes and of the grids beside them.
        strain_limits: lambda [1].
        threads: worker threads [1].
    """
    kinds = []
    for scene in scenes:
        if scene == "mesh":
            kinds += [(name, size) for size in mesh_cells for name in ("mesh", "one-corner")]
        else:
            kinds += [(scene, size) for size in cells]
    return [Case(*kind, limit, count) for kind, limit, count in product(kinds, strain_limits, threads)]


def irregular_square(cells: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Triangulate the square of 1 m x 1 m in the plane z = 0 irregularly, the same way each time.

    Points of a grid are moved at random by up to a quarter of their distance, those on the border along it.
    They are joined by a Delaunay triangulation and numbered at random, as meshes from other programs are.

    Args:
        cells: cells of the grid along a side [1].

    Returns:
        Vertices [m], shape ((cells + 1)^2, 3), and triangles, shape (triangles, 3), counter-clockwise.
    """
    from matplotlib.tri import Triangulation

    random = np.random.default_rng(cells)
    grid = np.stack(np.meshgrid(np.arange(cells + 1.0), np.arange(cells + 1.0)), axis=-1)
    inside = (grid > 0) & (grid < cells)  # what may move: along x, along y
    points = ((grid + random.uniform(-0.25, 0.25, grid.shape) * inside) / cells).reshape(-1, 2)
    points = points[random.permutation(len(points))]
    triangulation = Triangulation(points[:, 0], points[:, 1])
    faces = triangulation.triangles[_areas(points, triangulation.triangles) > 1e-4 / cells**2]
    return np.column_stack([points, np.zeros(len(points))]), faces.astype(np.int64)


def _areas(points: NDArray[np.float64], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Areas [m^2]; those along the straight border may be zero."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return 0.5 * np.abs(doubled)
