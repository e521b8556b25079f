"""What is shown, in a thread of its own: what running scenes and recordings have in common."""

import threading
from abc import ABC, abstractmethod

from taut.view.board import Board, Client, Mailbox
from taut.view.wire import Contacts, Play, Release

_PATIENCE = 0.5
"""How long an end waits for the frame in hand [s]."""


class Show(ABC):
    """A thread that takes orders from a mailbox and leaves pictures on a board."""

    def __init__(self) -> None:
        """Prepare the thread; :meth:`start` lets it run."""
        self.board, self.mail = Board(), Mailbox()
        self._note = (0, "")
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="taut-view", daemon=True)

    def start(self) -> None:
        """Let it run."""
        self._thread.start()

    def stop(self) -> None:
        """End it after the frame in hand, but do not wait long for that; see :attr:`is_running`."""
        self._stop.set()
        self.mail.put(0, Play(False))
        self._thread.join(_PATIENCE)

    @property
    def is_running(self) -> bool:
        """Whether anything of it still works."""
        return self._thread.is_alive()

    def leave(self, client: Client) -> None:
        """A page is gone; what it held falls, and what it asked for is not sent any more."""
        self.mail.put(client, Release())
        self.mail.put(client, Contacts(False))

    def _say(self, text: str) -> None:
        """Have all pages show a sentence, with the next status."""
        self._note = self._note[0] + 1, text

    @abstractmethod
    def _run(self) -> None:
        """Work until `_stop` is set."""
