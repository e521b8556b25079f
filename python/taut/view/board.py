"""Where a show leaves what pages shall see, and where pages leave what the show shall do."""

import json
import threading
from collections.abc import Callable, Mapping
from typing import Any

from taut.view.controls import controls
from taut.view.wire import Contacts, Drag, Grab, Order, Pin, Release, Set

Client = int
"""Tells pages apart."""


class Board:
    """The latest layout, status and picture; older ones are gone, whoever has not read them.

    A show writes in its own thread; readers look when they have time. So nobody who reads slowly holds the
    show up.
    """

    def __init__(self) -> None:
        """Start with an empty board."""
        self._lock = threading.Lock()
        self._listener: Callable[[], object] | None = None
        self.layout = b""
        """Topology of what is shown; never changes once it is there."""
        self.status: tuple[int, str] = (0, "{}")
        """Its number, and settings and messages as JSON."""
        self.picture: tuple[int, bytes] = (0, b"")
        """Its number and what is shown now."""

    def listen(self, listener: Callable[[], object] | None) -> None:
        """Have `listener` called, in the show's thread, whenever something is new."""
        with self._lock:
            self._listener = listener

    def post_status(self, status: Mapping[str, Any]) -> None:
        """Replace the status, if it is another one."""
        text = json.dumps({"type": "status", **status}, allow_nan=False)
        if text == self.status[1]:
            return
        self.status = self.status[0] + 1, text
        self._tell()

    def post_picture(self, picture: Callable[[int], bytes]) -> None:
        """Replace the picture; it is made with its number."""
        number = self.picture[0] + 1
        self.picture = number, picture(number)
        self._tell()

    def _tell(self) -> None:
        with self._lock:
            if self._listener is not None:
                self._listener()


class Mailbox:
    """Orders that wait for the show. Only the last one for each thing is kept, so that it cannot overflow."""

    def __init__(self) -> None:
        """Start empty."""
        self._orders: dict[tuple[object, ...], tuple[Client, Order]] = {}
        self._new = threading.Condition()

    def put(self, client: Client, order: Order) -> None:
        """Leave an order."""
        with self._new:
            key = _subject(client, order)
            self._orders.pop(key, None)  # the last order comes last
            self._orders[key] = client, order
            self._new.notify_all()

    def take(self) -> list[tuple[Client, Order]]:
        """All orders, in the order in which they came; none are left."""
        with self._new:
            orders = list(self._orders.values())
            self._orders.clear()
            return orders

    def wait(self, seconds: float) -> None:
        """Sleep until there is an order, but no longer than this."""
        with self._new:
            if not self._orders:
                self._new.wait(seconds)


def _subject(client: Client, order: Order) -> tuple[object, ...]:
    if isinstance(order, Grab | Drag | Release):
        return "hand", client
    if isinstance(order, Set):
        return Set, order.control if order.control in controls() else None
    if isinstance(order, Pin | Contacts):
        return type(order), client
    return (type(order),)
