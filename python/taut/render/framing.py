"""Where the camera stands and where the ground lies: one choice for all panels and all frames."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taut.bodies import Body, Skin, floor_of, is_level
from taut.frames import Frames, bodies_of, up_axis

Points = NDArray[np.float64]
Place = tuple[float, float, float]

LIGHT_SLANT = (0.22, 0.3)
"""How far a shadow moves to the right and away from the viewer for each metre of height."""

VIEW_ANGLE = 24.0
"""Of the camera, vertically [degrees]."""

_FRAMES_LOOKED_AT = 32
_VERTICAL = 1e-3
"""Sine of the angle to the vertical below which up has no direction in the picture."""
# The part of the picture that cloth may fill, as shares of half its width and height; captions stand above.
_SIDE, _TOP, _BOTTOM = 0.93, 0.72, 0.9
# A vertex further from the middle of the cloth than so many times its size at rest has been thrown off; cloth
# that merely stretches stays within.
_STRETCHED, _TRAVELLED = 3.0, 8.0
# Of bodies, what is further away than so many diagonals of the motion need not be seen; so many of their
# points say where they are.
_NEAR, _MOST_POINTS = 1.5, 2000


@dataclass(frozen=True)
class Framing:
    """A camera and a ground plane. Lengths in metres, vectors of shape (3,)."""

    up: Points
    right: Points
    """Along the ground, to the viewer's right."""
    away: Points
    """Along the ground, away from the viewer."""
    eye: Points
    target: Points
    ground: float
    """Height of the ground."""
    middle: Points
    """A point of the ground below the motion."""
    radius: float
    """Of the ground that the motion and its shadow take up, around :attr:`middle`."""
    middle_of_motion: Points
    """The middle of all that is to be seen."""

    def shadow(self, points: Points) -> Points:
        """Where points throw their shadow on the ground, shape (points, 3)."""
        return _shadow(points, self.up, self.right, self.away, self.ground)

    @property
    def is_above(self) -> bool:
        """Whether the camera stands above the ground; from below the ground is not seen."""
        return bool(self.eye @ self.up > self.ground)

    def rays(self, size: tuple[int, int]) -> Points:
        """The matrix from places in a picture (x, y, 1) [pixels] to ways from the eye, shape (3, 3).

        Args:
            size: width and height of the picture [pixels].
        """
        view = self.target - self.eye
        side = np.cross(view, self.up)
        side /= np.linalg.norm(side)
        down = np.cross(view / np.linalg.norm(view), side)
        reach = np.tan(np.radians(VIEW_ANGLE / 2)) * np.linalg.norm(view)
        pixel = 2 * reach / size[1]
        corner = view - pixel / 2 * (size[0] * side + size[1] * down)
        return np.stack([pixel * side, pixel * down, corner], axis=1)

    @property
    def clipping(self) -> tuple[float, float]:
        """Nearest and furthest distance from the eye that the camera shows."""
        distance = float(np.linalg.norm(self.eye - self.target))
        return 0.02 * distance, distance + 20 * self.radius


def frame_motion(panels: Sequence[Frames], aspect: float) -> Framing:
    """Choose a camera that has all motion of all panels in view, but not what was thrown off.

    Args:
        panels: what is to be seen.
        aspect: width of a panel over its height.
    """
    points = np.concatenate([_with_bodies(panel, _motion(panel)) for panel in panels])
    axis = up_axis(panels[0])
    up = np.eye(3)[axis]
    right, away = _ground_directions(panels[0], axis)
    heights = points @ up
    size = max(float(np.linalg.norm(np.ptp(points, axis=0))), 1e-3)
    lowest, tallness = float(heights.min()), max(float(np.ptp(heights)), 0.25 * size)
    # The world's own ground, if it is near.
    ground = 0.0 if 0 <= lowest <= 0.4 * tallness else lowest - 0.08 * tallness
    floor = floor_of([body for panel in panels for body in bodies_of(panel, 0)], up, lowest, 2 * size)
    ground = ground if floor is None else float(floor.positions[0] @ up)
    footprint = _shadow(points, up, right, away, ground)
    below = np.concatenate([footprint, points - np.outer(heights - ground, up)])
    middle = (below.min(axis=0) + below.max(axis=0)) / 2
    radius = max(float(np.linalg.norm(below - middle, axis=1).max()), 0.5 * size)
    view = 0.9 * away + 0.42 * right - 0.33 * up
    eye, target = _fit(np.concatenate([points, footprint]), view / np.linalg.norm(view), up, aspect)
    amidst = (points.min(axis=0) + points.max(axis=0)) / 2
    return Framing(up, right, away, eye, target, ground, middle, radius, amidst)


