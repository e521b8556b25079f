"""Pictures: something is seen, colours mean what the bar says, broken simulations do not break them."""

import errno
import os
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from in_memory import Recording, chain, grid, moved
from PIL import Image
from taut.frames import Frames, frame_rate, links, up_axis, vertex_stretch
from taut.render import RenderError, RenderOptions, render_film, render_still, render_strip
from taut.render.caption import Letterer
from taut.render.framing import VIEW_ANGLE, frame_motion
from taut.render.rendering import _moments
from taut.render.strain import BEYOND, strain_scale

SMALL = (200, 180)


def stretched(amount: float, frames: int = 1, **changes) -> Recording:
    still = grid(9, 7)
    pulled = still.motion[0].copy()
    pulled[:, 0] *= 1 + amount
    return moved(still, [pulled] * frames, **changes)


def picture(tmp_path: Path, *panels: Frames, name: str = "still.png", **options) -> np.ndarray:
    out = tmp_path / name
    render_still(
        panels, out, RenderOptions(**{"size": SMALL, "color": "strain", "overwrite": True, **options})
    )
    with Image.open(out) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def middle(image: np.ndarray) -> np.ndarray:
    """Colour of the middle of the cloth of a single panel."""
    return np.median(image[80:110, 80:120].reshape(-1, 3), axis=0)


# ---- stills


def test_a_still_shows_cloth_shadow_and_bar(tmp_path):
    image = picture(tmp_path, stretched(0.02))
    height, width, _ = image.shape
    assert width == SMALL[0] and height > SMALL[1] and width % 2 == height % 2 == 0
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 500
    assert np.abs(middle(image) - image[60, 3]).max() > 20  # cloth against background
    fabric = picture(tmp_path, stretched(0.02), color="fabric")
    assert fabric.shape[0] < height  # no bar
    red, green, blue = middle(fabric)
    assert red > 2 * green and red > 2 * blue


def test_colours_tell_stretch(tmp_path):
    calm, near, over, beyond = (middle(picture(tmp_path, stretched(s))) for s in (0.0, 0.048, 0.07, 0.3))
    assert near[2] - near[0] > calm[2] - calm[0] + 30  # blue near the limit
    assert over[0] - over[2] > 60  # warm over it
    assert beyond[1] < 60 and beyond[2] > beyond[1] + 40  # purple beyond the scale
    assert np.allclose(middle(picture(tmp_path, stretched(0.07), strain_top=0.2)), over, atol=80)


def test_equal_stretch_has_equal_colours_in_all_panels(tmp_path):
    image = picture(tmp_path, stretched(0.07), stretched(0.07, title="Twin"))
    left, right = image[60:170, : SMALL[0] - 3], image[60:170, SMALL[0] + 3 : 2 * SMALL[0]]
    assert np.abs(left[:, 3:] - right[:, : left.shape[1] - 3]).max(axis=2).mean() < 30
    assert abs(middle(left) - middle(right)).max() < 12


def test_jpeg_and_many_panels(tmp_path):
    panels = [stretched(0.01 * i, title=f"Panel {i}") for i in range(5)]
    image = picture(tmp_path, *panels, name="many.jpg")
    assert image.shape[1] == 3 * SMALL[0] and image.shape[0] > 2 * SMALL[1]


def test_chains_and_up_axis(tmp_path):
    empty = picture(tmp_path, moved(chain(8), [chain(8).motion[0] * 0]))
    image = picture(tmp_path, chain(8))
    assert (np.abs(image[60:170] - empty[60:170]).max(axis=2) > 30).sum() > 50
    still = stretched(0.02)
    turned = still.motion[:, :, [0, 2, 1]] * np.float32([1, 1, -1])
    y_up = moved(still, turned, scene={"fps": 60, "up": "y"})
    assert np.abs(picture(tmp_path, still) - picture(tmp_path, y_up)).mean() < 1


def test_frames_are_chosen(tmp_path):
    still = grid(9, 7)
    film = moved(still, [still.motion[0] + np.float32([0.1 * i, 0, 0]) for i in range(4)])
    first, last = picture(tmp_path, film, frame=0), picture(tmp_path, film)
    assert np.abs(first - last).mean() > 1
    assert np.array_equal(picture(tmp_path, film, frame=-1), last)
    assert np.array_equal(picture(tmp_path, film, frame=3), last)


