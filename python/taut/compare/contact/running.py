"""One method on a scene: into a cache, frame by frame looked at by the judge."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from taut.cache import Cache
from taut.compare.contact.distance import Numbers
from taut.compare.contact.filtered import Filtered, surface_points, world_of
from taut.compare.contact.judge import Judge
from taut.compare.contact.methods import Method
from taut.compare.measure import OVER
from taut.compare.running import Conditions
from taut.errors import SimulationError
from taut.run import Progress, record
from taut.scene import Scene
from taut.simulation import Simulation


@dataclass(frozen=True, slots=True)
class Moment:
    """A frame."""

    time: float
    """[s]"""
    crossings: int
    """Edges that pass through triangles [1]."""
    inside: int
    """Vertices inside of bodies, where nothing crosses [1]."""
    closest: float
    """Least distance over the thickness [1], 1 at most."""
    worst_stretch: float
    """Of the structural and shear springs [1]."""
    worst_before_contact: float
    """The same where the last step would have gone without contact [1]: what the strain limit left."""
    over_limit: float
    """Share of these over their limit [1]."""
    energy: float
    """Kinetic, elastic and potential [J], at the middle of the last step."""
    rigid: int
    """Most vertices in rigid zones in a step [1]."""
    rounds: int
    """Times that collisions were looked for, summed over the steps [1]."""
    unclear: int
    """Steps in which the method gave up [1]."""


@dataclass(frozen=True, slots=True)
class Figures:
    """What a run came to."""

    frames: int
    """Frames, the initial state included [1]."""
    steps_per_frame: int
    """Steps a frame [1]."""
    intersecting_frames: int
    """Frames in which something crosses or is inside of something [1]."""
    first_intersection: float | None
    """When the first of them is [s]; nothing if there is none."""
    closest: float
    """Least distance of all frames over the thickness [1], 1 at most; 0 where something crosses."""
    worst_stretch: float
    """Of any spring in any frame [1]."""
    worst_before_contact: float | None
    """The same before contact changed steps [1]: what the strain limit left; nothing for the engine's own."""
    over_limit: float
    """Share of springs and frames over their limit [1]."""
    energy_gained: float | None
    """Largest rise of all energy above its least value before [J]; nothing where work is done on it."""
    rigid: float
    """Largest share of vertices that a step makes rigid [1]."""
    rounds_per_step: float | None
    """How often collisions are looked for in a step [1], mean; nothing for the engine's own."""
    given_up: int
    """Steps that the method leaves with collisions it knows of [1]."""
    ms_per_frame: float | None
    """Median wall-clock time of a frame [ms]; nothing for the initial state alone."""


@dataclass(frozen=True, slots=True)
class Run:
    """A method on a scene."""

    method: str
    """Its name."""
    cache: str
    """The recorded run, from the folder of the comparison."""
    figures: Figures
    moments: tuple[Moment, ...]
    """Every frame."""
    ended: str | None
    """Why it ended before its time; nothing if it did not."""