def looking(framing: Framing, eye: Place | None, target: Place | None) -> Framing:
    """The same with the camera elsewhere, or looking elsewhere [m]; it keeps out of the vertical."""
    if eye is None and target is None:
        return framing
    stand = framing.eye if eye is None else np.asarray(eye, np.float64)
    seen = framing.middle_of_motion if target is None else np.asarray(target, np.float64)
    way = seen - stand
    if np.linalg.norm(np.cross(way, framing.up)) < _VERTICAL * np.linalg.norm(way):
        seen = seen + _VERTICAL * max(float(np.linalg.norm(way)), 1e-3) * framing.away
    return replace(framing, eye=stand, target=seen)


def _shadow(points: Points, up: Points, right: Points, away: Points, ground: float) -> Points:
    height = points @ up - ground
    slant = LIGHT_SLANT[0] * right + LIGHT_SLANT[1] * away
    return points + np.outer(height, slant - up)


def _looked_at(frames: Frames) -> list[int]:
    """Frames spread over the time."""
    return [int(at) for at in np.unique(np.linspace(0, frames.frames - 1, _FRAMES_LOOKED_AT).astype(int))]


def _motion(frames: Frames) -> Points:
    """Positions in frames spread over the time, less vertices that were thrown off; shape (points, 3)."""
    kept: list[Points] = []
    start, reach = np.zeros(3), 0.0
    for frame in _looked_at(frames):
        points = np.asarray(frames.positions(frame), dtype=np.float64)
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) == 0:
            continue
        middle = np.median(points, axis=0)
        distance = np.linalg.norm(points - middle, axis=1)
        if not kept:
            start, reach = middle, float(distance.max())
        if np.linalg.norm(middle - start) <= _TRAVELLED * reach:
            kept.append(points[distance <= _STRETCHED * reach])
    return np.concatenate(kept) if kept else np.zeros((1, 3))


def _with_bodies(frames: Frames, motion: Points) -> Points:
    """The motion of the cloth, and bodies near it that are no planes; shape (points, 3)."""
    first = [body for body in bodies_of(frames, 0) if body.shape != "plane"]
    if not first:
        return motion
    skins = {body.name: Skin(body) for body in first}
    middle = (motion.min(axis=0) + motion.max(axis=0)) / 2
    reach = _NEAR * max(float(np.linalg.norm(np.ptp(motion, axis=0))), 1e-3)
    found = [motion]
    moments = _looked_at(frames) if any(body.moves for body in first) else [0]
    for frame in moments:
        for body in bodies_of(frames, frame):
            if body.name in skins and (body.moves or frame == 0):
                points = skins[body.name].points(body)
                points = points[:: max(1, len(points) // _MOST_POINTS)]
                found.append(points[np.linalg.norm(points - middle, axis=1) <= reach])
    return np.concatenate(found)


def is_floor(plane: Body, up: Points, ground: float) -> bool:
    """Whether the ground of a picture shows a plane."""
    return is_level(plane, up) and bool(np.isclose(plane.positions[0] @ up, ground, atol=1e-6))


def _ground_directions(frames: Frames, axis: int) -> tuple[Points, Points]:
    """Right and away from a viewer in front of the scene, or beside it where that shows much more cloth."""
    right, away = (np.eye(3)[0], np.eye(3)[1]) if axis == 2 else (np.eye(3)[0], -np.eye(3)[2])
    corners = np.asarray(frames.positions(0), dtype=np.float64)[frames.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front, side = (float(np.nansum(np.abs(normals @ direction))) for direction in (away, right))
    return (-away, right) if side > 2 * front else (right, away)


def _fit(points: Points, view: Points, up: Points, aspect: float) -> tuple[Points, Points]:
    """Move a camera that looks along ``view`` to where all points just fit; return eye and target.

    Each border of the picture is a plane through the eye with a known normal. So each gives one linear bound
    on the eye's place. The nearest eye that keeps them all follows from opposite pairs of them.
    """
    side = np.cross(view, up)
    side /= np.linalg.norm(side)
    x, y, depth = points @ side, points @ np.cross(side, view), points @ view
    slope = np.tan(np.radians(VIEW_ANGLE / 2))
    wide, top, bottom = _SIDE * slope * aspect, _TOP * slope, _BOTTOM * slope
    right, left = (x - wide * depth).max(), (-x - wide * depth).max()
    above, below = (y - top * depth).max(), (-y - bottom * depth).max()
    back = max((right + left) / (2 * wide), (above + below) / (top + bottom), 1e-3 - float(depth.min()))
    # Whatever room is left over is shared between opposite borders.
    eye_x, eye_y = (right - left) / 2, ((above - top * back) + (bottom * back - below)) / 2
    eye = eye_x * side + eye_y * np.cross(side, view) - back * view
    return eye, eye + (back + (depth.min() + depth.max()) / 2) * view
