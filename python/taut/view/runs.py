"""The simulations behind a live show, and what they are built from."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.contacts import Contacts
from taut.scene import Scene
from taut.simulation import Simulation
from taut.view.ball import Ball
from taut.view.carried import Carried
from taut.view.hands import weights
from taut.view.picture import Panel
from taut.view.solids import Solids

_BARE = ("solver.filter=none", "solver.substeps=auto")
"""What makes a scene the bare mass-spring cloth."""
_SHARE = 0.1
"""Weight of the last frame in the mean cost."""
_MOST_CONTACTS = 4000
"""Contacts in a picture [1]."""


@dataclass(frozen=True)
class Wish:
    """Everything on which the simulations depend; another wish means other simulations."""

    changes: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """For each control that was used the settings that it means."""
    held: frozenset[int] = frozenset()
    """Vertices in a hand."""
    compare: bool = False
    """Whether the bare cloth is shown as well."""
    ball: bool = False
    """Whether there is a ball to be thrown."""

    def apply(self, scene: Scene) -> Scene:
        """The scene with what was changed.

        Raises:
            SceneError: it is no valid scene.
        """
        return scene.with_settings([setting for _, settings in self.changes for setting in settings])


class Run:
    """A simulation with what its panel says about it."""

    def __init__(self, scene: Scene, threads: int | None) -> None:
        """Build the scene.

        Raises:
            SceneError: it cannot be simulated.
        """
        self.simulation = Simulation(scene, threads)
        document = scene.document
        self._filter = str(document["solver"]["filter"])
        self._limits = [float(cloth["strain_limit"]) for cloth in document["cloth"]]
        self.ms = 0.0
        """Mean cost of the last frames [ms]."""

    def advance(self) -> None:
        """Simulate a frame.

        Raises:
            SimulationError: a vertex became non-finite; the state is the one before.
        """
        start = time.perf_counter()
        self.simulation.step(self.simulation.substeps)
        ms = 1e3 * (time.perf_counter() - start)
        self.ms += (_SHARE if self.ms else 1.0) * (ms - self.ms)

    def panel(self, solids: Solids, carried: Carried, with_contacts: bool) -> Panel:
        """What is shown of it, beside `solids`, and where it touches something if that is asked for."""
        report = self.simulation.report
        moves = solids.moves or carried.any_moved or carried.ball.is_shown
        return Panel(
            mesh=0,
            name=self._filter,
            positions=self.simulation.positions,
            limits=self._limits,
            limited=self._filter != "none",
            worst=report.worst_stretch,
            energies=(report.kinetic_energy, report.elastic_energy, report.potential_energy),
            ms=self.ms,
            solids=solids,
            bodies=self.simulation.bodies if moves else None,
            contacts=report.contacts / max(1, report.steps),
            closest=report.closest,
            ball=carried.ball.points(),
            touches=_touches(self.simulation.contacts) if with_contacts else None,
        )


def _touches(contacts: Contacts) -> NDArray[np.float32]:
    """Places and forces, the strongest first, as many as a page can draw."""
    rows = np.column_stack([contacts.positions, contacts.forces])
    strongest = np.argsort(-contacts.forces, kind="stable")[:_MOST_CONTACTS]
    return rows[strongest].astype(np.float32)


def build(
    scene: Scene, wish: Wish, base: Simulation | None, threads: int | None, ball: Ball | None = None
) -> list[Run]:
    """What a wish asks for: the scene, and beside it the bare cloth if it shall be compared.

    Args:
        scene: as it was at first.
        wish: what shall be other.
        base: any earlier simulation of it, for the masses of what is held.
        threads: worker threads [1]; all cores when left out.
        ball: what is thrown if the wish asks for it.

    Raises:
        SceneError: one of them cannot be simulated.
    """
    changed = wish.apply(scene)
    if base is not None and wish.held:
        changed = changed.with_settings(weights(base, wish.held, changed.document))
    if ball is not None and wish.ball:
        changed = changed.with_settings(ball.settings(changed.document))
    scenes = [changed, changed.with_settings(_BARE)] if wish.compare else [changed]
    return [Run(one, threads) for one in scenes]
