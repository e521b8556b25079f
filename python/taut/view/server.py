"""Serves the page and its socket on the loopback interface of this machine, to nobody else."""

import asyncio
import contextlib
import itertools
import logging
import socket
from collections.abc import Awaitable, Callable
from functools import partial
from urllib.parse import urlsplit

from aiohttp import WSCloseCode, WSMsgType, http_exceptions, web

from taut.view.board import Client
from taut.view.page_files import page_files
from taut.view.show import Show
from taut.view.wire import LONGEST_ORDER, OrderError, Seen, parse

HOST = "127.0.0.1"
MOST_PAGES = 32
"""Pages that can be open at once."""
_HOSTS = {"127.0.0.1", "localhost", "::1"}
_FAREWELL = 0.2
"""How long pages and requests have to end when the viewer is stopped [s]."""
_AHEAD = 2
"""Pictures on the way to a page before it has said that it drew one."""
_MOST_FAULTS = 50
"""Messages that make no sense, after which a page is sent away."""
_SAFE = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob:; media-src blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-cache",
}

_LOG = logging.getLogger("taut.view")


def _is_ours(record: logging.LogRecord) -> bool:
    """Whether a mistake is the viewer's: requests without sense, and pages that are gone, are no news."""
    error = record.exc_info[1] if record.exc_info else None
    return not isinstance(error, http_exceptions.HttpProcessingError | ConnectionError)


_LOG.addFilter(_is_ours)


class Server:
    """The pages of one show."""

    def __init__(self, show: Show) -> None:
        """Serve `show`; :meth:`run` starts it."""
        self._show = show
        self._files = page_files()
        self._numbers = itertools.count(1)
        self._new: set[asyncio.Event] = set()
        self._sockets: set[web.WebSocketResponse] = set()

    async def run(self, listening: socket.socket, ready: Callable[[], None], stop: asyncio.Event) -> None:
        """Serve until `stop` is set.

        Args:
            listening: a bound socket.
            ready: called when pages can be opened.
            stop: ends it.
        """
        loop = asyncio.get_running_loop()
        self._show.board.listen(partial(loop.call_soon_threadsafe, self._wake))
        app = web.Application(middlewares=[only_from_here], client_max_size=LONGEST_ORDER)
        app.router.add_get("/socket", self._socket)
        app.router.add_get("/{name:.*}", self._file)
        runner = web.AppRunner(app, access_log=None, logger=_LOG, shutdown_timeout=_FAREWELL)
        await runner.setup()
        await web.SockSite(runner, listening).start()
        self._show.start()
        try:
            ready()
            await stop.wait()
        finally:
            self._show.board.listen(None)
            await asyncio.gather(self._dismiss_pages(), loop.run_in_executor(None, self._show.stop))
            await runner.cleanup()

    async def _dismiss_pages(self) -> None:
        code, reason = WSCloseCode.GOING_AWAY, b"the viewer was stopped"
        closing = [asyncio.create_task(page.close(code=code, message=reason)) for page in self._sockets]
        if closing:
            _, deaf = await asyncio.wait(closing, timeout=_FAREWELL)
            for farewell in deaf:  # such a page does not read what it was sent before
                farewell.cancel()

    def _wake(self) -> None:
        for event in self._new:
            event.set()

    async def _file(self, request: web.Request) -> web.Response:
        file = self._files.get(request.path)
        if file is None:
            raise web.HTTPNotFound(text="There is no such page.", headers=_SAFE)
        return web.Response(body=file.content, headers={**_SAFE, "Content-Type": file.type})

    async def _socket(self, request: web.Request) -> web.WebSocketResponse:
        if len(self._sockets) >= MOST_PAGES:
            raise web.HTTPServiceUnavailable(text=f"{MOST_PAGES} pages are open; close one.")
        page = web.WebSocketResponse(max_msg_size=LONGEST_ORDER, compress=False, heartbeat=20.0)
        try:
            await page.prepare(request)
        except ValueError:  # it decodes headers, and repeats some of them, that may be no text
            raise web.HTTPBadRequest(text="This is no request for a socket.", headers=_SAFE) from None
        client, new, drawn = next(self._numbers), asyncio.Event(), _Drawn()
        new.set()
        self._sockets.add(page)
        self._new.add(new)
        sending = asyncio.create_task(self._send(page, new, drawn))
        try:
            with contextlib.suppress(ConnectionError):  # it went while it was being answered
                await self._listen(page, client, new, drawn)
        finally:
            sending.cancel()
            self._new.discard(new)
            self._sockets.discard(page)
            self._show.leave(client)
            await asyncio.gather(sending, return_exceptions=True)
        return page

    async def _listen(
        self, page: web.WebSocketResponse, client: Client, new: asyncio.Event, drawn: "_Drawn"
    ) -> None:
        faults = 0
        async for message in page:
            if message.type is not WSMsgType.TEXT:
                break
            try:
                order = parse(message.data)
            except OrderError as error:
                faults += 1
                if faults > _MOST_FAULTS:
                    await page.close(
                        code=WSCloseCode.POLICY_VIOLATION, message=b"too many messages without sense"
                    )
                    break
                await page.send_json({"type": "refused", "text": str(error)})
                continue
            if isinstance(order, Seen):
                drawn.number = max(drawn.number, order.number)
                new.set()
            else:
                self._show.mail.put(client, order)

    async def _send(self, page: web.WebSocketResponse, new: asyncio.Event, drawn: "_Drawn") -> None:
        """Send what is new, the latest only, and no more pictures than the page can draw."""
        board = self._show.board
        await page.send_bytes(board.layout)
        status, sent = 0, [0] * _AHEAD
        while not page.closed:
            await new.wait()
            new.clear()
            if board.status[0] != status:
                status, text = board.status
                await page.send_str(text)
            number, picture = board.picture
            if number != sent[-1] and sent[0] <= drawn.number:
                sent = [*sent[1:], number]
                await page.send_bytes(picture)


class _Drawn:
    """Number of the last picture that a page has drawn."""

    number = 0


@web.middleware
async def only_from_here(
    request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
) -> web.StreamResponse:
    """Refuse what other sites make a browser ask: their names stand in Host or Origin.

    A page elsewhere can point a name of its own at 127.0.0.1, or open a socket to it; both say so in their
    requests. A socket must name an origin, for every browser does.
    """
    host, origin = request.headers.get("Host", ""), request.headers.get("Origin")
    connection = " ".join(request.headers.getall("Connection", []))
    socket_asked = request.path == "/socket" or "upgrade" in connection.lower()
    if _name(f"http://{host}") not in _HOSTS:
        raise web.HTTPForbidden(text="This viewer answers to 127.0.0.1 and localhost only.", headers=_SAFE)
    if (origin is None and socket_asked) or (origin is not None and origin != f"http://{host}"):
        raise web.HTTPForbidden(text="This viewer answers to its own page only.", headers=_SAFE)
    return await handler(request)


def _name(url: str) -> str | None:
    try:
        return urlsplit(url).hostname
    except ValueError:
        return None


def listen(port: int) -> socket.socket:
    """A socket on the loopback interface.

    Args:
        port: 0 for any that is free.

    Raises:
        OSError: the port is taken.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((HOST, port))
        listening.listen(64)
    except OSError:
        listening.close()
        raise
    return listening
