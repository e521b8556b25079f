"""Who holds what, and how strongly: hands of pages on the vertices and pins of a simulation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.simulation import Simulation
from taut.view.board import Client
from taut.view.controls import inline
from taut.view.wire import Grab, OrderError, Pin

SHARE = 0.5
"""Mass of a hand as a part of its cloth's: it carries the cloth, and the limit can still hold it back."""
PACE = 4.0
"""Highest speed of a hand, in diagonals of all cloths a second [1/s]."""


@dataclass
class Hands:
    """What all pages hold, in scene vertices."""

    grabs: dict[Client, Grab] = field(default_factory=dict)
    pins: dict[int, Pin] = field(default_factory=dict)
    """The last order for each pin group that shall move."""
    offsets: dict[int, NDArray[np.float64]] = field(default_factory=dict)
    """How far each pin group that was moved shall be off its path [m]."""

    def grab(self, client: Client, order: Grab, simulation: Simulation) -> None:
        """Hold a vertex, or lead it elsewhere.

        Raises:
            OrderError: there is no such vertex, or it is pinned.
        """
        if order.vertex >= len(simulation.positions):
            raise OrderError(f"grab.vertex = {order.vertex}: there are {len(simulation.positions)} vertices")
        if simulation.pinned[order.vertex]:
            raise OrderError("a pinned vertex cannot be pulled; move its pin")
        self.grabs[client] = order

    def move_pin(self, order: Pin, simulation: Simulation) -> None:
        """Move a pin group.

        Raises:
            OrderError: there is no such group.
        """
        groups = simulation.pin_groups
        if order.group >= len(groups) or not len(groups[order.group]):
            raise OrderError(f"pin.group = {order.group}: there are {len(groups)} groups")
        self.pins[order.group] = order

    @property
    def held(self) -> frozenset[int]:
        """Vertices that are held."""
        return frozenset(grab.vertex for grab in self.grabs.values())

    def apply(self, simulations: Sequence[Simulation]) -> None:
        """Tell simulations where their held vertices and moved pins shall go."""
        if not self.grabs and not self.pins:
            return
        first = simulations[0]
        for order in self.pins.values():
            path = first.exact_positions[first.pin_groups[order.group][0]] - first.pin_offset(order.group)
            self.offsets[order.group] = np.subtract(order.target, path)
        for simulation in simulations:
            speed = PACE * diagonal(simulation)
            for grab in self.grabs.values():
                simulation.lead(grab.vertex, grab.target, speed)
            for group in self.pins:
                simulation.shift_pins(group, self.offsets[group], speed)
        self.pins.clear()

    def pass_on(self, before: Simulation, after: Simulation) -> None:
        """Have moved pins go on in a simulation that takes over from another one."""
        for group, offset in self.offsets.items():
            after.shift_pins(group, before.pin_offset(group), np.inf)
            after.shift_pins(group, offset, PACE * diagonal(after))

    def forget_pins(self) -> None:
        """Have no pins off their paths."""
        self.pins.clear()
        self.offsets.clear()


def weights(simulation: Simulation, vertices: frozenset[int], document: Mapping[str, Any]) -> list[str]:
    """The settings that hang the mass of a hand on each held vertex, besides the scene's own weights.

    Args:
        simulation: of the same cloths, for their masses; hands in it do not count.
        vertices: what is held.
        document: the resolved scene to which the settings will be applied.
    """
    settings = []
    for index, cloth in enumerate(simulation.cloths):
        own = [vertex - cloth.first_vertex for vertex in sorted(vertices)]
        own = [vertex for vertex in own if 0 <= vertex < cloth.vertices]
        if own:
            hung = simulation.scene.document["cloth"][index].get("weights", ())
            mass = float(simulation.mass[cloth.first_vertex :][: cloth.vertices].sum())
            mass = SHARE * max(1e-6 * mass, mass - sum(float(weight["mass"]) for weight in hung))
            hands = [{"vertices": [vertex], "mass": mass} for vertex in own]
            listed = [*document["cloth"][index].get("weights", ()), *hands]
            settings.append(f"cloth[{index}].weights={inline(listed)}")
    return settings


def hand_over(before: Simulation, after: Simulation, frame: int) -> None:
    """Let a simulation of a changed scene go on where another one is.

    Args:
        before: the simulation so far.
        after: one with the same vertices; it is brought within its limit if it would start beyond it.
        frame: frames since the start.
    """
    after.set_state(before.exact_positions, before.velocities, frame * after.substeps)
    if is_beyond_limit(after):
        after.admit()


def is_beyond_limit(simulation: Simulation) -> bool:
    """Whether a spring is over its limit."""
    ends = simulation.exact_positions[simulation.springs]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return bool((length > simulation.rest_length * (1.0 + simulation.strain_limit) * (1 + 1e-6)).any())


def diagonal(simulation: Simulation) -> float:
    """The diagonal of the box around all vertices now [m]."""
    extent = np.ptp(simulation.positions, axis=0) if len(simulation.positions) else np.zeros(3)
    return float(np.linalg.norm(extent)) or 1.0