@pytest.mark.parametrize("color", ["strain", "fabric"])
@pytest.mark.parametrize("poison", [np.nan, np.inf, -np.inf, 1e30, -3e38])
@pytest.mark.parametrize("make", [lambda: grid(9, 7), lambda: chain(8)])
def test_exploded_simulations_are_shown_as_far_as_they_go(tmp_path, make, poison, color, recwarn):
    still = make()
    bad = [still.motion[0].copy() for _ in range(3)]
    bad[1][5] = poison
    bad[2][:] = poison
    film = moved(still, bad)
    fine = picture(tmp_path, still, color=color)
    for frame in range(3):
        picture(tmp_path, film, frame=frame, color=color)
    # The camera is not led astray.
    assert np.abs(picture(tmp_path, film, frame=0, color=color)[60:] - fine[60:]).mean() < 1
    assert not [str(warning.message) for warning in recwarn if warning.category is RuntimeWarning]


def test_everything_not_finite_from_the_start(tmp_path):
    still = grid(9, 7)
    picture(tmp_path, moved(still, [np.full_like(still.motion[0], np.nan)]))


def test_no_springs_no_faces(tmp_path):
    still = grid(3, 3)
    bare = Recording(
        still.motion, still.faces[:0], still.springs[:0], still.rest_length[:0], still.strain_limit[:0]
    )
    picture(tmp_path, bare)


# ---- films


def read_film(path: Path) -> tuple[dict, np.ndarray]:
    reader = imageio_ffmpeg.read_frames(str(path))
    about = next(reader)
    width, height = about["size"]
    return about, np.stack([np.frombuffer(frame, np.uint8).reshape(height, width, 3) for frame in reader])


def test_a_film_has_all_frames_at_the_rate_of_the_scene(tmp_path):
    still = grid(9, 7)
    motion = [still.motion[0] + np.float32([0.1 * i, 0, 0]) for i in range(6)]
    calls = []
    options = RenderOptions(
        color="strain", size=(151, 121), progress=lambda done, total: calls.append((done, total))
    )
    long, short = moved(still, motion, scene={"fps": 24}), moved(still, motion[:2], scene={"fps": 24})
    render_film([long, short], tmp_path / "film.mp4", options)
    about, frames = read_film(tmp_path / "film.mp4")
    assert about["fps"] == 24 and about["codec"] == "h264" and about["pix_fmt"].startswith("yuv420p")
    assert len(frames) == 6 and calls == [(i, 6) for i in range(1, 7)]
    left, right = frames[:, :121, :145].astype(int), frames[:, :121, 160:].astype(int)
    assert np.abs(left[5] - left[2]).mean() > 2 and np.abs(right[5] - right[2]).mean() < 1
    assert list(tmp_path.iterdir()) == [tmp_path / "film.mp4"]


def test_panels_of_different_rates_and_lengths_run_in_time():
    still = grid(3, 3)
    fast = moved(still, [still.motion[0]] * 61, scene={"fps": 60})
    slow = moved(still, [still.motion[0]] * 16, scene={"fps": 30})
    moments = _moments([fast, slow], frame_rate([fast, slow][0]))
    assert len(moments) == 61 and moments[:4] == [(0, 0), (1, 0), (2, 1), (3, 1)]
    assert moments[30] == (30, 15) and moments[60] == (60, 15)
    assert _moments([slow, fast], frame_rate([slow, fast][0]))[30] == (15, 60)
    assert _moments([fast], frame_rate([fast][0])) == [(i,) for i in range(61)]


# ---- strips


