"""A simulation that runs behind the page, in a thread of its own."""

import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from taut.errors import SceneError, SimulationError
from taut.scene import Scene
from taut.simulation import Simulation
from taut.view import controls, wire
from taut.view.board import Board, Client, Mailbox
from taut.view.hands import Hands, hand_over, weights
from taut.view.pace import Pace
from taut.view.picture import Mesh, Panel, pack_layout, pack_picture

_BARE = ("solver.filter=none", "solver.substeps=auto")
"""What makes a scene the bare mass-spring cloth."""


@dataclass(frozen=True)
class Wish:
    """Everything on which the simulations depend; another wish means other simulations."""

    changes: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """For each control that was used the settings that it means."""
    held: frozenset[int] = frozenset()
    """Vertices in a hand."""
    compare: bool = False
    """Whether the bare cloth is shown as well."""

    def apply(self, scene: Scene) -> Scene:
        """The scene with what was changed.

        Raises:
            SceneError: it is no valid scene.
        """
        return scene.with_settings([setting for _, settings in self.changes for setting in settings])


def build(scene: Scene, wish: Wish, base: Simulation | None, threads: int | None) -> list[Simulation]:
    """The simulations that a wish asks for; `base` is any earlier one of this scene.

    Raises:
        SceneError: one of them cannot be simulated.
    """
    changed = wish.apply(scene)
    if base is not None and wish.held:
        changed = changed.with_settings(weights(base, wish.held, changed.document))
    scenes = [changed, changed.with_settings(_BARE)] if wish.compare else [changed]
    return [Simulation(one, threads) for one in scenes]


