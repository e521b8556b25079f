"""Bodies that pages move, and the ball that they throw."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.simulation import Simulation
from taut.view.ball import Ball
from taut.view.board import Client
from taut.view.hands import PACE, diagonal
from taut.view.wire import Drag, OrderError


@dataclass(frozen=True)
class _Lead:
    name: str
    target: NDArray[np.float64]


class Carried:
    """Where bodies go that a page has moved, in all simulations of a show.

    A body that was let go stays as far off its path as it was then: one that moves by itself goes on from
    there.
    """

    def __init__(self, ball: Ball, floor: str | None) -> None:
        """Nothing is moved yet.

        Args:
            ball: what is thrown.
            floor: the body that stays where it is, if there is one.
        """
        self.ball = ball
        self._floor = floor
        self._leads: dict[Client, _Lead] = {}
        self._offsets: dict[str, NDArray[np.float64]] = {}
        self.any_moved = False
        """Whether any body was ever moved: then pages cannot know where they are."""

    def drag(self, client: Client, order: Drag, simulations: Sequence[Simulation]) -> None:
        """Hold a body, or lead it elsewhere.

        Raises:
            OrderError: there is no such body, or it is the floor.
        """
        names = _names(simulations[0])
        if not self.ball.is_shown:
            names = [name for name in names if name != self.ball.name]
        if order.body >= len(names):
            raise OrderError(f"drag.body = {order.body}: there are {len(names)} bodies")
        name = names[order.body]
        if client in self._leads and self._leads[client].name != name:
            self.release(client, simulations)
        if name == self._floor:
            raise OrderError("the floor stays where it is")
        self._leads[client] = _Lead(name, np.array(order.target))
        self.any_moved = True
        if name == self.ball.name:
            self.ball.catch()

    def release(self, client: Client, simulations: Sequence[Simulation]) -> None:
        """Let a body go: it stays where it is, beside its path."""
        lead = self._leads.pop(client, None)
        if lead is None or any(other.name == lead.name for other in self._leads.values()):
            return
        for simulation in simulations:
            if lead.name in _names(simulation):
                self._send(simulation, lead.name, simulation.body_offset(lead.name))

    def apply(self, simulations: Sequence[Simulation]) -> None:
        """Tell simulations where their bodies shall be after the next frame."""
        for lead in self._leads.values():
            for simulation in simulations:
                if lead.name in _names(simulation):
                    self._lead(simulation, lead)
        first = simulations[0]
        way = self.ball.plan(first.gravity, _frame(first))
        if way is not None:
            for simulation in simulations:
                self._send(simulation, self.ball.name, way)

    def settle(self, simulation: Simulation) -> None:
        """A frame is done: the ball is where the cloth let it go."""
        if self.ball.is_shown:
            self.ball.settle(simulation.body_offset(self.ball.name), _frame(simulation))
            if not self.ball.is_shown:
                self._let_ball_go()
                self._offsets.pop(self.ball.name, None)
                simulation.shift_body(self.ball.name, (0, 0, 0))

    def place_ball(self, simulations: Sequence[Simulation]) -> None:
        """Put the ball where it is thrown from, at once."""
        self._let_ball_go()
        for simulation in simulations:
            simulation.shift_body(self.ball.name, self.ball.offset)
        self._offsets[self.ball.name] = self.ball.offset

    def put(self, before: Simulation, after: Simulation) -> None:
        """Have bodies where they are in a simulation that will take over from another one."""
        shared = set(_names(before))
        for name in filter(shared.__contains__, _names(after)):
            after.shift_body(name, before.body_offset(name))

    def pass_on(self, after: Simulation) -> None:
        """Have them go on from there: those that cloth has held back come after."""
        for name in _names(after):
            goal = self._offsets.get(name, np.zeros(3))
            way = float(np.linalg.norm(goal - after.body_offset(name)))
            if way > 0:
                after.shift_body(name, goal, way / (PACE * diagonal(after)))

    def forget(self, simulations: Sequence[Simulation]) -> None:
        """Have all bodies on their paths again, and no ball."""
        self._offsets.clear()
        self.ball.park()
        self._let_ball_go()
        for simulation in simulations:
            for name in _names(simulation):
                simulation.shift_body(name, (0, 0, 0))

    def _let_ball_go(self) -> None:
        self._leads = {client: lead for client, lead in self._leads.items() if lead.name != self.ball.name}

    def _lead(self, simulation: Simulation, lead: _Lead) -> None:
        """Lead a body towards its target for a frame, at the speed of a hand."""
        now = simulation.body_offset(lead.name)
        middle = simulation.bodies[lead.name].positions.mean(axis=0)
        way = lead.target - middle
        most = PACE * diagonal(simulation) * _frame(simulation)
        length = float(np.linalg.norm(way))
        self._send(simulation, lead.name, now + way * min(1.0, most / max(length, 1e-300)))

    def _send(self, simulation: Simulation, name: str, offset: NDArray[np.float64]) -> None:
        self._offsets[name] = offset
        simulation.shift_body(name, offset, _frame(simulation))


def _names(simulation: Simulation) -> list[str]:
    return [body.name for body in simulation.body_ranges]


def _frame(simulation: Simulation) -> float:
    """How long a frame is [s]."""
    return simulation.substeps * simulation.step_length
