"""Pictures are put together: sky and floor, the shadow on the floor, what moves before them."""

from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
import pytest
from in_memory import Recording, grid, moved
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from taut.frames import Frames
from taut.render import RenderOptions, render_film, render_still
from taut.render.framing import VIEW_ANGLE, Framing, frame_motion, looking
from taut.render.shadow import Shadow
from test_render_bodies import ball, beside, plane

SIZE = (320, 180)


def picture(folder: Path, panel: Frames, **options: Any) -> NDArray[np.int64]:
    out = folder / "still.png"
    render_still([panel], out, RenderOptions(size=SIZE, overwrite=True, caption=False, **options))
    with Image.open(out) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def falling() -> Recording:
    """A small level sheet, its middle at (0.2, 0.1), 1 m and then 0.1 m above the ground."""
    still = grid(9, 7)
    flat = (still.motion[0] - still.motion[0].mean(axis=0))[:, [0, 2, 1]] * 0.2
    return moved(still, [flat + np.float32([0.2, 0.1, height]) for height in (1.0, 0.1)])


def place(framing: Framing, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where a point is seen [pixels], by the angles from the camera's axes."""
    view = (framing.target - framing.eye) / np.linalg.norm(framing.target - framing.eye)
    side = np.cross(view, framing.up) / np.linalg.norm(np.cross(view, framing.up))
    way = point - framing.eye
    across, along = way @ side / (way @ view), way @ np.cross(side, view) / (way @ view)
    scale = SIZE[1] / 2 / np.tan(np.radians(VIEW_ANGLE / 2))
    return np.array([SIZE[0] / 2 + scale * across, SIZE[1] / 2 - scale * along])


def test_rays_go_to_what_is_seen() -> None:
    framing = frame_motion([grid(9, 7)], SIZE[0] / SIZE[1])
    for point in np.random.default_rng(1).uniform([0, -0.5, 1], [1.5, 0.5, 2], (20, 3)):
        ray = framing.rays(SIZE) @ [*place(framing, point), 1]
        way = point - framing.eye
        assert ray / np.linalg.norm(ray) == pytest.approx(way / np.linalg.norm(way), abs=1e-9)


@pytest.mark.parametrize("eye", [None, (-3.0, -2.0, 0.4), (0.3, 0.0, 0.6)])
def test_the_shadow_lies_where_the_light_throws_it(eye: Any) -> None:
    frames = falling()
    framing = looking(frame_motion([frames], SIZE[0] / SIZE[1]), eye, eye and (0.4, 0.4, 0.0))
    assert framing.ground == 0 and framing.is_above
    paper = Image.new("RGB", (SIZE[0] + 40, SIZE[1] + 30), "white")
    positions = frames.motion[0].astype(float)
    Shadow(frames, framing, SIZE).lay(paper, (40, 30), positions, [])
    dark = 255 - np.asarray(paper.convert("L")).astype(int)
    assert (dark[:30] == 0).all() and (dark[:, :40] == 0).all(), "within its panel"
    expected = Image.new("1", SIZE)
    corners = framing.shadow(positions[[0, 8, 62, 54]])
    ImageDraw.Draw(expected).polygon([tuple(place(framing, corner)) for corner in corners], fill=1)
    seen, there = dark[30:, 40:] > dark.max() / 2, np.asarray(expected)
    assert there.mean() > 0.0009 and dark.max() > 60
    assert (seen & there).sum() / (seen | there).sum() > 0.75


def test_a_shadow_behind_the_camera_is_not_seen() -> None:
    frames = falling()
    framing = frame_motion([frames], SIZE[0] / SIZE[1])
    away = looking(framing, (0.3, 1.5, 0.5), (0.3, 9.0, 0.4))
    paper = Image.new("RGB", SIZE, "white")
    Shadow(frames, away, SIZE).lay(paper, (0, 0), frames.motion[0].astype(float), [])
    assert (np.asarray(paper) == 255).all()


def test_from_below_there_is_no_floor(tmp_path: Path) -> None:
    frames = grid(9, 7)
    image = picture(tmp_path, frames, eye=(0.7, -4.0, -1.5), target=(0.7, 0.0, 1.5))
    sky = image[:, :1]
    cloth = image[..., 0] > image[..., 2] + 14
    assert cloth.mean() > 0.1
    border = np.abs(image - sky).max(axis=2) > 2
    assert not border[[0, -1]].any() and not border[:, [0, -1]].any()
    assert (border & ~cloth).mean() < 0.02, "all but the cloth and its rim is sky"
    above = picture(tmp_path, frames, eye=(0.7, -4.0, 2.5), target=(0.7, 0.0, 1.5))
    assert (np.abs(above - above[:, :1]).max(axis=2) > 2)[-40:].mean() > 0.1, "from above there is one"


def test_what_is_below_the_floor_is_hidden(tmp_path: Path) -> None:
    def stones(height: float) -> int:
        frames = beside([plane([0, 0, 0.6], [0, 0, 1]), ball([0.7, -1.0, height], 0.3)])
        image = picture(tmp_path, frames, eye=(0.7, -9.0, 0.61), target=(0.7, 0.0, 1.2))
        image = image[:, 140:180]  # without the dark pins at the left edge of the cloth
        return int(((image[..., 2] >= image[..., 0]) & (image[..., 0] < 185)).sum())

    whole = stones(0.95)
    assert whole > 200
    assert stones(0.6) == pytest.approx(whole / 2, rel=0.15)
    assert stones(0.2) == 0


def test_a_film_shows_what_stills_show(tmp_path: Path) -> None:
    still = grid(9, 7)
    film = moved(still, [still.motion[0] + np.float32([0.15 * step, 0, 0]) for step in range(6)])
    render_film([film], tmp_path / "film.mp4", RenderOptions(size=SIZE, caption=False))
    read = imageio_ffmpeg.read_frames(str(tmp_path / "film.mp4"))
    next(read)
    frames = [np.frombuffer(one, np.uint8).reshape(SIZE[1], SIZE[0], 3).astype(int) for one in read]
    stills = [picture(tmp_path, film, frame=frame) for frame in range(6)]
    apart = np.array([[np.abs(one - other).mean() for other in stills] for one in frames])
    assert apart.argmin(axis=1).tolist() == list(range(6))
    assert apart.diagonal().max() < 3