def test_a_strip_has_a_row_for_each_simulation_and_a_column_for_each_moment(tmp_path):
    still = grid(9, 7)
    motion = [still.motion[0] + np.float32([0.1 * i, 0, 0]) for i in range(6)]
    moving = moved(still, motion, scene={"fps": 10}, title="Moving")
    resting = moved(still, motion[:1], scene={"fps": 10}, title="Resting")
    render_strip(
        [moving, resting], [0.0, 0.21, 9.0], tmp_path / "strip.png", RenderOptions(color="strain", size=SMALL)
    )
    with Image.open(tmp_path / "strip.png") as image:
        strip = np.asarray(image.convert("RGB")).astype(int)
    width, height = SMALL
    assert strip.shape[1] == 3 * width and 2 * height < strip.shape[0] < 3 * height
    panels = strip[: 2 * height].reshape(2, height, 3, width, 3).transpose(0, 2, 1, 3, 4)[:, :, 40:, 3:-3]
    for one, other in ((0, 1), (1, 2), (0, 2)):
        assert np.abs(panels[0, one] - panels[0, other]).mean() > 1
        assert np.abs(panels[1, one] - panels[1, other]).mean() < 0.5
    # The same cloth at the same place: one camera for all.
    assert np.abs(panels[0, 0] - panels[1, 0]).mean() < 0.5
    # The moment is the nearest frame, after the end the last.
    for time, nearest in ((0.21, 0.2), (9.0, 0.5)):
        pictures = []
        for at in (time, nearest):
            render_strip(
                [moving],
                [at],
                tmp_path / "one.png",
                RenderOptions(color="strain", size=SMALL, overwrite=True),
            )
            with Image.open(tmp_path / "one.png") as image:
                pictures.append(np.asarray(image))
        assert np.array_equal(*pictures)


# ---- what one may choose


def test_plain_cloth_is_the_default():
    assert RenderOptions().color == "fabric"


def test_a_background_of_ones_own_has_no_ground_and_no_sky(tmp_path):
    image = picture(tmp_path, stretched(0.0), color="fabric", background="#102030", caption=False)
    edge = np.concatenate([image[0], image[-1], image[:, 0], image[:, -1]])
    assert (edge == [16, 32, 48]).all()
    assert (np.abs(middle(image) - [16, 32, 48]) > 40).any()


def test_captions_can_be_left_out(tmp_path):
    plain = {"color": "fabric", "background": "white"}
    top = picture(tmp_path, stretched(0.0), **plain)[:24]
    assert (top < 128).any()
    assert (picture(tmp_path, stretched(0.0), **plain, caption=False)[:24] == 255).all()


def test_the_camera_stands_and_looks_where_it_is_told(tmp_path):
    cloth = {"color": "fabric", "background": "white", "caption": False}

    def covered(**options: object) -> tuple[float, float, float]:
        """Share of the picture that is cloth, and where its middle is, from the left and from above."""
        seen = (picture(tmp_path, stretched(0.0), **cloth, **options) < 200).any(axis=2)
        rows, columns = np.nonzero(seen)
        return seen.mean(), columns.mean() / seen.shape[1], rows.mean() / seen.shape[0]

    # The sheet is 1.5 m wide and 1 m high, its middle at (0.75, 0, 1.5).
    near, far = covered(eye=(0.75, -6, 1.5)), covered(eye=(0.75, -12, 1.5))
    assert near[0] == pytest.approx(4 * far[0], rel=0.1)
    assert near[1:] == pytest.approx((0.5, 0.5), abs=0.03)
    height = 2 * 6 * np.tan(np.radians(VIEW_ANGLE / 2))
    assert near[0] == pytest.approx(1.5 / height**2 * 180 / 200, rel=0.1)
    # Looking 0.5 m to its left and above it, the cloth is at the right and below.
    _, across, down = covered(eye=(0.75, -6, 1.5), target=(0.25, 0, 2.0))
    assert across == pytest.approx(0.5 + 0.5 / height * 180 / 200, abs=0.03)
    assert down == pytest.approx(0.5 + 0.5 / height, abs=0.03)
    # From right above up has no direction, and still there is a picture.
    assert covered(eye=(0.75, 0, 9))[0] >= 0


def test_a_film_has_the_rate_that_is_asked_for(tmp_path):
    still = grid(3, 3)
    motion = [still.motion[0]] * 13
    film = moved(still, motion, scene={"fps": 24})
    for fps, frames in ((None, 13), (12, 7), (48, 25)):
        render_film([film], tmp_path / "film.mp4", RenderOptions(size=(96, 96), fps=fps, overwrite=True))
        count, seconds = imageio_ffmpeg.count_frames_and_secs(tmp_path / "film.mp4")
        assert count == frames and seconds == pytest.approx(frames / (fps or 24), abs=0.05)


