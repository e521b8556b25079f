"""One simulation on the stage: cloth, threads, pins, bodies, floor, light and camera."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista as pv
from matplotlib.colors import to_hex
from numpy.typing import NDArray
from PIL import Image

from taut.frames import Frames, links, vertex_stretch
from taut.render.framing import VIEW_ANGLE, Framing, Points
from taut.render.ground import add_ground
from taut.render.options import Color
from taut.render.shadow import Shadow
from taut.render.solids import Solids, cells, cut_at_ground, normals
from taut.render.strain import StrainScale

_FRONT, _BACK, _THREAD, _PIN = "#c2413b", "#ead9b8", "#3b4654", "#2b3440"
_HORIZON, _SKY = "#dde4ea", "#fafbfc"
_FAR = 200.0  # what was thrown off is drawn at most so many radii away


@dataclass(frozen=True)
class Look:
    """What all panels share."""

    color: Color
    strain: StrainScale
    framing: Framing
    size: tuple[int, int]
    """Width and height of a panel of the picture [pixels]."""
    pixels: float
    """Rendered pixels for each pixel of a picture 720 pixels high: lines and dots grow with it."""
    background: str | None
    """Its colour, without a ground; none: sky and ground."""


@dataclass(frozen=True)
class Cast:
    """What throws a shadow in a frame."""

    positions: Points
    """Of the cloth's vertices [m], shape (vertices, 3); NaN where they are not known."""
    solids: list[Points]
    """The points of each body [m]."""


