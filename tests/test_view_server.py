"""The viewer's server, which strangers and slow pages cannot disturb, and the command."""

import asyncio
import json
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from taut.view.live import LiveShow
from viewing import Viewing, picture, unpack, viewing

HOLD = 20
"""A free vertex of the flag."""


def origin(served: Viewing) -> dict[str, str]:
    return {"Origin": served.url.rstrip("/")}


def request(path: str, port: int) -> bytes:
    """A request as no client would send it: its path is not tidied up."""
    return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n".encode()


async def opened(session: aiohttp.ClientSession, served: Viewing) -> aiohttp.ClientWebSocketResponse:
    return await session.ws_connect(served.url + "socket", headers=origin(served), max_msg_size=0)


async def frames_go_on(served: Viewing, by: int = 3) -> None:
    start = picture(served.show)[0]["frame"]
    async with asyncio.timeout(20):
        while picture(served.show)[0]["frame"] < start + by:
            await asyncio.sleep(0.01)


def served(work: Callable[[Viewing, aiohttp.ClientSession], Any]) -> Callable[[LiveShow], None]:
    """A test of a show that is served."""

    def test(show: LiveShow) -> None:
        async def run(at: Viewing) -> None:
            async with aiohttp.ClientSession() as session:
                await work(at, session)

        with viewing(show) as at:
            asyncio.run(run(at))

    test.__name__ = work.__name__
    return test


@served
async def test_strangers_are_refused(at: Viewing, session: aiohttp.ClientSession) -> None:
    here = f"127.0.0.1:{at.port}"
    for host, came_from, expected in [
        (here, None, 200),
        (f"localhost:{at.port}", None, 200),
        (f"[::1]:{at.port}", None, 200),
        ("localhost:9000", "http://localhost:9000", 200),
        (here, f"http://{here}", 200),
        ("evil.example", None, 403),
        (f"127.0.0.1.evil.example:{at.port}", None, 403),
        ("[::1", None, 403),
        ("", None, 403),
        (here, "http://evil.example", 403),
        (here, "http://localhost:3000", 403),
        (here, "null", 403),
    ]:
        headers = {"Host": host} | ({"Origin": came_from} if came_from else {})
        async with session.get(at.url, headers=headers) as answer:
            assert answer.status in ({expected, 400} if expected == 403 else {expected}), (host, came_from)
        if expected == 403 or came_from is None:
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await session.ws_connect(at.url + "socket", headers=headers)
    async with await opened(session, at) as page:
        assert unpack((await page.receive()).data)[0]["type"] == "layout"


@served
async def test_nothing_but_the_page_is_served(at: Viewing, session: aiohttp.ClientSession) -> None:
    assert at.port != 0
    for path in [
        "/server.py",
        "/../server.py",
        "/%2e%2e/server.py",
        "/..%2fserver.py",
        "/page/main.js",
        "//etc/passwd",
        "/../../../../../../etc/passwd",
        "/main.js/../../wire.py",
        "/main.js%00",
    ]:
        reader, writer = await asyncio.open_connection("127.0.0.1", at.port)
        writer.write(
            f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{at.port}\r\nConnection: close\r\n\r\n".encode()
        )
        answer = await reader.read()
        writer.close()
        assert answer.split()[1] in {b"404", b"400"} and b"import" not in answer, path
    async with session.get(at.url + "main.js") as answer:
        assert answer.content_type == "text/javascript" and "Viewer" in await answer.text()
        assert "default-src 'self'" in answer.headers["Content-Security-Policy"]
    async with session.post(at.url, data=b"x") as answer:
        assert answer.status == 405


@served
async def test_a_socket_without_an_origin_is_refused_however_it_asks(
    at: Viewing, session: aiohttp.ClientSession
) -> None:
    for connection in ("Connection: Upgrade\r\n", "Connection:\r\nConnection: Upgrade\r\n", ""):
        reader, writer = await asyncio.open_connection("127.0.0.1", at.port)
        head = f"GET /socket HTTP/1.1\r\nHost: 127.0.0.1:{at.port}\r\nUpgrade: websocket\r\n{connection}"
        writer.write(f"{head}Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {'A' * 22}==\r\n\r\n".encode())
        assert (await reader.readline()).split()[1] == b"403", connection
        writer.close()


