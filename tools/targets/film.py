"""The row about films: a frame of one against a frame of the simulation that it shows."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from PIL import Image
from taut import Simulation
from taut.bench import Spread
from taut.cache import Cache
from taut.render import RenderOptions, render_film
from taut.render.encoder import Encoder
from taut.render.stage import FILM
from taut.render.stage import Stage as Pictures
from taut.run import record

from tools.targets.contact.drapes import stage
from tools.targets.contact.scenes import Stage
from tools.targets.contact.speed import THREADS, without
from tools.targets.table import Effort, Row

SIZE = (1280, 720)
FRAMES = 120
KEPT = 30
"""Pictures that are encoded alone, again and again [1]: all of them would fill the memory."""
PARTS = ("simulating", "film", "drawing", "encoding", "processor time of the film")


@dataclass(slots=True)
class Filmed:
    """A scene, and what a frame of it takes."""

    name: str
    made: Stage
    ms: dict[str, list[float]] = field(default_factory=lambda: {part: [] for part in PARTS})
    """Of each part the runs [ms]."""

    def measure(self, frames: int) -> None:
        """Simulate, make a film, draw alone and encode alone, once."""
        simulation = self.made.simulation(THREADS)
        start = simulation.snapshot()
        with TemporaryDirectory() as folder:
            place, film = Path(folder, "cache.zarr"), Path(folder, "film.mp4")
            record(simulation, place, frames)
            simulation.restore(start)
            self._time("simulating", frames, lambda: _simulate(simulation, frames))
            cache, options = Cache.open(place), RenderOptions(size=SIZE)
            before = _processor()
            self._time("film", frames, lambda: render_film([cache], film, options))
            self.ms["processor time of the film"].append(1e3 * (_processor() - before) / frames)
            with Pictures([cache], options, FILM) as pictures:
                self._time("drawing", frames, lambda: _draw(pictures, frames))
                kept = [pictures.picture([frame]) for frame in range(min(KEPT, frames))]
            shown = [kept[frame % len(kept)] for frame in range(frames)]
            self._time("encoding", frames, lambda: _encode(film, shown))

    def spread(self, part: str) -> Spread:
        """What a part took [ms]."""
        return Spread.of(self.ms[part])

    def text(self) -> str:
        """The medians."""
        one = {part: f"{self.spread(part).median:.1f}" for part in PARTS}
        return (
            f"{self.name}: {one['film']} against {one['simulating']} ms (alone {one['drawing']} drawing and "
            f"{one['encoding']} encoding; {one['processor time of the film']} ms of processor time)"
        )

    def _time(self, part: str, frames: int, work: Callable[[], None]) -> None:
        begun = perf_counter()
        work()
        self.ms[part].append(1e3 * (perf_counter() - begun) / frames)


def film(effort: Effort) -> Row:
    """Films of a sheet of 65² on a ball and of one that touches nothing, measured in turn."""
    across, frames = effort.cells(64) + 1, min(FRAMES, effort.frames)
    found = [
        Filmed(f"{across}² on a ball", stage("ball", across, mesh=False)),
        Filmed(f"{across}² without contact", without(across, mesh=False)),
    ]
    for _ in range(effort.runs):
        for one in found:
            one.measure(frames)
    met = all(one.spread("film").median <= one.spread("simulating").median for one in found)
    target = (
        f"a frame of a film of {SIZE[0]} x {SIZE[1]}, first 2 s: no longer than the simulation of 65², "
        "with contact and without"
    )
    lines = [
        "| case | " + " | ".join(f"{part} [ms]" for part in PARTS) + " |",
        "|---" * (1 + len(PARTS)) + "|",
    ]
    lines += [
        " | ".join(["| " + one.name, *(one.spread(part).text() for part in PARTS)]) + " |" for one in found
    ]
    spread = "; ".join(f"{one.spread('film').text()} ms" for one in found)
    reached = "; ".join(one.text() for one in found)
    return Row(target, reached, met, str(THREADS), spread, "\n".join(lines) + "\n")


def _simulate(simulation: Simulation, frames: int) -> None:
    for _ in range(frames):
        simulation.step(simulation.substeps)


def _draw(pictures: Pictures, frames: int) -> None:
    for frame in range(frames):
        pictures.picture([frame])


def _encode(film: Path, pictures: list[Image.Image]) -> None:
    with Encoder(film.with_stem("encoded"), pictures[0].size, 60.0) as encoder:
        for picture in pictures:
            encoder.write(picture)


def _processor() -> float:
    """Processor time of this process and of those that it started and that ended [s]."""
    return sum(os.times()[:4])
