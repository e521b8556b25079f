"""The floor: a disc that fades out, with grid lines."""

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from taut.render.framing import Framing, Points

_FLOOR = (228, 232, 236)
_LINE = (190, 199, 208)
_TEXELS = 256
_LINE_WIDTH = 0.0011  # half, in half sides of the floor
_LIFT = 2e-4  # of the lines above the floor, in half sides
_EXTENT = 2.6  # of the floor, in radii of the motion


def add_ground(plotter: pv.Plotter, framing: Framing) -> None:
    """Add the floor to a plotter's current panel."""
    floor = _square(framing)
    steps = (np.arange(_TEXELS) + 0.5) / _TEXELS * 2 - 1
    image = pv.ImageData(dimensions=(_TEXELS, _TEXELS, 1))
    image.point_data["rgba"] = _faded(_FLOOR, np.hypot(*np.meshgrid(steps, steps)).ravel())
    texture = pv.Texture(image)  # type: ignore[no-untyped-call]
    plotter.add_mesh(floor, texture=texture, lighting=False)
    plotter.add_mesh(_lines(framing), scalars="rgba", rgba=True, lighting=False)


def half_side(framing: Framing) -> float:
    """Half the side of the square that the floor takes up [m]."""
    return _EXTENT * framing.radius


def fade(distance: NDArray[np.float64]) -> NDArray[np.float64]:
    """1 in the middle, 0 at the rim, smooth between; distances in half sides of the floor."""
    ramp = np.clip((1 - distance) / 0.65, 0, 1)
    return ramp * ramp * (3 - 2 * ramp)


def _faded(color: tuple[int, int, int], distance: NDArray[np.float64]) -> NDArray[np.uint8]:
    """A colour that fades with the distance, shape (points, 4)."""
    solid = np.broadcast_to(np.array(color, np.float64), (len(distance), 3))
    return np.concatenate([solid, 255 * fade(distance)[:, None]], axis=1).astype(np.uint8)


def _place(
    framing: Framing, across: NDArray[np.floating], along: NDArray[np.floating], lift: float
) -> Points:
    flat = np.multiply.outer(across, framing.right) + np.multiply.outer(along, framing.away)
    place: Points = framing.middle + flat + lift * framing.up
    return place


def _square(framing: Framing) -> pv.PolyData:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    across, along = half_side(framing) * corners.T
    square = pv.PolyData(_place(framing, across, along, 0.0), faces=[4, 0, 1, 2, 3])
    square.active_texture_coordinates = (corners + 1) / 2
    return square


def _lines(framing: Framing) -> pv.PolyData:
    """Grid lines at round distances from the world's origin: ribbons, in pieces so that they can fade."""
    half = half_side(framing)
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
            ribbons.append(_place(framing, across, along, _LIFT * half).reshape(-1, 3))
    points = np.concatenate(ribbons)
    left = (np.arange(len(ribbons))[:, None] * 2 * len(pieces) + np.arange(0, 2 * len(pieces) - 2, 2)).ravel()
    quads = np.stack([np.full_like(left, 4), left, left + 1, left + 3, left + 2], axis=1)
    lines = pv.PolyData(points, faces=quads.ravel())
    lines.point_data["rgba"] = _faded(_LINE, np.linalg.norm(points - framing.middle, axis=1) / half)
    return lines


def _round_down(length: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is not above ``length``."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * max(digit for digit in (1, 2, 5) if digit * power <= length * (1 + 1e-9)))
