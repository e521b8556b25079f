"""The viewer's page in a browser: what it shows is what the engine has, and hands on it reach the engine."""

import shutil
import time
from collections.abc import Iterator
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from playwright.sync_api import Browser, Page, sync_playwright
from taut import Scene
from taut.view.live import LiveShow
from viewing import Viewing, viewing

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium here: install Debian's `chromium`, or Chrome"),
]

CELLS = 64
PULLED = 40 * (CELLS + 1) + 50
"""A vertex in the right half of the flag."""
PATIENCE = 40.0
"""For the page to do something [s]."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    software = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
    with sync_playwright() as playwright:
        # Root, as in a container, has no sandbox.
        options = [*software, "--no-sandbox"]
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield browser
        browser.close()


@pytest.fixture
def shown(flag: dict[str, Any]) -> Iterator[Viewing]:
    flag["cloth"][0]["grid"]["cells"] = [CELLS, CELLS]
    with viewing(LiveShow(Scene(flag))) as at:
        yield at


@pytest.fixture
def page(browser: Browser, shown: Viewing) -> Iterator[Page]:
    page = browser.new_page(viewport={"width": 960, "height": 600})
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
    page.goto(shown.url)
    until(page, "Boolean(window.viewer && viewer.picture)")
    yield page
    page.close()
    assert faults == []


def until(page: Page, condition: str) -> None:
    """Wait for a condition; the page's policy forbids Playwright's own way, which needs eval."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if page.evaluate(condition):
            return
        page.wait_for_timeout(20)
    raise AssertionError(f"it never came true that {condition}")


def pause(page: Page, shown: Viewing) -> None:
    """Stop the time, and wait until the page shows the last state."""
    page.click("#play")
    until(page, "!viewer.status.playing")
    until(page, f"viewer.picture.number === {shown.show.board.picture[0]} && !viewer.stale")


def pixels(page: Page) -> NDArray[np.uint8]:
    return np.asarray(Image.open(BytesIO(page.locator("#picture").screenshot())).convert("RGB"))


