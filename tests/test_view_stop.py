"""The viewer stops within about a second, whatever a frame costs and whatever pages do."""

import re
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from taut import Scene
from taut.view import Show
from taut.view.live import LiveShow
from viewing import Viewing, order, viewing

SOON = 3.0
"""About a second, on a machine that is busy [s]; waiting for any of what is here takes far longer."""

FRAME_OF_A_MINUTE = """\
fps = 0.05
duration = 200
[solver]
substeps = 100000
[[cloth]]
name = "flag"
grid = { size = [1.5, 1.0], cells = [90, 90], origin = [0, 0, 1], axes = ["x", "z"] }
pins = [{ edge = "left" }]
"""


class Slow(Show):
    """A frame of it takes until a test lets it go; its layout does not fit into what a socket buffers."""

    def __init__(self) -> None:
        super().__init__()
        self.board.layout = bytes(2**25)
        self.let_go = threading.Event()

    def _run(self) -> None:
        self.let_go.wait(60)


def upgraded(at: Viewing) -> socket.socket:
    """A page that never reads what it is sent."""
    here = f"127.0.0.1:{at.port}"
    page = socket.create_connection(("127.0.0.1", at.port), timeout=20)
    page.sendall(
        f"GET /socket HTTP/1.1\r\nHost: {here}\r\nOrigin: http://{here}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
    )
    assert page.recv(12) == b"HTTP/1.1 101"
    return page


@pytest.mark.parametrize("pages", [0, 3])
def test_neither_a_slow_frame_nor_a_deaf_page_holds_the_end_up(pages: int) -> None:
    show = Slow()
    with viewing(show) as at:
        deaf = [upgraded(at) for _ in range(pages)]
        time.sleep(0.2 * pages)  # what it is sent must fill its buffers
        start = time.monotonic()
    assert time.monotonic() - start < SOON
    assert show.is_running
    show.let_go.set()
    show.stop()
    assert not show.is_running
    for page in deaf:
        page.close()


def test_what_is_being_built_does_not_hold_the_end_up(
    flag: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    show, let_go = LiveShow(Scene(flag), threads=1), threading.Event()
    monkeypatch.setattr("taut.view.live.build", lambda *_: let_go.wait(60))
    with viewing(show):
        order(show, {"type": "set", "control": "gravity", "value": 3})
        while not show.is_building:
            time.sleep(0.01)
        start = time.monotonic()
    assert time.monotonic() - start < SOON
    assert show.is_running
    let_go.set()


def test_the_command_stops_in_a_frame_of_a_minute(tmp_path: Path) -> None:
    scene = tmp_path / "slow.toml"
    scene.write_text(FRAME_OF_A_MINUTE)
    command = [sys.executable, "-m", "taut", "view", str(scene), "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stderr is not None
        assert re.search(r"http://127\.0\.0\.1:\d+/", process.stdout.readline())
        time.sleep(0.5)  # it is in its first frame
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 0
        assert time.monotonic() - start < SOON
        assert process.stderr.read() == ""