class Panel:
    """One simulation: first what is behind it, then its actors, which move from frame to frame."""

    def __init__(self, plotter: pv.Plotter, frames: Frames, look: Look) -> None:
        """Put light, camera, sky and ground into the plotter's current panel."""
        self._frames, self._look = frames, look
        self._faces = np.asarray(frames.faces)
        self._links = links(frames)
        self._springs = np.asarray(frames.springs)
        self._pinned = np.asarray(getattr(frames, "pins", ()), dtype=np.int64)
        self._has_ground = look.background is None and look.framing.is_above
        if look.background is None:
            plotter.set_background(_HORIZON, top=_SKY)  # type: ignore[arg-type]
        else:
            plotter.set_background(to_hex(look.background))  # type: ignore[arg-type]
        # What is seen through does not need it, and it knows no samples.
        plotter.renderer.SetUseOIT(False)
        _add_lights(plotter, look.framing)
        _set_camera(plotter, look.framing)
        if self._has_ground:
            add_ground(plotter, look.framing)

    def enter(self, plotter: pv.Plotter) -> None:
        """Put the actors into the plotter's current panel, and nothing behind them."""
        plotter.renderer.clear_actors()
        plotter.set_background("black", all_renderers=False)  # type: ignore[arg-type]
        plotter.renderer.SetBackgroundAlpha(0.0)
        points = np.zeros((len(self._frames.positions(0)), 3), dtype=np.float32)
        # What is often in front is drawn first, so that what it hides costs nothing.
        self._cloth = self._add_cloth(plotter, points) if len(self._faces) else None
        self._threads = self._add_threads(plotter, points) if len(self._links) else None
        self._pins = self._add_pins(plotter, points) if len(self._pinned) else None
        self._solids = Solids(plotter, self._frames, self._look.framing, self._has_ground)
        self._shadow = (
            Shadow(self._frames, self._look.framing, self._look.size, self._solids.faces)
            if self._has_ground
            else None
        )

    def show(self, frame: int) -> Cast:
        """Move everything to where it is in a frame; what is not finite is left out."""
        framing = self._look.framing
        positions = np.asarray(self._frames.positions(frame), dtype=np.float64)
        known: NDArray[np.bool_] = np.asarray(np.isfinite(positions).all(axis=1))
        far = _FAR * framing.radius
        positions = (positions - framing.middle).clip(-far, far) + framing.middle
        # Out of sight: behind the camera.
        hidden = 2 * framing.eye - framing.target
        points = np.where(known[:, None], positions, hidden).astype(np.float32)
        if self._cloth is not None:
            self._move_cloth(self._cloth, points, known, frame)
        if self._threads is not None:
            self._move_threads(self._threads, points, known, frame)
        if self._pins is not None:
            self._pins.points = points[self._pinned]
        return Cast(np.where(known[:, None], positions, np.nan), self._solids.show(frame))

    def lay_shadow(self, picture: Image.Image, corner: tuple[int, int], cast: Cast) -> None:
        """Darken the floor below what throws a shadow.

        Args:
            picture: of the floor; it is changed.
            corner: where the left upper corner of the panel is in it [pixels].
            cast: what throws the shadow.
        """
        if self._shadow is not None:
            self._shadow.lay(picture, corner, cast.positions, cast.solids)

    def _move_cloth(
        self, cloth: pv.PolyData, points: NDArray[np.float32], known: NDArray[np.bool_], frame: int
    ) -> None:
        faces = self._faces[known[self._faces].all(axis=1)]
        cloth.points = points
        if len(faces) != cloth.n_cells:
            cloth.faces = cells(faces)
        cloth.point_data["Normals"] = normals(points, faces)
        if self._look.color == "strain":
            cloth.point_data["stretch"] = self._look.strain.share(vertex_stretch(self._frames, frame))

    def _move_threads(
        self, threads: pv.PolyData, points: NDArray[np.float32], known: NDArray[np.bool_], frame: int
    ) -> None:
        shown = self._links[known[self._springs[self._links]].all(axis=1)]
        threads.points = points
        if len(shown) != threads.n_cells:
            threads.cell_data.clear()
            threads.lines = cells(self._springs[shown])
        if self._look.color == "strain":
            threads.cell_data["stretch"] = self._look.strain.share(self._frames.stretch(frame)[shown])

    def _add_cloth(self, plotter: pv.Plotter, points: NDArray[np.float32]) -> pv.PolyData:
        cloth = pv.PolyData(points, faces=cells(self._faces))
        cloth.point_data["Normals"] = np.ones_like(points)
        cloth.point_data.active_normals_name = "Normals"
        if self._look.color == "strain":
            cloth.point_data["stretch"] = np.zeros(len(points), dtype=np.float32)
            style = self._heat_map() | {"ambient": 0.5, "diffuse": 0.82, "specular": 0.04}
        else:
            style = {"ambient": 0.27, "diffuse": 1.0, "specular": 0.1, "specular_power": 14}
            style |= {"color": _FRONT, "backface_params": {"color": _BACK, **style}}
        actor = plotter.add_mesh(cloth, **style)
        actor.prop.interpolation = "phong"
        if self._has_ground:
            cut_at_ground(actor, self._look.framing)
        return cloth

    def _add_threads(self, plotter: pv.Plotter, points: NDArray[np.float32]) -> pv.PolyData:
        threads = pv.PolyData(points, lines=cells(self._springs[self._links]))
        style: dict[str, Any] = {"line_width": 4 * self._look.pixels, "render_lines_as_tubes": True}
        if self._look.color == "strain":
            threads.cell_data["stretch"] = np.zeros(len(self._links), dtype=np.float32)
            style |= self._heat_map() | {"ambient": 0.3}
        else:
            style |= {"color": _THREAD}
        plotter.add_mesh(threads, **style)
        return threads

    def _add_pins(self, plotter: pv.Plotter, points: NDArray[np.float32]) -> pv.PolyData:
        pins = pv.PolyData(points[self._pinned])
        size = self._look.pixels * float(np.interp(len(self._pinned), [2, 60], [13, 6]))
        plotter.add_mesh(pins, color=_PIN, ambient=0.4, point_size=size, render_points_as_spheres=True)
        return pins

    def _heat_map(self) -> dict[str, Any]:
        table = pv.LookupTable(values=self._look.strain.colors(), scalar_range=self._look.strain.shares)
        # Colours are looked up for each pixel: blending the colours of two vertices would invent others.
        return {
            "scalars": "stretch",
            "cmap": table,
            "interpolate_before_map": True,
            "show_scalar_bar": False,
        }


def _add_lights(plotter: pv.Plotter, framing: Framing) -> None:
    """A key light where the shadow says that it stands, a cool fill from the viewer, a light from behind."""
    right, away, up = framing.right, framing.away, framing.up
    for direction, intensity, color in (
        (-0.7 * right - 0.9 * away + 0.9 * up, 0.85, "#fff8ee"),
        (1.0 * right - 0.4 * away + 0.2 * up, 0.28, "#e3eeff"),
        (0.2 * right + 1.0 * away + 0.6 * up, 0.35, "#ffffff"),
    ):
        light = pv.Light(light_type="scene light", intensity=intensity, color=color)
        light.positional = False
        light.position, light.focal_point = tuple(framing.target + direction), tuple(framing.target)
        plotter.add_light(light, only_active=True)


def _set_camera(plotter: pv.Plotter, framing: Framing) -> None:
    camera = plotter.camera
    camera.position, camera.focal_point = tuple(framing.eye), tuple(framing.target)
    camera.up, camera.view_angle = tuple(framing.up), VIEW_ANGLE
    camera.clipping_range = framing.clipping
    plotter.camera_set = True