# ---- refusals


@pytest.mark.parametrize(
    ("panels", "name", "options", "message"),
    [
        ([stretched(0)], "a.gif", {}, "a.gif: .* a still ends in .png, .jpg, .jpeg, a film in .mp4, .mov"),
        ([stretched(0)], "a", {}, "a still ends in"),
        ([stretched(0, 3)], "a.png", {"frame": 3}, "frame 3 is out of range: there are 3, 0 to 2"),
        ([stretched(0, 3)], "a.png", {"frame": -4}, "frame -4 is out of range"),
        ([stretched(0, 0)], "a.png", {}, "'Recording' has no frames"),
        ([], "a.png", {}, "nothing to render"),
        (
            [stretched(0)] * 3,
            "a.png",
            {"size": (4096, 64)},
            "a picture of 12288 x 64 pixels: at most 8192 a side",
        ),
    ],
)
def test_still_refusals(tmp_path, panels, name, options, message):
    with pytest.raises(RenderError, match=message):
        render_still(panels, tmp_path / name, RenderOptions(**{"size": SMALL, "color": "strain", **options}))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"color": "blue"}, "color = 'blue': must be one of strain, fabric"),
        ({"size": (10, 10)}, "must be 64 to 4096"),
        ({"columns": 0}, "columns = 0: must be 1 or more"),
        ({"strain_top": 0.0}, "must be above 0"),
        ({"strain_top": float("nan")}, "must be above 0"),
        ({"strain_top": float("inf")}, "must be above 0"),
        ({"eye": (0, 1)}, "eye = .*: must be three finite numbers"),
        ({"target": (0, 1, np.nan)}, "target = .*: must be three finite numbers"),
        ({"eye": (0, 1, 2), "target": (0, 1, 2)}, "the camera stands there"),
        ({"fps": 0}, "fps = 0: must be 0.1 to 1000"),
        ({"fps": np.nan}, "fps = nan"),
        ({"background": "blurple"}, "background = 'blurple': must be a colour"),
    ],
)
def test_option_refusals(options, message):
    with pytest.raises(RenderError, match=message):
        RenderOptions(**options)


def test_strip_refusals(tmp_path):
    with pytest.raises(RenderError, match="name a moment or more"):
        render_strip([stretched(0)], [], tmp_path / "strip.png")
    with pytest.raises(RenderError, match="nothing to render"):
        render_strip([], [0.0], tmp_path / "strip.png")
    with pytest.raises(RenderError, match="'Recording' has no frames"):
        render_strip([stretched(0, 0)], [0.0], tmp_path / "strip.png")


def test_film_refusals(tmp_path):
    with pytest.raises(RenderError, match="a film in .mp4, .mov"):
        render_film([stretched(0)], tmp_path / "film.png")
    (tmp_path / "film.mp4").write_text("precious")
    with pytest.raises(RenderError, match="exists already"):
        render_film([stretched(0)], tmp_path / "film.mp4")
    assert (tmp_path / "film.mp4").read_text() == "precious"


