"""A viewer that runs in this process, and messages as its page reads them."""

import asyncio
import json
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from taut.view import Server, Show, listen, wire
from taut.view.live import LiveShow


@dataclass
class Viewing:
    """Where the pages of a show are."""

    show: Any
    port: int

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}/"


@contextmanager
def viewing(show: Show) -> Iterator[Viewing]:
    """Serve a show on a free port."""
    listening = listen(0)
    ready = threading.Event()
    running: list[tuple[asyncio.AbstractEventLoop, asyncio.Event]] = []

    async def serve() -> None:
        stop = asyncio.Event()
        running.append((asyncio.get_running_loop(), stop))
        await Server(show).run(listening, ready.set, stop)

    thread = threading.Thread(target=lambda: asyncio.run(serve()))
    thread.start()
    try:
        assert ready.wait(20)
        yield Viewing(show, listening.getsockname()[1])
    finally:
        loop, stop = running[0]
        loop.call_soon_threadsafe(stop.set)
        thread.join(20)
    assert not thread.is_alive()


def unpack(message: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """A header and its arrays."""
    (length,) = struct.unpack_from("<I", message)
    header = json.loads(message[4 : 4 + length])
    at, arrays = 4 + length, {}
    for listed in header["arrays"]:
        kind = {"float32": "<f4", "int32": "<i4"}[listed["type"]]
        count = int(np.prod(listed["shape"]))
        arrays[listed["name"]] = np.frombuffer(message, kind, count, at).reshape(listed["shape"])
        at += 4 * count
    assert at == len(message)
    return header, arrays


def settle(show: LiveShow, turns: int = 1) -> None:
    """Let a show take over what was changed, and then simulate so many frames."""
    show.turn()
    while show.is_building:
        time.sleep(0.001)
        show.turn()
    for _ in range(turns):
        show.turn()


def order(show: Any, text: dict[str, Any], client: int = 1) -> None:
    show.mail.put(client, wire.parse(json.dumps(text)))


def status(show: Any) -> dict[str, Any]:
    return json.loads(show.board.status[1])


def value(show: LiveShow, name: str) -> float | str:
    return next(control["value"] for control in status(show)["controls"] if control["name"] == name)


def picture(show: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    return unpack(show.board.picture[1])
