"""Orders of pages to the viewer, in random sequences."""

from __future__ import annotations

import json
import math
from random import Random
from typing import Any, ClassVar

import numpy as np
from taut import Scene, Simulation
from taut.view import wire
from taut.view.controls import controls
from taut.view.live import LiveShow

from tests.attack.edits import edit, edited
from tests.attack.frame import Attack, Case, Outcome

SCENES: list[dict[str, Any]] = [
    {"wind": {"velocity": [8, 1, 0]}, "cloth": [{"grid": {"cells": [6, 4]}, "pins": [{"edge": "left"}]}]},
    {"cloth": [{"grid": {"cells": [4, 4]}, "pins": [{"corner": at}]} for at in ("top-left", "top-right")]},
    {"up": "y", "cloth": [{"grid": {"cells": [3, 5]}}]},
    {
        "body": [
            {"name": "floor", "plane": {"normal": [0, 0, 1], "point": [0, 0, -1]}},
            {"name": "ball", "sphere": {"center": [0.4, 0.8, 0.4], "radius": 0.3}, "move": [[1, [0, -1, 0]]]},
            {"name": "crate", "box": {"center": [0.5, -1, 0.3], "size": [0.5, 0.5, 0.5]}},
        ],
        "cloth": [
            {"grid": {"cells": [6, 6]}, "pins": [{"edge": "top"}], "thickness": 0.01},
        ],
    },
]
ODD = [0, 1, -1, 0.5, 1e9, -1e9, 1e-300, 1e308, None, True, "", "none", [], {}, 2**31, 2**63, [1, 2, 3]]
WORDS = [b'"', b"{", b"}", b"[", b"]", b"null", b"NaN", b"Infinity", b"-1", b"1e999", b"\\ud800", b"9" * 400]
LONGEST = 200
"""Letters of an error [1]."""


class Orders(Attack):
    """What pages may say, and what they may not."""

    name: ClassVar[str] = "orders"
    promise: ClassVar[str] = "random orders to the viewer: finite pictures, limit kept, faults answered"
    unit: ClassVar[str] = "orders"
    short: ClassVar[int] = 12

    def generate(self, random: Random) -> Case:
        """Texts of some pages; now and then the show has a turn."""
        orders: list[list[Any]] = []
        for _ in range(random.randint(5, 60)):
            kind = random.choice(["order"] * 6 + ["turn"] * 4 + ["fault", "leave"])
            text = json.dumps(order(random))
            if kind == "fault":
                mistakes = [edit(random, WORDS) for _ in range(random.randint(1, 3))]
                text = edited(text.encode(), mistakes).decode(errors="replace")
            orders.append([random.randint(0, 2), kind, text if kind in ("order", "fault") else ""])
        return {"scene": random.randrange(len(SCENES)), "orders": orders}

    def judge(self, case: Case) -> Outcome:
        """Obey."""
        show = LiveShow(Scene(SCENES[case["scene"]]), threads=1)
        try:
            for number, (client, kind, text) in enumerate([*case["orders"], [0, "turn", ""]]):
                failure = self._give(show, client, kind, text)
                if failure:
                    return Outcome(f"order {number}: {failure}")
        finally:
            show._builder.shutdown(cancel_futures=True)
        return Outcome(looked_at=len(case["orders"]))

    def _give(self, show: LiveShow, client: int, kind: str, text: str) -> str:
        if kind == "leave":
            show.leave(client)
        elif kind == "turn":
            show.turn()
            return problem(show)
        else:
            try:
                show.mail.put(client, wire.parse(text))
            except wire.OrderError as error:
                return "" if len(str(error)) <= LONGEST else f"an answer of {len(str(error))} letters"
        return ""


def order(random: Random) -> dict[str, Any]:
    """What a page may say, with usual or odd values."""

    def number(most: float) -> Any:
        return random.choice(ODD) if random.random() < 0.1 else round(random.uniform(-most, most), 3)

    def target() -> list[Any]:
        return [number(3.0) for _ in range(3)]

    control = random.choice(sorted(controls()))
    values = [
        random.choice(ODD),
        number(100.0),
        number(1.0),
        random.choice(["coarse_to_fine", "none", "xpbd", "rods"]),
    ]
    return random.choice(
        [
            {"type": "play", "on": random.random() < 0.8},
            {"type": "step"},
            {"type": "reset"},
            {"type": "speed", "value": number(16.0)},
            {"type": "seek", "frame": random.randint(0, 99)},
            {"type": "compare", "on": random.random() < 0.5},
            *[{"type": "set", "control": control, "value": value} for value in values],
            *[{"type": "grab", "vertex": random.randint(0, 60), "target": target()}] * 3,
            {"type": "release"},
            {"type": "pin", "group": random.randint(0, 3), "target": target()},
            *[{"type": "drag", "body": random.randint(0, 4), "target": target()}] * 3,
            *[{"type": "throw", "start": target(), "target": target()}] * 2,
            {"type": "contacts", "on": random.random() < 0.8},
            {"type": "seen", "number": random.randint(0, 99)},
        ]
    )  # fmt: skip


def problem(show: LiveShow) -> str:
    """What is wrong with what pages see."""
    status = json.loads(show.board.status[1], parse_constant=_no_number)
    if len(status["note"][1]) > 1500:
        return f"a note of {len(status['note'][1])} letters"
    picture = show.board.picture[1]
    length = int.from_bytes(picture[:4], "little")
    json.loads(picture[4 : 4 + length], parse_constant=_no_number)
    return next(filter(None, map(over, show.simulations)), "")


def over(simulation: Simulation) -> str:
    """What is not finite or over its limit."""
    places = simulation.exact_positions
    if not (np.isfinite(places).all() and np.isfinite(simulation.velocities).all()):
        return "a number is not finite"
    if simulation.scene.document["solver"]["filter"] != "coarse_to_fine":
        return ""
    if simulation.bodies and simulation.intersections():
        return f"cloth intersects something: {simulation.intersections().places[0]}"
    u, v = simulation.springs.T
    stretch = np.linalg.norm(places[v] - places[u], axis=1) / simulation.rest_length - 1
    excess = float((stretch - simulation.strain_limit).max(initial=-math.inf))
    return f"a spring is over its limit by {excess}" if excess > 1e-5 else ""


def _no_number(text: str) -> None:
    raise ValueError(f"{text} is no JSON")