def is_cloth(image: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Red and cream are the cloth's; everything else is grey or blue."""
    return image[..., 0].astype(int) > image[..., 2].astype(int) + 14


def projected(page: Page, positions: NDArray[np.floating]) -> NDArray[np.float64]:
    """Where points are on the page, by the page's camera but with our own arithmetic [pixels]."""
    view = page.evaluate("(({ css, camera }) => ({ css, camera: [...camera] }))(viewer.views()[0])")
    matrix = np.array(view["camera"]).reshape(4, 4).T
    clip = np.c_[positions.astype(float), np.ones(len(positions))] @ matrix.T
    at = clip[:, :2] / clip[:, 3:]
    return np.c_[(at[:, 0] + 1) / 2 * view["css"]["width"], (1 - at[:, 1]) / 2 * view["css"]["height"]]


def outline(page: Page, shown: Viewing) -> NDArray[np.bool_]:
    """The pixels that the engine's cloth covers."""
    simulation = shown.show.simulations[0]
    at = projected(page, simulation.positions)
    box = page.evaluate("[viewer.canvas.clientWidth, viewer.canvas.clientHeight]")
    image = Image.new("1", box)
    draw = ImageDraw.Draw(image)
    for corners in simulation.faces:
        draw.polygon([tuple(at[corner]) for corner in corners], fill=1)
    return np.asarray(image)


def test_the_cloth_moves_and_lies_where_the_engine_has_it(page: Page, shown: Viewing) -> None:
    pause(page, shown)
    page.click("#reset")
    until(page, "viewer.picture.frame === 0 && !viewer.stale")
    before = pixels(page)
    page.click("#play")
    until(page, "viewer.picture.frame > 60")
    pause(page, shown)
    after = pixels(page)
    assert (before != after).any(axis=2)[is_cloth(before)].mean() > 0.3, "the cloth has moved"
    seen, expected = is_cloth(after), outline(page, shown)
    assert expected.mean() > 0.08, "it fills a good part of the picture"
    # Edges may differ by a pixel; the pole of pins at the left one is dark.
    overlap = (seen & expected).sum() / (seen | expected).sum()
    assert overlap > 0.95, f"only {overlap:.1%} of the cloth is where the engine has it"


def test_from_below_the_floor_hides_nothing(page: Page, shown: Viewing) -> None:
    pause(page, shown)
    page.evaluate("viewer.camera.orbit(0, -1000); viewer.redraw()")
    until(page, "!viewer.stale")
    assert page.evaluate("viewer.camera.eye[2] < viewer.look.floor")
    seen, expected = is_cloth(pixels(page)), outline(page, shown)
    assert expected.mean() > 0.02, "the cloth is in the picture"
    overlap = (seen & expected).sum() / (seen | expected).sum()
    assert overlap > 0.9, f"only {overlap:.1%} of the cloth is seen"


def test_a_vertex_follows_the_pointer_and_the_limit_holds(page: Page, shown: Viewing) -> None:
    x, y = page.evaluate(f"viewer.where({PULLED})")
    page.mouse.move(x, y)
    page.mouse.down()
    vertex = page.evaluate("viewer.pointer.drag.vertex")
    page.mouse.move(x - 80, y - 60, steps=10)
    away = f"Math.hypot(viewer.where({vertex})[0] - {x - 80}, viewer.where({vertex})[1] - {y - 60})"
    until(page, f"{away} < 10 && viewer.picture.held.includes({vertex})")
    assert page.evaluate("viewer.picture.panels[0].worst") <= 0.04 * (1 + 1e-4)
    page.mouse.up()
    until(page, f"viewer.picture.held.length === 0 && {away} > 20")


def test_the_limit_is_switched_off_and_on(page: Page, shown: Viewing) -> None:
    worst = "viewer.picture.panels[0].worst"
    assert page.evaluate(worst) <= 0.04 * (1 + 1e-4)
    page.click("#limit")
    until(page, f"{worst} > 0.15 && viewer.cloths[0].overCount > 100")
    assert page.text_content("#limit") == "Limit off"
    page.click("#limit")
    until(page, f"{worst} <= 0.04 * (1 + 1e-4) && viewer.cloths[0].overCount === 0")
    start = page.evaluate("viewer.picture.frame")
    until(page, f"viewer.picture.frame > {start} + 5")
    assert page.evaluate(worst) <= 0.04 * (1 + 1e-4)


def test_side_by_side_colours_still_film_and_a_moved_pin(page: Page, shown: Viewing) -> None:
    page.click("#compare")
    until(page, "viewer.cloths.length === 2")
    page.click("[data-colour=strain]")
    page.wait_for_selector("#legend:not([hidden])")
    assert "λ" in (page.text_content("#ticks") or "")
    assert len(page.query_selector_all("#names span")) == 2
    page.click("#compare")
    until(page, "viewer.cloths.length === 1")
    with page.expect_download() as download:
        page.click("#still")
    assert Image.open(download.value.path()).size == tuple(
        page.evaluate("[viewer.canvas.width, viewer.canvas.height]")
    )
    with page.expect_download() as download:
        page.click("#film")
        page.click("#film")  # at once: the film waits for its first picture
    head = download.value.path().read_bytes()[:12]
    assert head.startswith(b"\x1aE\xdf\xa3") or head[4:8] == b"ftyp", "it is WebM or MP4"
    pin = shown.show.simulations[0].pin_groups[0][0]
    x, y = page.evaluate(f"viewer.where({pin})")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y - 20, steps=5)
    page.mouse.up()
    until(page, f"Math.hypot(viewer.where({pin})[0] - {x + 30}, viewer.where({pin})[1] - {y - 20}) < 1")


def test_a_recording_is_scrubbed_on_a_phone(browser: Browser, recorded: Any) -> None:
    from taut import Cache
    from taut.view.playback import PlaybackShow

    cache = Cache.open(recorded)
    with viewing(PlaybackShow([cache])) as at:
        phone = browser.new_page(viewport={"width": 390, "height": 780}, has_touch=True, is_mobile=True)
        phone.goto(at.url)
        until(phone, "Boolean(window.viewer && viewer.picture)")
        phone.click("#play")
        until(phone, "!viewer.status.playing")
        phone.locator("#seek").fill("12")
        until(phone, "viewer.picture.frame === 12")
        shown = phone.evaluate("[...viewer.cloths[0].positions]")
        assert np.array_equal(np.float32(shown).reshape(-1, 3), cache.positions(12))
        assert phone.evaluate("document.documentElement.scrollWidth") <= 390
        phone.close()


