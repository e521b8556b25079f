"""See and touch it: a page in the browser, behind it a running scene or recordings."""

from taut.view.server import Server, Show, listen

__all__ = ["Server", "Show", "listen"]
