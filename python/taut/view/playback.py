"""Recordings behind the page: one playhead for all of them."""

import time
from collections.abc import Sequence

import numpy as np

from taut.cache import Cache
from taut.errors import CacheError
from taut.frames import frame_rate
from taut.view import wire
from taut.view.picture import Mesh, Panel, pack_layout, pack_picture, up_of
from taut.view.show import Show
from taut.view.solids import Solids

_LEAST_PAUSE = 1 / 61
"""Pictures do not follow each other faster than this [s]; at high speed frames are left out."""


class PlaybackShow(Show):
    """One cache or several in lock-step: each shows its last frame that is not later than the playhead."""

    def __init__(self, caches: Sequence[Cache]) -> None:
        """Open at the first frame.

        Raises:
            CacheError: a cache is damaged.
        """
        super().__init__()
        self._caches = list(caches)
        self._rate = frame_rate(self._caches[0])
        self._end = max(float(cache.time[-1]) for cache in self._caches)
        self._frames = 1 + round(self._end * self._rate)
        self._limits = [_limits(cache) for cache in self._caches]
        self._frame = 0
        self._playing, self._loop = True, True
        self._speed = 1.0
        self._since, self._begun = time.perf_counter(), 0
        up = up_of(self._caches[0].scene)
        self._solids = [Solids(cache.bodies(0), cache.positions(0), up) for cache in self._caches]
        meshes = [_mesh(cache, solids) for cache, solids in zip(self._caches, self._solids, strict=True)]
        self.board.layout = pack_layout(meshes, self._caches[0].scene, live=False)
        self._tell()
        self._show()

    def _run(self) -> None:
        while not self._stop.is_set():
            self.turn(time.perf_counter())
            self.mail.wait(max(_LEAST_PAUSE, 0.5 / (self._rate * self._speed)) if self._playing else 1.0)

    def turn(self, now: float) -> None:
        """Obey, and show the frame that is due at `now` [s]; :meth:`start` repeats it."""
        orders = self.mail.take()
        for _, order in orders:
            self._obey(order)
        if orders or not self._playing:
            self._since, self._begun = now, self._frame
        if not self._playing:
            return
        due = self._begun + int((now - self._since) * self._rate * self._speed)
        if due >= self._frames:
            self._playing = self._loop
            due = 0 if self._loop else self._frames - 1
            self._since, self._begun = now, due
            self._tell()
        if due != self._frame:
            self._frame = due
            self._show()

    def _obey(self, order: wire.Order) -> None:
        match order:
            case wire.Play(on):
                again = on and not self._playing and self._frame + 1 == self._frames
                self._frame = 0 if again else self._frame
                self._playing = on
            case wire.Step():
                self._playing = False
                self._frame = (self._frame + 1) % self._frames
            case wire.Reset():
                self._frame = 0
            case wire.Speed(value):
                self._speed = value
            case wire.Loop(on):
                self._loop = on
            case wire.Release() | wire.Contacts():
                return
            case wire.Seek(frame):
                self._frame = min(frame, self._frames - 1)
            case _:
                self._say(
                    f"{type(order).__name__.lower()}: a recording cannot be changed; open a scene for that"
                )
        self._tell()
        self._show()

    def _tell(self) -> None:
        status = {
            "title": " | ".join(dict.fromkeys(cache.title for cache in self._caches)),
            "playing": self._playing,
            "speed": self._speed,
            "loop": self._loop,
            "frames": self._frames,
            "note": self._note,
            "controls": [],
        }
        self.board.post_status(status)

    def _show(self) -> None:
        try:
            panels = [self._panel(index) for index in range(len(self._caches))]
        except CacheError as error:
            self._playing = False
            self._say(str(error))
            self._tell()
            return
        header = {
            "time": self._frame / self._rate,
            "frame": self._frame,
            "factor": self._speed if self._playing else 0.0,
            "wind": (self._caches[0].scene.get("wind") or {}).get("velocity", [0, 0, 0]),
            "held": [],
        }
        self.board.post_picture(lambda number: pack_picture(number, header, panels))

    def _panel(self, index: int) -> Panel:
        cache = self._caches[index]
        moment = (self._frame + 0.01) / self._rate
        frame = max(0, int(np.searchsorted(cache.time, moment, side="right")) - 1)
        numbers = cache.diagnostics
        energies = ("kinetic_energy", "elastic_energy", "potential_energy")
        return Panel(
            mesh=index,
            name=f"{cache.path.stem}: {cache.scene['solver']['filter']}",
            positions=cache.positions(frame),
            limits=self._limits[index],
            limited=cache.scene["solver"]["filter"] != "none",
            worst=float(numbers["worst_stretch"][frame]),
            energies=[float(numbers[name][frame]) for name in energies],
            ms=float(numbers["ms"][frame]),
            contacts=float(numbers["contacts"][frame]) / max(1, int(cache.attributes["substeps"])),
            closest=float(numbers["closest"][frame]),
            solids=self._solids[index],
            bodies=cache.bodies(frame) if self._solids[index].moves else None,
        )


def _mesh(cache: Cache, solids: Solids) -> Mesh:
    return Mesh(
        cache.positions(0),
        cache.faces,
        cache.springs,
        cache.spring_kind,
        cache.rest_length,
        [cache.pins],
        [int(cloth["first_vertex"]) for cloth in cache.attributes["cloths"]],
        solids,
        cache.bodies(0),
        np.zeros((0, 3), np.int32),
    )


def _limits(cache: Cache) -> list[float]:
    return [float(cloth["strain_limit"]) for cloth in cache.scene["cloth"]]
