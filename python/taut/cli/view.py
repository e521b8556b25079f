"""``taut view``."""

import contextlib
import os
import signal
import socket
import sys
import threading
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taut.cli.arguments import Sandbox, complete_scene
from taut.cli.console import BAD_INPUT, expected_errors, fail, warn

if TYPE_CHECKING:
    from taut.view import Show

PORT = 8420


def command(
    what: Annotated[
        list[Path],
        typer.Argument(
            help="A scene to run, or caches to play side by side.",
            metavar="SCENE | CACHE.zarr ..",
            autocompletion=complete_scene,
        ),
    ],
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any that is free.")] = PORT,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="Change a field of the scene: solver.filter=none.", metavar="PATH=VALUE"),
    ] = None,
    threads: Annotated[int | None, typer.Option(min=1, max=1024, help="Default: all cores.")] = None,
    sandbox: Sandbox = False,
) -> None:
    """See and touch a running scene, or play what was recorded, in a page of the browser."""
    with expected_errors():
        show = _show(what, settings or [], threads, sandbox)
    import asyncio

    from taut.view import Server, listen

    try:
        listening = listen(port)
    except OSError as error:
        raise fail(
            f"port {port} of this machine cannot be used ({error.strerror}); try --port 0", BAD_INPUT
        ) from None
    port = listening.getsockname()[1]
    url = f"http://127.0.0.1:{port}/"

    def ready() -> None:
        typer.echo(f"{url} shows it; Ctrl-C stops it")
        tunnel = f"ssh -L {port}:127.0.0.1:{port} {socket.gethostname()}"
        typer.echo(f"from another machine: {tunnel}, then the same address there")
        if browser:  # in a thread: a browser of the terminal does not return
            threading.Thread(target=webbrowser.open, args=[url], daemon=True).start()

    async def serve() -> None:
        stop = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            with contextlib.suppress(NotImplementedError):  # Windows
                asyncio.get_running_loop().add_signal_handler(number, stop.set)
        await Server(show).run(listening, ready, stop)

    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(serve())
    if show.is_running:  # Python would wait for a frame that takes long, of which nothing is kept
        sys.stdout.flush()
        os._exit(0)


def _show(what: list[Path], settings: list[str], threads: int | None, sandbox: bool) -> "Show":
    recorded = [path.is_dir() for path in what]
    if all(recorded):
        if settings:
            raise fail("--set changes a scene, but this is a recording; run the scene again", BAD_INPUT)
        from taut.cache import Cache
        from taut.view.playback import PlaybackShow

        return PlaybackShow([Cache.open(path) for path in what])
    if len(what) > 1:
        raise fail(
            "a single scene runs at a time; side by side stand only recordings (CACHE.zarr)", BAD_INPUT
        )
    from taut.scene import Scene
    from taut.view.live import LiveShow

    show = LiveShow(Scene.load(what[0], sandbox).with_settings(settings), threads)
    warn(show.simulations[0].warnings)
    return show
