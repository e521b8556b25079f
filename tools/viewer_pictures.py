"""`make viewer-pictures`: docs/pictures/viewer*.jpg, taken from the page of `taut view` in Chromium."""

import shutil
import subprocess
import sys
import time
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs" / "pictures"
TAUT = Path(sys.executable).with_name("taut")
COMMAND = (
    TAUT,
    "view",
    "flag",
    "--no-browser",
    "--port",
    "0",
    "--set",
    "cloth.flag.grid.cells=[64,64]",
)
PULLED = 40 * 65 + 48
"""A vertex in the right half of the flag."""


def opened(browser: Browser, url: str, width: int, height: int, density: float) -> Page:
    """A page that shows the cloth."""
    page = browser.new_page(viewport={"width": width, "height": height}, device_scale_factor=density)
    page.goto(url)
    until(page, "Boolean(window.viewer && viewer.picture)")
    return page


def until(page: Page, condition: str) -> None:
    """Wait for a minute at most."""
    end = time.monotonic() + 60
    while not page.evaluate(condition):
        if time.monotonic() > end:
            raise TimeoutError(condition)


def save(page: Page, name: str) -> None:
    """Write what the page looks like."""
    image = Image.open(BytesIO(page.screenshot())).convert("RGB")
    image.save(PICTURES / name, quality=88, optimize=True)


def desktop(browser: Browser, url: str) -> None:
    """Two flags, one without the limit, pulled by one hand."""
    page = opened(browser, url, 1280, 760, 1)
    page.click("#compare")
    page.click("[data-colour=grid]")
    until(page, "viewer.cloths.length === 2 && viewer.picture.time > 3")
    x, y = page.evaluate(f"viewer.where({PULLED})")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 90, y - 100, steps=10)
    start = page.evaluate("viewer.picture.time")
    until(page, f"viewer.picture.time > {start} + 1.2")
    save(page, "viewer.jpg")
    page.mouse.up()
    page.click("#compare")
    until(page, "viewer.cloths.length === 1")
    page.close()


def ball(browser: Browser, url: str) -> None:
    """A ball in the flag, and where it touches it."""
    page = opened(browser, url, 1280, 760, 1)
    page.click("#touches")
    page.evaluate("viewer.send('speed', { value: 0.1 })")
    x, y = page.evaluate(f"viewer.where({PULLED})")
    page.mouse.move(x, y)
    page.keyboard.press("b")
    until(page, "viewer.cloths[0].solids.touches.length > 60")
    page.evaluate("viewer.send('play', { on: false })")
    until(page, "!viewer.status.playing")
    # From the side, where the ball does not hide what it does.
    page.evaluate("viewer.camera.orbit(-95, 0), viewer.redraw()")
    page.mouse.move(2, 2)
    page.wait_for_timeout(1000)
    save(page, "viewer-ball.jpg")
    page.click("#touches")
    page.evaluate("viewer.send('speed', { value: 1 })")
    page.click("#reset")
    page.click("#play")
    page.close()


def phone(browser: Browser, url: str) -> None:
    """The flag on a small window."""
    page = opened(browser, url, 390, 780, 1.5)
    start = page.evaluate("viewer.picture.time")
    until(page, f"viewer.picture.time > {start} + 3")
    save(page, "viewer-phone.jpg")
    page.close()


def main() -> None:
    """Starts the viewer and takes all pictures."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        sys.exit("no chromium here: install Debian's `chromium`, or Chrome")
    software = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
    with (
        subprocess.Popen(COMMAND, stdout=subprocess.PIPE, text=True, cwd=ROOT) as viewer,
        sync_playwright() as playwright,
    ):
        try:
            assert viewer.stdout is not None
            url = viewer.stdout.readline().split()[0]
            browser = playwright.chromium.launch(executable_path=chromium, args=software)
            desktop(browser, url)
            ball(browser, url)
            phone(browser, url)
            browser.close()
        finally:
            viewer.terminate()


if __name__ == "__main__":
    main()
