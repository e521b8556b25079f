"""The soft shadow that cloth and bodies throw on the floor, laid on the finished picture of the floor."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from taut.frames import Frames, links
from taut.render.framing import Framing, Points
from taut.render.ground import fade, half_side

_TEXELS = 256
_BLUR = 2.0  # [texels]
_MARGIN = 7  # [texels]: so far the blur reaches
_SHADE = (92, 102, 116)
_DARKEST = 0.6
_MOST_SAMPLES = 300_000

Samples = tuple[NDArray[np.float32], NDArray[np.float32]]
"""Places on the floor [texels], shape (2, samples), and the area that each stands for [m^2]."""


class Shadow:
    """What darkens the floor of one panel."""

    def __init__(
        self,
        frames: Frames,
        framing: Framing,
        size: tuple[int, int],
        solids: Sequence[NDArray[np.int32]] = (),
    ) -> None:
        """Prepare what stays the same.

        Args:
            frames: what hangs above the floor.
            framing: where the floor lies, and where the camera stands above it.
            size: width and height of the panel [pixels].
            solids: triangles of each body that throws a shadow, too.
        """
        self._framing, self._size = framing, size
        self._half = half_side(framing)
        texel = self._half * 2 / _TEXELS
        sides = np.asarray(frames.rest_length, dtype=np.float64)
        side = float(np.percentile(sides, 90)) if sides.size else 0.0
        threads = np.asarray(frames.springs)[links(frames)]
        self._cast = _Caster(np.asarray(frames.faces), threads, side, texel)
        self._solids = [_SolidShadow(faces, texel) for faces in solids]
        steps = (np.arange(_TEXELS) + 0.5) / _TEXELS * 2 - 1
        self._strength = (_DARKEST * fade(np.hypot(*np.meshgrid(steps, steps)))).astype(np.float32)
        # What a picture's place (x, y, 1) [pixels] is on the floor, times its third number [texels].
        on_axes = np.stack([framing.right, framing.away, framing.up])
        aside = on_axes @ (framing.eye - framing.middle)
        rays = on_axes @ framing.rays(size)
        floor = np.stack([aside[2] * rays[0] - aside[0] * rays[2], aside[2] * rays[1] - aside[1] * rays[2]])
        scale = _TEXELS / 2 / self._half
        self._to_floor = np.stack([*(scale * floor - _TEXELS / 2 * rays[2]), -rays[2]])

    def lay(
        self, picture: Image.Image, corner: tuple[int, int], positions: Points, solids: Sequence[Points]
    ) -> None:
        """Darken a picture of the floor.

        Args:
            picture: it is changed.
            corner: where the panel's left upper corner is in it [pixels].
            positions: of the cloth's vertices [m], shape (vertices, 3); NaN: no shadow.
            solids: the points of each body [m].
        """
        found = self._shade(positions, solids)
        if found is None:
            return
        shade, left, top = found
        box = self._box(left, top, left + shade.width, top + shade.height)
        if box is None:
            return
        # As Pillow wants it: from pixels of the box to texels of the shade.
        there, here = np.eye(3), np.eye(3)
        here[:2, 2], there[:2, 2] = box[:2], (-left, -top)
        warp = there @ self._to_floor @ here
        seen = shade.transform(
            (box[2] - box[0], box[3] - box[1]),
            Image.Transform.PERSPECTIVE,
            tuple((warp / warp[2, 2]).ravel()[:8]),
            Image.Resampling.BILINEAR,
        )
        picture.paste(_SHADE, (corner[0] + box[0], corner[1] + box[1]), seen)

    def _shade(self, positions: Points, solids: Sequence[Points]) -> tuple[Image.Image, int, int] | None:
        """How dark the floor is where it is, and the first texel of that to the right and away."""
        cover = self._cover(self._cast.samples(positions, self._texels(positions)))
        for solid, points in zip(self._solids, solids, strict=True):
            if solid.is_elsewhere(points):
                solid.cover = self._cover(solid.caster(points).samples(points, self._texels(points)))
            cover = cover + solid.cover
        rows, columns = np.flatnonzero(cover.any(axis=1)), np.flatnonzero(cover.any(axis=0))
        if len(rows) == 0:
            return None
        top, bottom = max(0, int(rows[0]) - _MARGIN), int(rows[-1]) + 1 + _MARGIN
        left, right = max(0, int(columns[0]) - _MARGIN), int(columns[-1]) + 1 + _MARGIN
        part = slice(top, bottom), slice(left, right)
        dark = 1 - np.exp(-2 / (2 * self._half / _TEXELS) ** 2 * cover[part].astype(np.float32))
        soft = Image.fromarray((255 * dark).astype(np.uint8)).filter(ImageFilter.GaussianBlur(_BLUR))
        shade = (np.asarray(soft) * self._strength[part]).astype(np.uint8)
        return Image.fromarray(shade), left, top

    def _box(self, left: int, top: int, right: int, bottom: int) -> tuple[int, int, int, int] | None:
        """The part of the panel where a part of the floor is seen, left, top, right, bottom [pixels]."""
        width, height = self._size
        # The horizon is level, so that the third number depends on the row alone.
        rows = np.flatnonzero(self._to_floor[2, 1] * np.arange(height) + self._to_floor[2, 2] > 0)
        if len(rows) == 0:
            return None
        corners = np.array([[left, right, right, left], [top, top, bottom, bottom], [1, 1, 1, 1]])
        x, y, ahead = np.linalg.solve(self._to_floor, corners)
        first = int(rows[0])
        if (ahead <= 0).any():  # It reaches behind the camera.
            return 0, first, width, height
        x, y = x / ahead, y / ahead
        found = (
            max(0, int(np.floor(x.min()))),
            max(first, int(np.floor(y.min()))),
            min(width, int(np.ceil(x.max()))),
            min(height, int(np.ceil(y.max()))),
        )
        return found if found[0] < found[2] and found[1] < found[3] else None

    def _texels(self, points: Points) -> NDArray[np.float32]:
        """Where points throw their shadow [texels], shape (2, points); NaN for those below the floor."""
        framing = self._framing
        flat = framing.shadow(points) - framing.middle
        texels = (np.stack([flat @ framing.right, flat @ framing.away]) / self._half + 1) * (_TEXELS / 2)
        texels[:, points @ framing.up < framing.ground - 1e-3 * self._half] = np.nan
        return texels.astype(np.float32)

    def _cover(self, samples: Samples) -> NDArray[np.float64]:
        """The area of what throws its shadow on each texel [m^2], shape (texels, texels)."""
        texels, areas = samples
        inside = ((texels >= 0) & (texels < _TEXELS)).all(axis=0)
        column, row = texels[:, inside].astype(np.int64)
        cover = np.bincount(row * _TEXELS + column, areas[inside], _TEXELS**2)
        return cover.reshape(_TEXELS, _TEXELS).astype(np.float64)


class _SolidShadow:
    """The shadow of a body, made anew only where it moves."""

    def __init__(self, faces: NDArray[np.int32], texel: float) -> None:
        self._faces, self._texel = faces, texel
        self._caster: _Caster | None = None
        self._points: Points | None = None
        self.cover: NDArray[np.float64] = np.zeros((_TEXELS, _TEXELS))

    def is_elsewhere(self, points: Points) -> bool:
        """Whether it is not where it was when this was asked before."""
        if self._points is not None and np.array_equal(points, self._points):
            return False
        self._points = points
        return True

    def caster(self, points: Points) -> "_Caster":
        if self._caster is None:
            corners = points[self._faces]
            side = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
            self._caster = _Caster(self._faces, np.zeros((0, 2), np.int32), float(side), self._texel)
        return self._caster


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

    def samples(self, positions: Points, texels: NDArray[np.float32]) -> Samples:
        """Spread points.

        Args:
            positions: of vertices [m], shape (vertices, 3).
            texels: where they throw their shadow, shape (2, vertices).
        """
        a, b, c = self._faces.T
        area = np.linalg.norm(np.cross(positions[b] - positions[a], positions[c] - positions[a]), axis=1) / 2
        # In the order of the sequence, then of the triangles.
        sheet = _spread(texels, a, b, self._u) + _spread(texels, a, c, self._v) - texels[:, None, a]
        sheet_area = np.tile(area / len(self._u), len(self._u))
        start, end = self._links.T
        thread = _spread(texels, start, end, self._steps)
        # A thread is drawn about half a texel wide.
        length = np.linalg.norm(positions[end] - positions[start], axis=1) / len(self._steps)
        thread_area = np.tile(0.47 * self._texel * length, len(self._steps))
        places = np.concatenate([sheet.reshape(2, -1), thread.reshape(2, -1)], axis=1)
        return places, np.concatenate([sheet_area, thread_area]).astype(np.float32)


def _spread(
    texels: NDArray[np.float32], start: NDArray[np.int32], end: NDArray[np.int32], shares: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Places at some shares of the way from one vertex to another, shape (2, shares, pairs)."""
    way = texels[:, end] - texels[:, start]
    places: NDArray[np.float32] = texels[:, None, start] + shares.astype(np.float32)[:, None] * way[:, None]
    return places