class LiveShow:
    """A scene that runs; pages change it while it does.

    What they change is built into a new simulation beside the running one, which goes on meanwhile; then the
    new one takes over positions, velocities and time.
    """

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        """Build the scene.

        Raises:
            SceneError: it cannot be simulated.
        """
        self.board, self.mail = Board(), Mailbox()
        self._scene, self._threads = scene, threads
        self._document = scene.document
        self._hands = Hands()
        self._wish = self._running = Wish()
        self._simulations = build(scene, self._wish, None, threads)
        self._rest = self._simulations[0].positions.copy()
        self._building: tuple[Wish, Future[list[Simulation]]] | None = None
        self._builder = ThreadPoolExecutor(1, "taut-build")
        self._frame, self._ms = 0, [0.0, 0.0]
        self._playing, self._single = True, False
        self._pace = Pace(scene.fps)
        self._note = (0, "")
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="taut-view", daemon=True)
        self.board.layout = self._layout()
        self._tell()
        self._show()

    @property
    def simulations(self) -> list[Simulation]:
        """What runs now: the scene, and beside it the bare cloth if that was asked for."""
        return self._simulations

    def start(self) -> None:
        """Let it run."""
        self._thread.start()

    def stop(self) -> None:
        """End it; takes a frame at most."""
        self._stop.set()
        self.mail.put(0, wire.Play(False))
        self._thread.join()
        self._builder.shutdown(cancel_futures=True)

    def leave(self, client: Client) -> None:
        """A page is gone; what it held falls."""
        self.mail.put(client, wire.Release())

    def _run(self) -> None:
        while not self._stop.is_set():
            for client, order in self.mail.take():
                self._obey(client, order)
            self._rebuild()
            if self._playing or self._single:
                self._single = False
                self._advance()
                self._show()
                self._pace.wait()
            else:
                self._pace.rest()
                self.mail.wait(0.02 if self._building else 1.0)

    def _advance(self) -> None:
        self._hands.apply(self._simulations)
        for index, simulation in enumerate(self._simulations):
            start = time.perf_counter()
            try:
                simulation.step(simulation.substeps)
            except SimulationError as error:
                self._playing = False
                self._say(f"{error}; press reset, or take back what was changed last")
                self._tell()
                return
            ms = 1e3 * (time.perf_counter() - start)
            self._ms[index] += 0.1 * (ms - self._ms[index])
        self._frame += 1

    # Orders.

    def _obey(self, client: Client, order: wire.Order) -> None:
        try:
            self._do(client, order)
        except (wire.OrderError, SceneError) as error:
            self._say(str(error))
        self._tell()

    def _do(self, client: Client, order: wire.Order) -> None:
        match order:
            case wire.Play(on):
                self._playing = on
            case wire.Step():
                self._playing, self._single = False, True
            case wire.Speed(value):
                self._pace.speed = value
            case wire.Reset():
                self._reset()
            case wire.Compare(on):
                self._wish = replace(self._wish, compare=on)
            case wire.Set(name, value):
                self._set(name, value)
            case wire.Grab():
                self._hands.grab(client, order, self._simulations[0])
                self._hold()
            case wire.Release():
                self._release(client)
            case wire.Pin():
                self._hands.move_pin(order, self._simulations[0])
            case _:
                raise wire.OrderError(f"{type(order).__name__.lower()} is for recordings")

    def _set(self, name: str, value: float | str) -> None:
        value = controls.check(name, value)
        settings = tuple(controls.controls()[name].write(self._document, value))
        kept = tuple(change for change in self._wish.changes if change[0] != name)
        wish = replace(self._wish, changes=(*kept, (name, settings)))
        self._document = wish.apply(self._scene).document
        self._wish = wish

    def _hold(self) -> None:
        held = self._hands.held
        if held != self._wish.held:
            self._wish = replace(self._wish, held=held)

    def _release(self, client: Client) -> None:
        grab = self._hands.grabs.pop(client, None)
        if grab is not None and grab.vertex not in self._hands.held:
            for simulation in self._simulations:
                simulation.release(grab.vertex)
        self._hold()

    def _reset(self) -> None:
        self._frame = 0
        self._hands.pins.clear()
        for simulation in self._simulations:
            simulation.set_state(self._rest, np.zeros_like(self._rest), 0)
            for group in range(len(simulation.pin_groups)):
                simulation.shift_pins(group, (0, 0, 0), np.inf)
        self._show()

    # Building what was changed.

    def _rebuild(self) -> None:
        if self._building is not None and self._building[1].done():
            wish, built = self._building
            self._building = None
            try:
                self._take_over(wish, built.result())
            except SceneError as error:
                self._wish = replace(self._running, held=self._hands.held)
                self._running = replace(self._running, held=self._hands.held)
                self._document = self._wish.apply(self._scene).document
                self._say(str(error))
            self._tell()
        if self._building is None and self._wish != self._running:
            arguments = self._scene, self._wish, self._simulations[0], self._threads
            self._building = self._wish, self._builder.submit(build, *arguments)

    def _take_over(self, wish: Wish, new: list[Simulation]) -> None:
        last = len(self._simulations) - 1
        for index, simulation in enumerate(new):
            hand_over(self._simulations[min(index, last)], simulation, self._frame)
        self._simulations, self._running = new, wish
        self._show()

    # What pages see.

    def _say(self, text: str) -> None:
        self._note = self._note[0] + 1, text

    def _tell(self) -> None:
        status = {
            "title": self._scene.title,
            "playing": self._playing,
            "speed": self._pace.speed,
            "compare": self._wish.compare,
            "note": self._note,
            "controls": [control.describe(self._document) for control in controls.controls().values()],
            "warnings": self._simulations[0].warnings,
        }
        self.board.post_status(status)

    def _layout(self) -> bytes:
        simulation = self._simulations[0]
        mesh = Mesh(
            self._rest,
            simulation.faces,
            simulation.springs,
            simulation.spring_kind,
            simulation.rest_length,
            simulation.pin_groups,
            [cloth.first_vertex for cloth in simulation.cloths],
        )
        return pack_layout([mesh], self._document, live=True)

    def _show(self) -> None:
        panels = [self._panel(index) for index in range(len(self._simulations))]
        header = {
            "time": self._simulations[0].time,
            "frame": self._frame,
            "factor": self._pace.factor,
            "wind": (self._document.get("wind") or {}).get("velocity", [0, 0, 0]),
            "held": sorted(self._hands.held),
        }
        self.board.post_picture(lambda number: pack_picture(number, header, panels))

    def _panel(self, index: int) -> Panel:
        simulation = self._simulations[index]
        document, report = simulation.scene.document, simulation.report
        return Panel(
            mesh=0,
            name=document["solver"]["filter"],
            positions=simulation.positions,
            limits=[float(cloth["strain_limit"]) for cloth in document["cloth"]],
            limited=document["solver"]["filter"] != "none",
            worst=report.worst_stretch,
            energies=(report.kinetic_energy, report.elastic_energy, report.potential_energy),
            ms=self._ms[index],
        )