@pytest.mark.parametrize("name", ["still.png", "film.mp4"])
def test_full_disk_leaves_nothing(tmp_path, monkeypatch, name):
    def fail(*_args: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", fail)
    render = render_film if name.endswith("mp4") else render_still
    with pytest.raises(RenderError, match=f"{name} cannot be written: No space left on device"):
        render([stretched(0, 2)], tmp_path / name, RenderOptions(color="strain", size=(96, 96)))
    assert list(tmp_path.iterdir()) == []


def test_an_encoder_that_dies_is_noticed(tmp_path, monkeypatch):
    def short(*_args: object) -> tuple[int, float]:
        return 1, 0.1

    monkeypatch.setattr(imageio_ffmpeg, "count_frames_and_secs", short)
    with pytest.raises(RenderError, match="the film encoder stopped before the end"):
        render_film([stretched(0, 2)], tmp_path / "film.mp4", RenderOptions(color="strain", size=(96, 96)))
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_film_leaves_nothing(tmp_path):
    def stop(done: int, _total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render_film(
            [stretched(0, 4)],
            tmp_path / "film.mp4",
            RenderOptions(color="strain", size=(96, 96), progress=stop),
        )
    assert list(tmp_path.iterdir()) == []


# ---- parts


def inside(points: np.ndarray, framing, aspect: float) -> bool:
    view = framing.target - framing.eye
    view /= np.linalg.norm(view)
    side = np.cross(view, framing.up)
    side /= np.linalg.norm(side)
    offset = points - framing.eye
    depth, slope = offset @ view, np.tan(np.radians(VIEW_ANGLE / 2))
    x, y = offset @ side / depth / slope / aspect, offset @ np.cross(side, view) / depth / slope
    return bool((depth > 0).all() and (np.abs(x) < 0.94).all() and (y < 0.73).all() and (y > -0.91).all())


@settings(max_examples=60, deadline=None)
@given(
    scale=st.floats(1e-3, 1e3),
    offset=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    pull=st.floats(1, 2.5),
    aspect=st.floats(0.3, 4),
)
def test_all_motion_is_in_view_but_not_what_was_thrown_off(scale, offset, pull, aspect):
    still = grid(5, 4)
    rest = ((still.motion[0] - [0.75, 0, 1.5]) + np.divide(offset, 1)) * scale
    later = rest + (rest - rest.mean(axis=0)) * (pull - 1)
    film = moved(still, [rest, later])
    framing = frame_motion([film], aspect)
    assert inside(film.motion.reshape(-1, 3).astype(float), framing, aspect)
    thrown = film.motion.copy()
    thrown[1, 3] += np.float32(1e4 * scale)
    other = frame_motion([moved(still, thrown)], aspect)
    assert np.linalg.norm(other.eye - framing.eye) < 2 * np.linalg.norm(framing.eye - framing.target)


def test_strain_scale():
    scale = strain_scale([stretched(0.2), stretched(0.0)], None)
    assert scale.limit == pytest.approx(0.05) and scale.top == pytest.approx(0.1)
    assert (
        not scale.is_over(0.05) and not scale.is_over(-1) and scale.is_over(0.051) and scale.is_over(np.nan)
    )
    assert scale.share(np.array([-1, 0, 0.05, 0.1, np.nan, np.inf])).tolist() == pytest.approx(
        [0, 0, 0.5, 1, 900, 900]
    )
    colors = scale.colors()
    assert colors.shape == (1024, 4) and (colors[:, 3] == 255).all()
    assert "#{:02x}{:02x}{:02x}".format(*colors[-1, :3]) == BEYOND
    free = stretched(0.234)
    free.strain_limit = np.full_like(free.strain_limit, np.inf)
    assert strain_scale([free], None).limit is None
    assert strain_scale([free], None).top == pytest.approx(0.3)
    assert not strain_scale([free], None).is_over(9.0)
    free.motion = free.motion * np.float32(np.nan)
    assert strain_scale([free], None).top == pytest.approx(0.01)
    assert strain_scale([free], 0.5).top == 0.5


def test_titles_that_are_too_long_or_odd(tmp_path):
    for title in ("x" * 500, "", "two\nlines\ttabs", "λ = 5 % é Ж 布", "\ud800"):
        picture(tmp_path, stretched(0.0, title=title))


def test_sizes_are_even():
    for panel in ((101, 99), (640, 480), (64, 65)):
        assert not any(side % 2 for side in Letterer(panel, [(0, 0), (panel[0], 0)], None).size)


def test_what_frames_tell():
    assert frame_rate(stretched(0, 3, scene={"fps": 24})) == 24.0
    assert up_axis(stretched(0)) == 2 and up_axis(stretched(0, scene={"fps": 1, "up": "y"})) == 1
    assert links(grid(3, 3)).size == 0 and links(chain(4)).tolist() == [0, 1, 2, 3]
    assert vertex_stretch(chain(4), 0).tolist() == pytest.approx([0] * 5, abs=1e-6)
