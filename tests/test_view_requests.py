"""Whatever bytes come to the viewer: an answer that says no, nothing on the terminal, and it goes on."""

import logging
import random
import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from taut.view import Show
from taut.view.live import LiveShow
from viewing import Viewing, viewing

REQUESTS = 500
WORDS = [b"\r\n", b"\0", b"A" * 9000, b"Content-Length: -1\r\n", b":", b"HTTP/9.9", b" ", b"\xb9\xff"]
WORDS += [b"\r\nContent-Length: 9\r\n", b"\r\nTransfer-Encoding: chunked\r\n", b"\x16\x03\x01", b"%zz", b"["]


@contextmanager
def quietly(caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]) -> Iterator[None]:
    """Nothing is logged that would be seen, and nothing is printed."""
    capfd.readouterr()
    with caplog.at_level(logging.WARNING):
        yield
    assert caplog.text == ""
    assert capfd.readouterr() == ("", "")


def usual(at: Viewing) -> list[bytes]:
    """Requests of a page, and one of other tools."""
    host = f"Host: 127.0.0.1:{at.port}\r\n"
    socket_asked = (
        f"Origin: http://127.0.0.1:{at.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    chunked = "Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n5\r\nhello\r\n0\r\n\r\n"
    texts = [
        f"GET /main.js HTTP/1.1\r\n{host}Connection: close\r\n\r\n",
        f"POST / HTTP/1.1\r\n{host}Content-Length: 5\r\nConnection: close\r\n\r\nhello",
        f"POST / HTTP/1.1\r\n{host}{chunked}",
        f"GET /socket HTTP/1.1\r\n{host}{socket_asked}",
    ]
    frame = b"\x81\x85\x01\x02\x03\x04abcde"
    return [text.encode() for text in texts] + [texts[3].encode() + frame]


def mutated(request: bytes, dice: random.Random) -> bytes:
    data = bytearray(request)
    for _ in range(dice.choice([1, 1, 2, 5])):
        at = dice.randrange(len(data) + 1)
        match dice.randrange(4):
            case 0:
                data[at : at + 1] = bytes([dice.randrange(256)])
            case 1 if len(data) > 20:
                del data[at : at + dice.randrange(1, 10)]
            case 2:
                data[at:at] = dice.randbytes(dice.randrange(1, 20))
            case _:
                data[at:at] = dice.choice(WORDS)
    return bytes(data)


def answer(at: Viewing, request: bytes, patience: float = 60) -> bytes:
    """What comes back first; nothing where the viewer hangs up, or waits for more until patience [s] ends."""
    with socket.create_connection(("127.0.0.1", at.port), patience) as page:
        try:
            page.sendall(request)
            return page.recv(4096)
        except (TimeoutError, ConnectionError):
            return b""


def test_requests_without_sense_are_refused_silently(
    show: LiveShow, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    dice, statuses = random.Random(1), set()
    with quietly(caplog, capfd), viewing(show) as at:
        requests = usual(at)
        for _ in range(REQUESTS):
            request = mutated(dice.choice(requests), dice)
            said = answer(at, request, 0.1)
            status = re.match(rb"HTTP/\d\.\d (\d+) ", said)
            assert status or said == b"", (request, said)
            if status:
                statuses.add(int(status[1]))
            assert statuses <= {101, 200, 400, 403, 404, 405, 413, 417, 426}, (request, said)
        assert answer(at, requests[0]).startswith(b"HTTP/1.1 200")
        assert {101, 200, 400, 403, 404, 405} <= statuses


@pytest.mark.parametrize(
    "header",
    [b"Upgrade: \xb9", b"Sec-WebSocket-Key: \xb1", b"Sec-WebSocket-Key: ab", b"Sec-WebSocket-Version: \xff"],
)
def test_a_header_that_is_no_text_is_refused_silently(
    show: LiveShow, header: bytes, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    name = header.split(b":")[0]
    with quietly(caplog, capfd), viewing(show) as at:
        request = re.sub(name + rb": [^\r]*", lambda _: header, usual(at)[3])
        assert answer(at, request).startswith(b"HTTP/1.1 400")


def test_pages_that_are_gone_before_the_answer_are_no_news(
    show: LiveShow, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    with quietly(caplog, capfd), viewing(show) as at:
        for request in 20 * usual(at):
            socket.create_connection(("127.0.0.1", at.port)).close()
            with socket.create_connection(("127.0.0.1", at.port)) as page:
                page.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
                page.sendall(request)
        assert answer(at, usual(at)[0]).startswith(b"HTTP/1.1 200")


async def broken(*_: object) -> None:
    raise RuntimeError("a mistake of the viewer")


def test_a_mistake_of_the_viewer_is_still_told(
    show: Show, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("taut.view.Server._file", broken)
    with viewing(show) as at:
        assert answer(at, usual(at)[0]).startswith(b"HTTP/1.1 500")
    assert "a mistake of the viewer" in caplog.text