def test_a_body_is_dragged_a_ball_thrown_and_contacts_are_marked(browser: Browser) -> None:
    sheet = {"size": [0.4, 0.4], "cells": [8, 8], "origin": [-0.2, -0.2, 0.62], "axes": ["x", "y"]}
    scene = {
        "body": [
            {"name": "ball", "sphere": {"center": [0, 0, 0.3], "radius": 0.3}},
            {"name": "floor", "plane": {"normal": [0, 0, 1]}},
        ],
        "cloth": [{"grid": sheet, "thickness": 0.01}],
    }
    faults: list[str] = []
    with viewing(LiveShow(Scene(scene))) as at:
        page = browser.new_page(viewport={"width": 960, "height": 600})
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(at.url)
        until(page, "Boolean(window.viewer && viewer.picture && viewer.picture.frame > 30)")
        assert page.is_visible("#nearness")
        assert float((page.text_content("#closest") or "").split()[0]) > 0
        page.keyboard.press("k")
        until(page, "viewer.cloths[0].solids.touches.length > 3")
        pause(page, at)
        blue = (pixels(page)[..., 2].astype(int) - pixels(page)[..., 0] > 60).sum()
        assert blue > 10, "contacts are marked"
        page.keyboard.press("k")
        until(page, "!viewer.stale && !viewer.picture.arrays.touches0")
        page.click("#play")
        # The lower half of the ball looks out from under the small sheet.
        column, row = projected(page, np.array([[0, 0, 0.12]]))[0]
        page.mouse.move(column, row)
        until(page, "viewer.canvas.classList.contains('over')")
        page.mouse.down()
        assert page.evaluate("viewer.pointer.drag.body") == 0
        page.mouse.move(column - 60, row, steps=5)
        middle = "viewer.cloths[0].solids.middle(0)"
        until(page, f"Math.hypot({middle}[0], {middle}[1]) > 0.08")
        page.mouse.up()
        until(page, "viewer.pointer.drag === null")
        page.click("#reset")
        until(page, f"Math.hypot({middle}[0], {middle}[1]) < 1e-6")
        page.mouse.move(column, row)
        page.keyboard.press("b")
        until(page, "viewer.cloths[0].solids.ball.faces.length > 100")
        bodies = at.show.simulations[0].bodies
        assert len(bodies) == 3
        page.click("#throw")
        until(page, "viewer.picture.arrays.ball0 && viewer.cloths[0].solids.middle(2)[2] > 0")
        page.click("#reset")
        until(page, "viewer.cloths[0].solids.ball.faces.length === 0")
        page.close()
    assert faults == []


def test_bodies_stand_and_move_where_the_engine_has_them(browser: Browser, flag: dict[str, Any]) -> None:
    flag["body"] = [
        {"name": "ball", "sphere": {"center": [0.7, -0.8, 0.6], "radius": 0.4}, "move": [[1, [0.6, 0, 0]]]},
        {"name": "floor", "plane": {"normal": [0, 0, 1]}},
        {"name": "wall", "plane": {"normal": [0, -1, 0], "point": [0, 2, 0]}},
    ]
    with viewing(LiveShow(Scene(flag))) as at:
        page = browser.new_page(viewport={"width": 960, "height": 600})
        page.goto(at.url)
        until(page, "Boolean(window.viewer && viewer.picture && viewer.picture.frame > 5)")
        pause(page, at)
        for x in (None, 0.7):
            if x is not None:
                page.click("#reset")
                until(page, "viewer.picture.frame === 0 && !viewer.stale")
            shown = np.float32(page.evaluate("[...viewer.cloths[0].solids.bodies.positions]")).reshape(-1, 3)
            body = at.show.simulations[0].bodies["ball"]
            middle = body.positions[0]
            assert x is None or middle[0] == x
            np.testing.assert_allclose(np.linalg.norm(shown - middle, axis=1), body.radius, atol=1e-5)
            column, row = projected(page, middle[None])[0].astype(int)
            colour = pixels(page)[row, column].astype(int)
            assert colour[2] > colour[0] + 8 and colour.max() < 220, (
                "the ball is grey-blue and before the cloth"
            )
        assert page.evaluate("viewer.look.floor") == 0
        page.close()