@served
async def test_messages_without_sense_stop_nobody(at: Viewing, session: aiohttp.ClientSession) -> None:
    async with await opened(session, at) as page:
        for _ in range(10_000):
            try:
                await page.send_str('{"type": "grab", "vertex": "all"}')
            except ConnectionError:
                break
        async with asyncio.timeout(20):
            while (message := await page.receive()).type not in {
                aiohttp.WSMsgType.CLOSE,
                aiohttp.WSMsgType.CLOSED,
            }:
                pass
        assert page.close_code == 1008 or message.data == 1008
    for huge in ["x" * 100_000, '{"type": "set", "control": "' + "w" * 5000 + '", "value": 1}']:
        async with await opened(session, at) as page:
            await page.send_str(huge)
            async with asyncio.timeout(20):
                while not page.closed:
                    await page.receive()
            assert page.close_code == 1009
    async with await opened(session, at) as page:
        await page.send_bytes(b"\x00" * 100)
        async with asyncio.timeout(20):
            while not page.closed:
                await page.receive()
    await frames_go_on(at)


@served
async def test_ten_thousand_orders_are_obeyed_and_the_simulation_goes_on(
    at: Viewing, session: aiohttp.ClientSession
) -> None:
    async with await opened(session, at) as page:
        for number in range(10_000):
            await page.send_json({"type": "set", "control": "gravity", "value": number % 30})
            if number % 100 == 0:
                await page.send_json({"type": "seen", "number": 2**31 - 1})
        await page.send_json({"type": "set", "control": "gravity", "value": 7.5})
        async with asyncio.timeout(30):
            while at.show.simulations[0].scene.document["gravity"] != [0, 0, -7.5]:
                await asyncio.sleep(0.01)
        await frames_go_on(at)


@served
async def test_ten_pages_come_and_go(at: Viewing, session: aiohttp.ClientSession) -> None:
    for _ in range(2):
        pages = [await opened(session, at) for _ in range(10)]
        for page in pages:
            kinds = [(await page.receive()) for _ in range(3)]
            assert unpack(kinds[0].data)[0]["type"] == "layout"
            assert json.loads(kinds[1].data)["type"] == "status"
            assert unpack(kinds[2].data)[0]["type"] == "picture"
        await pages[0].send_json({"type": "grab", "vertex": HOLD, "target": [1, 0, 1]})
        async with asyncio.timeout(20):
            while HOLD not in picture(at.show)[0]["held"]:
                await asyncio.sleep(0.01)
        for number, page in enumerate(pages):
            if number % 2:
                await page.close()
            else:
                page._writer.transport.abort()  # a tab that is killed says nothing
        async with asyncio.timeout(20):
            while picture(at.show)[0]["held"]:
                await asyncio.sleep(0.01)
        await frames_go_on(at)


@served
async def test_a_slow_page_misses_pictures_and_holds_nobody_up(
    at: Viewing, session: aiohttp.ClientSession
) -> None:
    async with await opened(session, at) as slow:
        numbers: list[int] = []

        async def read(seconds: float) -> None:
            while True:
                try:
                    message = await slow.receive(timeout=seconds)
                except TimeoutError:
                    return
                if message.type is aiohttp.WSMsgType.BINARY:
                    header, _ = unpack(message.data)
                    numbers.extend([header["number"]] if header["type"] == "picture" else [])

        await read(0.5)
        assert len(numbers) == 2, "two are on the way, and no more until one is drawn"
        await frames_go_on(at, 20)
        await slow.send_json({"type": "seen", "number": numbers[-1]})
        await read(0.5)
        assert len(numbers) == 4 and numbers[2] >= numbers[1] + 20, "the next one is the latest"


def test_only_this_machine_is_listened_to(show: LiveShow) -> None:
    with viewing(show) as at:
        for address in {
            info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)
        }:
            if not str(address).startswith("127."):
                with pytest.raises(OSError), socket.create_connection((address, at.port), timeout=5):
                    pass


def test_the_command_serves_and_stops(flag_file: Path) -> None:
    command = [sys.executable, "-m", "taut", "view", str(flag_file), "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        first, second = process.stdout.readline(), process.stdout.readline()
        port = int(re.search(r"http://127\.0\.0\.1:(\d+)/", first)[1])  # type: ignore[index]
        assert f"ssh -L {port}:127.0.0.1:{port}" in second
        with socket.create_connection(("127.0.0.1", port)) as connection:
            connection.sendall(
                f"GET / HTTP/1.1\r\nHost: localhost:{port}\r\nConnection: close\r\n\r\n".encode()
            )
            assert connection.recv(100).startswith(b"HTTP/1.1 200")
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0


def test_the_command_says_what_it_cannot_show(
    taut: Callable[..., Any], flag_file: Path, recorded: Path
) -> None:
    assert taut("view", "--no-browser", "nowhere.toml").status == 2
    both = taut("view", "--no-browser", flag_file, recorded)
    assert both.status == 2 and "single scene" in both.err
    changed = taut("view", "--no-browser", recorded, "--set", "fps=30")
    assert changed.status == 2 and "recording" in changed.err
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        refused = taut("view", "--no-browser", flag_file, "--port", port)
    assert refused.status == 2 and str(port) in refused.err and "--port 0" in refused.err
