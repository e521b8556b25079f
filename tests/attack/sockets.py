"""Bytes to the port of the viewer."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import threading
from random import Random
from typing import Any, ClassVar

import aiohttp
from taut import Scene
from taut.view import Server, listen
from taut.view.live import LiveShow

from tests.attack.edits import edit, edited
from tests.attack.frame import Attack, Case, Outcome
from tests.attack.orders import SCENES, WORDS, order

REQUESTS = [
    "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "GET /main.js HTTP/1.1\r\nHost: localhost\r\nRange: bytes=0-9\r\n\r\n",
    "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n012345678",
    "POST / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nabcde\r\n0\r\n\r\n",
    "GET /socket HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n\x81\x85\x01\x02\x03\x04hello",
]
ODD = [
    b"../../etc/passwd",
    b"%2e%2e/",
    b"\x00",
    b"\r\n\r\n",
    b"\xff\xfe",
    b"Content-Length: -1\r\n",
    b"A" * 9000,
    b"HTTP/9",
]
PATIENCE = 10.0
"""How long the viewer may take for an answer [s]."""


class Sockets(Attack):
    """Requests and messages of a socket, well formed and not."""

    name: ClassVar[str] = "sockets"
    promise: ClassVar[str] = "bytes to the viewer's port: it goes on serving, and prints nothing"
    unit: ClassVar[str] = "messages"
    short: ClassVar[int] = 40

    def __init__(self) -> None:
        """Prepare; the viewer starts with the first case."""
        self._port = 0

    def generate(self, random: Random) -> Case:
        """Requests with mistakes, or what a page says on an open socket."""
        if random.random() < 0.6:
            requests = []
            for _ in range(random.randint(1, 4)):
                mistakes = [edit(random, ODD) for _ in range(random.randint(0, 3))]
                requests.append(edited(random.choice(REQUESTS).encode("latin-1"), mistakes))
            return {"requests": requests, "messages": []}
        messages: list[Any] = []
        for _ in range(random.randint(1, 30)):
            text = json.dumps(order(random)).encode()
            mistakes = [edit(random, WORDS) for _ in range(random.choice([0, 0, 1, 3]))]
            messages.append(["bytes" if random.random() < 0.1 else "text", edited(text, mistakes)])
        return {"requests": [], "messages": messages}

    def judge(self, case: Case) -> Outcome:
        """Send it, then see whether the viewer still answers."""
        if not self._port:
            self._serve()
        for request in case["requests"]:
            with socket.create_connection(("127.0.0.1", self._port), PATIENCE) as open_socket:
                open_socket.sendall(request)
                open_socket.shutdown(socket.SHUT_WR)
                open_socket.settimeout(0.05)
                try:
                    while open_socket.recv(1 << 16):
                        pass
                except (TimeoutError, ConnectionError):
                    pass
        failure = asyncio.run(self._talk(case["messages"]))
        return Outcome(failure, looked_at=len(case["requests"]) + len(case["messages"]))

    def _serve(self) -> None:
        listening, ready = listen(0), threading.Event()
        server = Server(LiveShow(Scene(SCENES[0]), threads=1))
        serving = server.run(listening, ready.set, asyncio.Event())
        threading.Thread(target=asyncio.run, args=[serving], daemon=True).start()
        if not ready.wait(PATIENCE):
            raise RuntimeError("the viewer does not start")
        self._port = listening.getsockname()[1]

    async def _talk(self, messages: list[Any]) -> str:
        url = f"http://127.0.0.1:{self._port}/"
        page_of = {"Origin": url.rstrip("/")}
        async with aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(PATIENCE)) as session:
            if messages:
                async with session.ws_connect(f"{url}socket", headers=page_of, max_msg_size=0) as page:
                    for kind, content in messages:
                        with contextlib.suppress(ConnectionError):  # it may send the page away
                            if kind == "text":
                                await page.send_str(content.decode(errors="replace"))
                            else:
                                await page.send_bytes(content)
            async with session.get(url) as page_itself:
                if page_itself.status != 200:
                    return f"the page is answered with status {page_itself.status}"
            async with session.ws_connect(f"{url}socket", headers=page_of, max_msg_size=0) as page:
                first = await page.receive(PATIENCE)
                if first.type not in (aiohttp.WSMsgType.BINARY, aiohttp.WSMsgType.TEXT):
                    return f"a new page is sent {first.type.name} instead of what is shown"
        return ""
