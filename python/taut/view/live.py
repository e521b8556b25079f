"""A simulation that runs behind the page, in a thread of its own."""

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from taut.errors import SceneError, SimulationError
from taut.formats import MeshError
from taut.scene import Scene
from taut.simulation import Simulation
from taut.view import controls, wire
from taut.view.ball import Ball
from taut.view.board import Client
from taut.view.carried import Carried
from taut.view.hands import Hands, hand_over
from taut.view.pace import Pace
from taut.view.picture import Mesh, pack_layout, pack_picture, up_of
from taut.view.runs import Run, Wish, build
from taut.view.show import Show
from taut.view.solids import Solids


class LiveShow(Show):
    """A scene that runs; pages change it while it does.

    What they change is built into a new simulation beside the running one, which goes on meanwhile; then the
    new one takes over positions, velocities and time.
    """

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        """Build the scene.

        Raises:
            SceneError: it cannot be simulated.
        """
        super().__init__()
        self._scene, self._threads = scene, threads
        self._document = scene.document
        self._hands = Hands()
        self._wish = self._running = Wish()
        self._runs = build(scene, self._wish, None, threads)
        self._rest = self._runs[0].simulation.exact_positions
        self._solids = Solids(self._first.bodies, self._rest, up_of(self._document))
        up, floor = up_of(self._document), self._solids.floor
        self._carried = Carried(Ball(self._first.bodies, self._rest, up, floor), self._solids.floor_name)
        self._throws: wire.Throw | None = None
        self._watchers: set[Client] = set()
        self._building: tuple[Wish, Future[list[Run]]] | None = None
        self._builder = ThreadPoolExecutor(1, "taut-build")
        self._frame = 0
        self._playing, self._single = True, False
        self._pace = Pace(scene.fps)
        self.board.layout = self._layout()
        self._tell()
        self._show()

    @property
    def simulations(self) -> list[Simulation]:
        """What runs now: the scene, and beside it the bare cloth if that was asked for."""
        return [run.simulation for run in self._runs]

    @property
    def _first(self) -> Simulation:
        return self._runs[0].simulation

    @property
    def is_running(self) -> bool:
        """Whether anything of it still works."""
        return super().is_running or (self._building is not None and not self._building[1].done())

    def _run(self) -> None:
        try:
            self._turn_until_stopped()
        finally:
            self._builder.shutdown(wait=False, cancel_futures=True)

    def _turn_until_stopped(self) -> None:
        while not self._stop.is_set():
            self.turn()
            if self._playing:
                self._pace.wait()
            else:
                self._pace.rest()
                self.mail.wait(0.02 if self.is_building else 1.0)

    @property
    def is_building(self) -> bool:
        """Whether something that was changed is not yet in force."""
        return self._building is not None or self._wish != self._running

    def turn(self) -> None:
        """Obey, take over what was built, simulate a frame if time runs; :meth:`start` repeats it."""
        for client, order in self.mail.take():
            self._obey(client, order)
        self._rebuild()
        if self._playing or self._single:
            self._single = False
            self._advance()
            self._show()

    def _advance(self) -> None:
        self._hands.apply(self.simulations)
        self._carried.apply(self.simulations)
        try:
            for run in self._runs:
                run.advance()
        except SimulationError as error:
            self._playing = False
            self._say(f"{error}; press reset, or take back what was changed last")
            self._tell()
            return
        self._carried.settle(self._first)
        if self._running.ball and self._throws is None and not self._carried.ball.is_shown:
            # It is gone: without it the scene is what it was, and costs no more.
            self._wish = replace(self._wish, ball=False)
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
            case wire.Grab(vertex):
                held = self._hands.grabs.get(client)
                if held is not None and held.vertex != vertex:
                    self._release(client)
                self._carried.release(client, self.simulations)
                self._hands.grab(client, order, self._first)
                self._hold()
            case wire.Release():
                self._release(client)
            case wire.Pin():
                self._hands.move_pin(order, self._first)
            case wire.Drag():
                if client in self._hands.grabs:
                    self._release(client)
                self._carried.drag(client, order, self.simulations)
            case wire.Throw():
                self._throw(order)
            case wire.Contacts(on):
                (self._watchers.add if on else self._watchers.discard)(client)
                self._show()
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

    def _throw(self, order: wire.Throw) -> None:
        """Throw the ball, or have one built that is thrown then."""
        self._throws = order
        self._wish = replace(self._wish, ball=True)
        goes = self._building is not None and not self._building[0].ball
        if goes or not self._running.ball:
            return
        self._throws = None
        self._carried.ball.throw(order, self._first)
        self._carried.place_ball(self.simulations)
        self._show()

    def _release(self, client: Client) -> None:
        self._carried.release(client, self.simulations)
        grab = self._hands.grabs.pop(client, None)
        if grab is not None and grab.vertex not in self._hands.held:
            for simulation in self.simulations:
                simulation.release(grab.vertex)
        self._hold()

    def _reset(self) -> None:
        self._frame = 0
        self._hands.forget_pins()
        self._carried.forget(self.simulations)
        self._throws, self._wish = None, replace(self._wish, ball=False)
        for simulation in self.simulations:
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
            except (SceneError, MeshError) as error:
                self._throws = None
                self._wish = replace(self._running, held=self._hands.held)
                self._running = replace(self._running, held=self._hands.held)
                self._document = self._wish.apply(self._scene).document
                self._say(str(error))
            self._tell()
        if self._building is None and self._wish != self._running:
            arguments = self._scene, self._wish, self._first, self._threads, self._carried.ball
            self._building = self._wish, self._builder.submit(build, *arguments)

    def _take_over(self, wish: Wish, new: list[Run]) -> None:
        for index, run in enumerate(new):
            before = self._runs[min(index, len(self._runs) - 1)]
            self._carried.put(before.simulation, run.simulation)
            hand_over(before.simulation, run.simulation, self._frame)
            self._carried.pass_on(run.simulation)
            self._hands.pass_on(before.simulation, run.simulation)
            run.ms = before.ms
        self._runs, self._running = new, wish
        if not wish.ball:
            self._carried.ball.park()
        if self._throws is not None and wish.ball:
            try:
                self._throw(self._throws)
            except wire.OrderError as error:
                self._throws = None
                self._say(str(error))
        self._show()

    # What pages see.

    def _tell(self) -> None:
        status = {
            "title": self._scene.title,
            "playing": self._playing,
            "speed": self._pace.speed,
            "compare": self._wish.compare,
            "note": self._note,
            "controls": [control.describe(self._document) for control in controls.controls().values()],
        }
        self.board.post_status(status)

    def _layout(self) -> bytes:
        simulation = self._first
        mesh = Mesh(
            self._rest.astype(np.float32),
            simulation.faces,
            simulation.springs,
            simulation.spring_kind,
            simulation.rest_length,
            simulation.pin_groups,
            [cloth.first_vertex for cloth in simulation.cloths],
            self._solids,
            simulation.bodies,
            self._carried.ball.faces,
        )
        return pack_layout([mesh], self._document, live=True)

    def _show(self) -> None:
        watched = bool(self._watchers)
        panels = [run.panel(self._solids, self._carried, watched) for run in self._runs]
        header = {
            "time": self._first.time,
            "frame": self._frame,
            "factor": self._pace.factor,
            "wind": (self._document.get("wind") or {}).get("velocity", [0, 0, 0]),
            "held": sorted(self._hands.held),
        }
        self.board.post_picture(lambda number: pack_picture(number, header, panels))
