"""Bodies in pictures: round ones are smooth, edges are sharp, what moves moves, and all are in view."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from in_memory import Recording, grid
from numpy.typing import NDArray
from PIL import Image
from taut.bodies import Body, Skin, normal_of, quad_of
from taut.render import RenderOptions, render_still, render_strip
from taut.render.framing import VIEW_ANGLE, frame_motion, is_floor

SIZE = (200, 180)
NONE = np.zeros((0, 3), np.int32)
CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
SIDES = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
FACES = np.array([part for a, b, c, d in SIDES for part in ([a, b, c], [a, c, d])], np.int32)


def ball(middle: Any, radius: float = 0.3, **changes: Any) -> Body:
    return Body("ball", "sphere", radius, np.array([middle], float), NONE, **changes)


def rod(start: Any, end: Any, radius: float = 0.1) -> Body:
    return Body("rod", "capsule", radius, np.array([start, end], float), NONE)


def plane(point: Any, normal: Any) -> Body:
    across = np.array(normal, float) / np.linalg.norm(normal)
    return Body("plane", "plane", 0.0, np.array([point, point + across]), NONE)


def cube(shift: Any = (0, 0, 0)) -> Body:
    return Body("cube", "surface", 0.0, CUBE + shift, FACES)


@dataclass
class Obstacles(Recording):
    """A recording with bodies, those of a frame at a time."""

    shown: list[list[Body]] = field(default_factory=list)

    def bodies(self, frame: int) -> Mapping[str, Body]:
        return {body.name: body for body in self.shown[frame]}


def beside(*frames: list[Body], **changes: Any) -> Obstacles:
    """A hanging cloth, from (0, 0, 1) to (1.5, 0, 2), beside bodies."""
    still = grid(9, 7)
    motion = np.repeat(still.motion, len(frames), axis=0)
    parts = motion, still.faces, still.springs, still.rest_length, still.strain_limit
    return Obstacles(*parts, shown=list(frames), **changes)


def picture(folder: Path, *panels: Recording, **options: Any) -> NDArray[np.int64]:
    out = folder / "still.png"
    render_still(
        panels, out, RenderOptions(**{"size": SIZE, "overwrite": True, "color": "fabric", **options})
    )
    with Image.open(out) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def volume(points: NDArray[np.float64], faces: NDArray[np.int32]) -> float:
    corners = points[faces]
    return float(np.linalg.det(corners).sum() / 6)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (ball([1, 2, 3], 0.5), 4 / 3 * np.pi * 0.5**3),
        (rod([1, 2, 3], [1, 2, 5], 0.5), np.pi * 0.5**2 * (2 + 4 / 3 * 0.5)),
        (rod([1, 0, 0], [-1, 2, 1], 0.5), np.pi * 0.5**2 * (3 + 4 / 3 * 0.5)),
        (rod([1, 0, 0], [1, 0, 0], 0.5), 4 / 3 * np.pi * 0.5**3),
        (cube([3, 3, 3]), 1.0),
    ],
)
def test_skins_are_closed_and_face_outwards(body: Body, expected: float) -> None:
    skin = Skin(body)
    points = skin.points(body)
    assert volume(points, skin.faces) == pytest.approx(expected, rel=0.015)
    assert volume(points - 7.0, skin.faces) == pytest.approx(volume(points, skin.faces), rel=1e-9), (
        "it is open"
    )


def test_points_of_round_bodies_lie_on_them() -> None:
    start, end = np.array([0.2, -1.0, 0.5]), np.array([1.0, 1.0, 0.0])
    body = rod(start, end, 0.25)
    points, axis = Skin(body).points(body), end - start
    along = np.clip((points - start) @ axis / (axis @ axis), 0, 1)
    away = np.linalg.norm(points - start - along[:, None] * axis, axis=1)
    np.testing.assert_allclose(away, 0.25, atol=1e-12)
    later = rod(start + 1, end + 1, 0.25)
    np.testing.assert_allclose(Skin(body).points(later), points + 1, atol=1e-12)


def test_edges_are_sharp_and_rounds_are_smooth() -> None:
    assert len(Skin(cube()).points(cube())) == 24, "each side of a cube has corners of its own"
    skin = Skin(ball([0, 0, 0]))
    smooth = Body("mesh", "surface", 0.0, skin.points(ball([0, 0, 0])), skin.faces)
    assert len(Skin(smooth).points(smooth)) == len(smooth.positions)
    bare = Body("none", "surface", 0.0, CUBE, NONE)
    assert len(Skin(bare).faces) == 0


def test_planes_are_squares_that_face_their_way() -> None:
    slope = plane([0, 0, 1], [1, 2, 2])
    corners = quad_of(slope, np.array([5.0, 5.0, 5.0]), 2.0)
    np.testing.assert_allclose((corners - [0, 0, 1]) @ normal_of(slope), 0, atol=1e-12)
    across = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    np.testing.assert_allclose(across, 16 * np.array([1, 2, 2]) / 3)


@pytest.mark.parametrize("far", [[-1, 0, 1], [3, 0, 1], [0.7, 0, 3], [0.7, 2, 1.5]])
def test_bodies_are_in_view(far: Any) -> None:
    still = beside([ball(far)])
    framing = frame_motion([still], 1.2)
    view = framing.target - framing.eye
    view /= np.linalg.norm(view)
    side = np.cross(view, framing.up)
    side /= np.linalg.norm(side)
    points = Skin(ball(far)).points(ball(far)) - framing.eye
    slope = np.tan(np.radians(VIEW_ANGLE / 2))
    assert (abs(points @ side) <= 1.2 * slope * (points @ view)).all()
    assert (abs(points @ np.cross(side, view)) <= slope * (points @ view)).all()


def test_a_body_at_the_end_of_the_world_leads_no_camera_astray() -> None:
    alone, beside_far = frame_motion([grid(9, 7)], 1.2), frame_motion([beside([ball([500, 0, 0])])], 1.2)
    np.testing.assert_allclose(alone.eye, beside_far.eye)


def test_the_ground_is_a_level_plane() -> None:
    floor, wall = plane([3, 3, 0.6], [0, 0, 1]), plane([3, 3, 0.6], [1, 0, 0])
    framing = frame_motion([beside([floor])], 1.2)
    assert framing.ground == pytest.approx(0.6) and is_floor(floor, framing.up, framing.ground)
    assert not is_floor(wall, framing.up, framing.ground)
    for other in (wall, plane([0, 0, -90], [0, 0, 1]), plane([0, 0, 0.6], [0, 0, -1])):
        framing = frame_motion([beside([other])], 1.2)
        assert framing.ground == pytest.approx(0.92) and not is_floor(other, framing.up, framing.ground)


def test_a_body_is_seen_and_throws_a_shadow(tmp_path: Path) -> None:
    # Both pictures have the same camera: the smaller ball hides in the larger one.
    with_ball = picture(tmp_path, beside([ball([0.7, -1, 0.5], 0.4)]))
    without = picture(tmp_path, beside([ball([0.7, -1, 0.5], 0.001), cube([0, 0, -99])]))
    assert (np.abs(with_ball[60:] - without[60:]).max(axis=2) > 30).sum() > 1000
    middle = with_ball.reshape(-1, 3)
    stone = (middle[:, 2] > middle[:, 0] + 8) & (middle.max(axis=1) < 190)
    assert stone.sum() > 1000, "grey-blue"


@pytest.mark.parametrize("body", [rod([0, -1, 0.4], [1.5, -1, 0.4]), cube([0.3, -1.5, 0])])
def test_other_bodies_are_seen(tmp_path: Path, body: Body) -> None:
    seen = picture(tmp_path, beside([body]))
    stone = (seen[..., 2] > seen[..., 0] + 8) & (seen.max(axis=2) < 190)
    assert stone[60:].sum() > 800


def test_a_slope_is_seen_from_before_and_not_from_behind(tmp_path: Path) -> None:
    toward, away = ([beside([plane([0, 3, 0], [0, way, 0.3])])] for way in (-1, 1))
    bare = picture(tmp_path, *[grid(9, 7)])
    assert np.abs(picture(tmp_path, *toward)[60:] - bare[60:]).mean() > 1
    assert np.abs(picture(tmp_path, *away)[60:] - bare[60:]).mean() < 0.3


def test_what_moves_moves(tmp_path: Path) -> None:
    places = [[0.2, -1, 0.4], [1.3, -1, 0.4]]
    film = beside(*[[ball(place, moves=True)] for place in places])
    first, last = picture(tmp_path, film, frame=0), picture(tmp_path, film, frame=1)
    assert (np.abs(first - last).max(axis=2) > 30).sum() > 1000
    render_strip([film], [0.0, 1.0], tmp_path / "strip.png", RenderOptions(size=SIZE, color="fabric"))
    with Image.open(tmp_path / "strip.png") as image:
        strip = np.asarray(image.convert("RGB")).astype(int)
    left, right = strip[60:180, :198], strip[60:180, 202:400]
    assert (np.abs(left - right).max(axis=2) > 30).sum() > 1000
