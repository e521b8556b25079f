"""Snapshots with mistakes in their bytes."""

from __future__ import annotations

from random import Random
from typing import Any, ClassVar

from taut import Scene, Simulation

from tests.attack.edits import edit, edited
from tests.attack.frame import Attack, Case, Outcome

NET = {"points": [[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]], "links": [[0, 1], [1, 2]], "mass": 0.01}
CLOTHS: list[dict[str, Any]] = [
    {"grid": {"cells": [6, 4]}, "pins": [{"edge": "left", "move": [[1, [0.1, 0, 0]]]}]},
    {"network": NET, "stiffness": 20.0, "pins": [{"vertices": [0]}]},
]
INTEGRATORS = ["euler", "bdf2", "verlet"]


class Snapshots(Attack):
    """Bytes of snapshots, mutated, put together, and of other scenes."""

    name: ClassVar[str] = "snapshots"
    promise: ClassVar[str] = "bytes of snapshots: refused, and the simulation goes on as if nothing had been"
    short: ClassVar[int] = 200

    def __init__(self) -> None:
        """Simulate a little, with hands on the cloth."""
        self._simulations = []
        for integrator in INTEGRATORS:
            scene = Scene({"cloth": CLOTHS, "solver": {"integrator": integrator}})
            simulation = Simulation(scene, 1)
            simulation.lead(20, [1, 1, 1], 0.5)
            simulation.hold([30, 31], [[0, 0, 0], [1, 0, 0]], 5.0)
            simulation.step(3)
            self._simulations.append(simulation)
        self._snapshots = [simulation.snapshot() for simulation in self._simulations]

    def generate(self, random: Random) -> Case:
        """A snapshot of one simulation for another or the same, with mistakes."""
        edits = [edit(random, []) for _ in range(random.choice([0, 1, 1, 2, 5]))]
        return {"into": random.randrange(3), "of": random.randrange(3), "edits": edits}

    def judge(self, case: Case) -> Outcome:
        """Restore it."""
        into = case["into"]
        simulation, own = self._simulations[into], self._snapshots[into]
        simulation.restore(own)
        hash = simulation.state_hash
        given = edited(self._snapshots[case["of"]], case["edits"])
        try:
            simulation.restore(given)
        except ValueError as error:
            if "snapshot" not in str(error):
                return Outcome(f"the error does not say what is wrong: {error}")
            simulation.step(1)
            after = simulation.state_hash
            simulation.restore(own)
            simulation.step(1)
            same = simulation.state_hash == after
            return Outcome("" if same else "a refused snapshot changed the simulation", refused=True)
        if given != own:
            return Outcome("a snapshot with other bytes was taken")
        return Outcome("" if simulation.state_hash == hash else "a snapshot restores another state")

    def files(self, case: Case) -> dict[str, bytes]:
        """The bytes."""
        return {"snapshot.bin": edited(self._snapshots[case["of"]], case["edits"])}