class Watched:
    """A simulation with a method, and what is seen of it."""

    def __init__(self, method: Method, scene: Scene, threads: int | None) -> None:
        """Put it at its start.

        Raises:
            CompareError: the scene has points without triangles.
            SceneError: the scene cannot be simulated, or a bound on steps is not kept.
        """
        self.simulation: Simulation
        if method.resolve is None:
            self.simulation = Simulation(scene, threads)
            bodies, world = self.simulation, world_of(self.simulation, scene, self.simulation)
        else:
            self.simulation = filtered = Filtered(scene, method.resolve, threads)
            bodies, world = filtered.guide, filtered.world
        self._bodies, self._judge = bodies, Judge(world, bodies)
        self._gravity = np.array(scene.document["gravity"], np.float64)
        self._springs = self.simulation.springs[self.simulation.spring_kind < 2]
        chosen = self.simulation.spring_kind < 2
        self._rest = self.simulation.rest_length[chosen].astype(np.float64)
        self._limit = self.simulation.strain_limit[chosen].astype(np.float64)
        self.moments = [self.look()]

    def look(self) -> Moment:
        """What is seen now."""
        simulation = self.simulation
        outcomes = simulation.outcomes if isinstance(simulation, Filtered) else []
        places = self._places()
        seen = self._judge.look(places)
        stretch = self._stretch(places)
        before = self._stretch(simulation.proposed) if isinstance(simulation, Filtered) else stretch
        return Moment(
            time=simulation.time,
            crossings=seen.crossings,
            inside=seen.inside,
            closest=seen.closest,
            worst_stretch=float(stretch.max(initial=0.0)),
            worst_before_contact=float(before.max(initial=0.0)),
            over_limit=float((stretch > self._limit + OVER).mean()) if len(stretch) else 0.0,
            energy=self._energy(),
            rigid=max((outcome.rigid for outcome in outcomes), default=0),
            rounds=sum(outcome.rounds for outcome in outcomes),
            unclear=sum(not outcome.clear for outcome in outcomes),
        )

    def _stretch(self, places: Numbers) -> Numbers:
        ways = places[self._springs[:, 1]] - places[self._springs[:, 0]]
        return np.asarray(np.linalg.norm(ways, axis=1) / self._rest - 1.0)

    def _places(self) -> Numbers:
        if isinstance(self.simulation, Filtered):
            return self.simulation.places
        return np.concatenate([self.simulation.exact_positions, surface_points(self._bodies)])

    def _energy(self) -> float:
        """Of velocities at the ends of steps.

        Methods in NumPy move by h V: theirs are those of the middle of the last step. Half a step of fall
        before its end the potential energy is higher by half of what gravity works in it.
        """
        simulation, report = self.simulation, self.simulation.report
        energy = report.kinetic_energy + report.elastic_energy + report.potential_energy
        if isinstance(simulation, Filtered) and simulation.steps:
            momentum = simulation.mass.astype(np.float64) @ simulation.velocities.astype(np.float64)
            energy += 0.5 * simulation.step_length * float(momentum @ self._gravity)
        return energy


def run(method: Method, scene: Scene, label: str, folder: Path, place: str, conditions: Conditions) -> Run:
    """Simulate a scene with a method, into a new cache.

    Args:
        method: which.
        scene: what is simulated.
        label: for whoever watches the progress.
        folder: of the comparison.
        place: the cache, from there.
        conditions: what is the same for all methods.

    Raises:
        CompareError: the method does not simulate the scene.
        SceneError: the scene cannot be simulated.
        CacheWriteError: the disk is full, say.
    """
    watched = Watched(method, scene, conditions.threads)

    def tell(now: Progress) -> None:
        watched.moments.append(watched.look())
        moment = watched.moments[-1]
        note = "intersects" if moment.crossings or moment.inside else f"closest {100 * moment.closest:.3g} %"
        conditions.watch(label, now.frame + 1, now.frames, note)

    ended = None
    try:
        record(watched.simulation, folder / place, conditions.frames, on_frame=tell)
    except SimulationError as error:
        ended = str(error)
    moments = tuple(watched.moments)
    figures = summed(moments, watched.simulation, scene, method, Cache.open(folder / place))
    return Run(method.name, place, figures, moments, ended)


def summed(
    moments: tuple[Moment, ...], simulation: Simulation, scene: Scene, method: Method, cache: Cache
) -> Figures:
    """The figures of a run from its frames."""
    bad = [moment for moment in moments if moment.crossings or moment.inside]
    energy = np.array([moment.energy for moment in moments])
    steps = simulation.substeps * max(1, len(moments) - 1)
    ms = cache.diagnostics["ms"][1:]
    return Figures(
        frames=len(moments),
        steps_per_frame=simulation.substeps,
        intersecting_frames=len(bad),
        first_intersection=bad[0].time if bad else None,
        closest=min(moment.closest if moment not in bad else 0.0 for moment in moments),
        worst_stretch=max(moment.worst_stretch for moment in moments),
        worst_before_contact=(
            None if method.resolve is None else max(one.worst_before_contact for one in moments)
        ),
        over_limit=float(np.mean([moment.over_limit for moment in moments])),
        energy_gained=None if no_energy(scene) else float((energy - np.minimum.accumulate(energy)).max()),
        rigid=max(moment.rigid for moment in moments) / len(simulation.mass),
        rounds_per_step=None if method.resolve is None else sum(one.rounds for one in moments) / steps,
        given_up=sum(moment.unclear for moment in moments),
        ms_per_frame=float(np.median(ms)) if ms.size else None,
    )


def no_energy(scene: Scene) -> str | None:
    """Why a gain of energy is not told; nothing where it is."""
    document = scene.document
    held = [*document.get("body", ()), *(pin for cloth in document["cloth"] for pin in cloth.get("pins", ()))]
    if any(one.get(way) for one in held for way in ("move", "turn", "follow", "motion")):
        return "what moves by itself does work on the cloth"
    return "the wind does work on the cloth" if document.get("wind") else None
