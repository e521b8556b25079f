"""The bodies of one panel: smooth spheres and capsules, surfaces as they are, planes as large squares."""

from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonDataModel import vtkPlane

from taut.bodies import Body, Skin, quad_of
from taut.frames import Frames, bodies_of
from taut.render.framing import Framing, Points, is_floor

_STONE, _PLANE = "#93a4b5", "#cfd8e0"
_SUNK = 1e-4  # what lies on the ground may be so far below it, in radii of the motion
_REACH = 1.6  # half the side of a plane, in radii of the motion
_STYLE: dict[str, Any] = {
    "ambient": 0.3,
    "diffuse": 0.85,
    "specular": 0.12,
    "specular_power": 18,
    "smooth_shading": False,
}


class Solids:
    """Bodies, moved from frame to frame."""

    def __init__(self, plotter: pv.Plotter, frames: Frames, framing: Framing, has_ground: bool) -> None:
        """Add the bodies of some frames to the plotter's current panel, which may show the ground."""
        self._frames, self._framing, self._has_ground = frames, framing, has_ground
        self._skins: dict[str, tuple[Skin, pv.PolyData]] = {}
        self._planes: dict[str, pv.PolyData] = {}
        for body in bodies_of(frames, 0):
            if body.shape != "plane":
                self._add_solid(plotter, body)
            elif not is_floor(body, framing.up, framing.ground):
                self._add_plane(plotter, body)

    @property
    def faces(self) -> list[NDArray[np.int32]]:
        """Triangles of each body that is no plane, shape (faces, 3)."""
        return [skin.faces for skin, _ in self._skins.values()]

    def show(self, frame: int) -> list[Points]:
        """Move the bodies to where they are in a frame; return the points of each that is no plane [m]."""
        found = []
        for body in bodies_of(self._frames, frame):
            if body.name in self._skins:
                skin, solid = self._skins[body.name]
                found.append(points := skin.points(body))
                moved = points.astype(np.float32)
                if not np.array_equal(moved, solid.points):
                    solid.points = moved
                    solid.point_data["Normals"] = normals(moved, skin.faces)
            elif body.name in self._planes:
                self._planes[body.name].points = self._quad(body)
        return found

    def _add_solid(self, plotter: pv.Plotter, body: Body) -> None:
        skin = Skin(body)
        points = skin.points(body).astype(np.float32)
        if len(skin.faces) == 0:
            return
        solid = pv.PolyData(points, faces=cells(skin.faces))
        solid.point_data["Normals"] = normals(points, skin.faces)
        solid.point_data.active_normals_name = "Normals"
        actor = plotter.add_mesh(solid, color=_STONE, **_STYLE)
        actor.prop.interpolation = "phong"
        if self._has_ground:
            cut_at_ground(actor, self._framing)
        self._skins[body.name] = skin, solid

    def _add_plane(self, plotter: pv.Plotter, body: Body) -> None:
        plane = pv.PolyData(self._quad(body), faces=[4, 0, 1, 2, 3])
        # From behind it would hide what it holds up.
        plotter.add_mesh(plane, color=_PLANE, lighting=False, opacity=0.75, culling="back")
        self._planes[body.name] = plane

    def _quad(self, body: Body) -> NDArray[np.float32]:
        return quad_of(body, self._framing.target, _REACH * self._framing.radius).astype(np.float32)


def cut_at_ground(actor: pv.Actor, framing: Framing) -> None:
    """Leave out what is below the ground, which hides it: the floor is no part of the drawing of a frame."""
    plane = vtkPlane()
    plane.SetOrigin(*((framing.ground - _SUNK * framing.radius) * framing.up))
    plane.SetNormal(*framing.up)
    actor.mapper.AddClippingPlane(plane)


def cells(rows: NDArray[np.integer]) -> NDArray[np.int64]:
    """Cells of equal size as VTK counts them: each row after its length."""
    sizes = np.full((len(rows), 1), rows.shape[1])
    return np.concatenate([sizes, rows], axis=1).astype(np.int64).ravel()


def normals(points: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float32]:
    """Unit normals at the vertices, the faces around each weighted by area; shape (vertices, 3)."""
    corners = points[faces].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = [np.bincount(faces.ravel(), np.repeat(axis, 3), len(points)) for axis in across.T]
    found = np.stack(sums, axis=1)
    lengths = np.linalg.norm(found, axis=1, keepdims=True)
    return np.asarray(found / np.maximum(lengths, 1e-30), dtype=np.float32)
