"""See and touch it: a page in the browser, behind it a running scene or recordings."""

from taut.view.server import Server, listen
from taut.view.show import Show

__all__ = ["Server", "Show", "listen"]
