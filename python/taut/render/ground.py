"""The floor: a disc that fades out, grid lines, and the soft shadow of what hangs above."""

from collections.abc import Callable, Sequence

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from taut.frames import Frames, links
from taut.render.framing import Framing, Points

_TEXELS = 384
_BLUR = 3.0  # [texels]
_FLOOR = np.array([228, 232, 236], dtype=np.float64)
_SHADE = np.array([92, 102, 116], dtype=np.float64)
_LINE = (168, 178, 190)
_LINE_WIDTH = 0.0011  # half, in half sides of the floor
_LIFT = 2e-4  # of the lines above the floor, in half sides: cloth may lie on it
_EXTENT = 2.6  # of the floor, in radii of the motion
_MOST_SAMPLES = 300_000


class Ground:
    """The floor of one panel."""

    def __init__(
        self, plotter: pv.Plotter, frames: Frames, framing: Framing, solids: Sequence[NDArray[np.int32]] = ()
    ) -> None:
        """Add the floor to the plotter's current panel.

        Args:
            plotter: where.
            frames: what hangs above it.
            framing: where it lies.
            solids: triangles of each body that throws a shadow, too.
        """
        self._framing = framing
        self._half = _EXTENT * framing.radius
        texel = self._half * 2 / _TEXELS
        sides = np.asarray(frames.rest_length, dtype=np.float64)
        side = float(np.percentile(sides, 90)) if sides.size else 0.0
        self._cast = _Caster(np.asarray(frames.faces), np.asarray(frames.springs)[links(frames)], side, texel)
        self._solids = [_SolidShadow(faces, texel) for faces in solids]
        self._image = pv.ImageData(dimensions=(_TEXELS, _TEXELS, 1))
        self._image.point_data["rgba"] = np.zeros((_TEXELS**2, 4), dtype=np.uint8)
        steps = (np.arange(_TEXELS) + 0.5) / _TEXELS * 2 - 1
        self._fade = _fade(np.hypot(*np.meshgrid(steps, steps))).reshape(-1)
        self._texture = pv.Texture(self._image)  # type: ignore[no-untyped-call]
        plotter.add_mesh(self._floor(), texture=self._texture, lighting=False)
        plotter.add_mesh(self._lines(), scalars="rgba", rgba=True, lighting=False)

    def show(self, positions: Points, solids: Sequence[Points] = ()) -> None:
        """Throw the shadow of what is above.

        Args:
            positions: of the cloth's vertices [m], shape (vertices, 3); NaN: no shadow.
            solids: the points of each body [m].
        """
        cover = self._cover(*self._cast.samples(positions))
        for solid, points in zip(self._solids, solids, strict=True):
            cover = cover + solid.cover(points, self._cover)
        density = cover / (2 * self._half / _TEXELS) ** 2
        dark = 1 - np.exp(-2 * density.reshape(_TEXELS, _TEXELS))
        picture = Image.fromarray((255 * dark).astype(np.uint8)).filter(ImageFilter.GaussianBlur(_BLUR))
        shade = np.asarray(picture).reshape(-1, 1) / 255 * 0.6
        rgba = np.concatenate([_FLOOR + (_SHADE - _FLOOR) * shade, 255 * self._fade[:, None]], axis=1)
        self._image.point_data["rgba"] = rgba.astype(np.uint8)
        self._texture.Modified()

    def _cover(self, points: Points, areas: NDArray[np.float64]) -> NDArray[np.float64]:
        """The area of what throws its shadow on each texel [m^2]; what is below the floor throws none."""
        framing = self._framing
        above = points @ framing.up >= framing.ground - 1e-3 * self._half
        points, areas = points[above], areas[above]
        flat = framing.shadow(points) - framing.middle
        texels = (np.stack([flat @ framing.right, flat @ framing.away]) / self._half + 1) * (_TEXELS / 2)
        inside = ((texels >= 0) & (texels < _TEXELS)).all(axis=0)
        column, row = texels[:, inside].astype(np.int64)
        texel = row * _TEXELS + column
        return np.bincount(texel, areas[inside], _TEXELS**2).astype(np.float64)

    def _place(self, across: NDArray[np.floating], along: NDArray[np.floating], lift: float) -> Points:
        framing = self._framing
        flat = np.multiply.outer(across, framing.right) + np.multiply.outer(along, framing.away)
        place: Points = framing.middle + flat + lift * framing.up
        return place

    def _floor(self) -> pv.PolyData:
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
        floor = pv.PolyData(
            self._place(corners[:, 0] * self._half, corners[:, 1] * self._half, 0.0), faces=[4, 0, 1, 2, 3]
        )
        floor.active_texture_coordinates = (corners + 1) / 2
        return floor

    def _lines(self) -> pv.PolyData:
        """Grid lines at round distances from the world's origin: ribbons, in pieces so that they can fade."""
        framing, half = self._framing, self._half
        spacing = _round_down(framing.radius / 3.5)
        pieces, width = np.linspace(-half, half, 65), np.array([-1.0, 1.0]) * _LINE_WIDTH * half
        ribbons: list[Points] = []
        for direction in (framing.right, framing.away):
            offset = float(framing.middle @ direction)
            first, last = np.ceil((offset - half) / spacing), np.floor((offset + half) / spacing)
            for step in np.arange(first, last + 1) * spacing - offset:
                across, along = np.meshgrid(step + width, pieces)
                if direction is framing.away:
                    across, along = along, across
                ribbons.append(self._place(across, along, _LIFT * half).reshape(-1, 3))
        points = np.concatenate(ribbons)
        left = (
            np.arange(len(ribbons))[:, None] * 2 * len(pieces) + np.arange(0, 2 * len(pieces) - 2, 2)
        ).ravel()
        quads = np.stack([np.full_like(left, 4), left, left + 1, left + 3, left + 2], axis=1)
        lines = pv.PolyData(points, faces=quads.ravel())
        away = np.linalg.norm(points - framing.middle, axis=1) / half
        color = np.broadcast_to(_LINE, (len(away), 3))
        lines.point_data["rgba"] = np.concatenate([color, 255 * _fade(away)[:, None]], axis=1).astype(
            np.uint8
        )
        return lines


class _SolidShadow:
    """The shadow of a body, made anew only where it moves."""

    def __init__(self, faces: NDArray[np.int32], texel: float) -> None:
        self._faces, self._texel = faces, texel
        self._cast: _Caster | None = None
        self._points: Points | None = None
        self._last: NDArray[np.float64] = np.zeros(0)

    def cover(
        self, points: Points, cover: Callable[[Points, NDArray[np.float64]], NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """What `cover` says of points spread over the body."""
        if self._cast is None:
            corners = points[self._faces]
            side = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
            self._cast = _Caster(self._faces, np.zeros((0, 2), np.int32), float(side), self._texel)
        if self._points is None or not np.array_equal(points, self._points):
            self._points, self._last = points, cover(*self._cast.samples(points))
        return self._last


class _Caster:
    """Points spread over the cloth, close enough to leave no gaps in its shadow."""

    def __init__(
        self, faces: NDArray[np.int32], threads: NDArray[np.int32], length: float, texel: float
    ) -> None:
        self._faces, self._links, self._texel = faces, threads, texel
        most = max(1, _MOST_SAMPLES // max(1, len(self._faces)))
        count = min(most, max(1, int(np.ceil((1.5 * length / texel) ** 2))))
        # Points of an even sequence in the square, folded into the triangle.
        step = np.arange(count) + 0.5
        u, v = step * 0.7548776662466927 % 1, step * 0.5698402909980532 % 1
        fold = u + v > 1
        self._u, self._v = np.where(fold, 1 - u, u), np.where(fold, 1 - v, v)
        self._steps = np.linspace(0, 1, min(64, max(2, int(np.ceil(2 * length / texel)))))

    def samples(self, positions: Points) -> tuple[Points, NDArray[np.float64]]:
        """Points [m], shape (samples, 3), and the area that each stands for [m^2], shape (samples,)."""
        origin = positions[self._faces[:, 0]]
        first, second = positions[self._faces[:, 1]] - origin, positions[self._faces[:, 2]] - origin
        area = np.linalg.norm(np.cross(first, second), axis=1) / 2
        # In the order of the sequence, then of the triangles.
        sheet = origin + np.multiply.outer(self._u, first) + np.multiply.outer(self._v, second)
        sheet_area = np.tile(area / len(self._u), len(self._u))
        start, end = positions[self._links[:, 0]], positions[self._links[:, 1]]
        thread = start + np.multiply.outer(self._steps, end - start)
        # A thread is drawn about a texel wide.
        length = np.linalg.norm(end - start, axis=1) / len(self._steps)
        thread_area = np.tile(0.7 * self._texel * length, len(self._steps))
        points = np.concatenate([sheet.reshape(-1, 3), thread.reshape(-1, 3)])
        return points, np.concatenate([sheet_area, thread_area])


def _fade(distance: NDArray[np.float64]) -> NDArray[np.float64]:
    """1 in the middle, 0 at the rim, smooth between; distances in half sides of the floor."""
    ramp = np.clip((1 - distance) / 0.65, 0, 1)
    return ramp * ramp * (3 - 2 * ramp)


def _round_down(length: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is not above ``length``."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * max(digit for digit in (1, 2, 5) if digit * power <= length * (1 + 1e-9)))
