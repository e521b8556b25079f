"""The figures of one run, from its cache; docs/methods/compare.md says in words how each is defined."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.cache import Cache
from taut.simulation import Simulation

Numbers = NDArray[np.float64]

REST_SHARE = 0.02
"""A cloth is at rest below this share of the speed at which it would have fallen by its own size [1]."""

OVER = 1e-5
"""A spring is over its limit if it is longer than (1 + limit + OVER) of its rest length [1]."""

_TURN = 0.01  # of the whole fall: how far the cloth must rise before its first fall has ended
_MOST_VALUES = 20_000_000


@dataclass(frozen=True, slots=True)
class Body:
    """What of a scene does not depend on the method."""

    mass: Numbers
    """Of each vertex [kg], shape (vertices,)."""
    free: NDArray[np.bool_]
    """Whether each vertex is free, not pinned; shape (vertices,)."""
    gravity: Numbers
    """[m/s^2], shape (3,)."""
    size: float
    """Diagonal of the box around all cloth at the start [m]."""
    no_energy: str | None
    """Why the energy that is kept is not defined; nothing where it is."""
    no_momentum: str | None
    """Why the drift of the momentum is not defined; nothing where it is."""

    @classmethod
    def of(cls, simulation: Simulation) -> "Body":
        """Read it from a simulation at its start."""
        document = simulation.scene.document
        gravity = np.array(document["gravity"])
        wind = "the wind does work on the cloth" if document.get("wind") else None
        pins = [pin for cloth in document["cloth"] for pin in cloth.get("pins", ())]
        moving = any({"move", "turn", "follow"} & pin.keys() for pin in pins)
        weightless = None if gravity.any() else "there is no gravity"
        drag = any(cloth["air_drag"] for cloth in document["cloth"])
        held = "pins hold the cloth" if simulation.pinned.any() else None
        return cls(
            mass=simulation.mass.astype(np.float64),
            free=~simulation.pinned,
            gravity=gravity,
            size=float(np.linalg.norm(np.ptp(simulation.positions.astype(np.float64), axis=0))),
            no_energy=wind or ("pins do work on the cloth" if moving else weightless),
            no_momentum=held or wind or ("the air slows the cloth down (air_drag)" if drag else None),
        )

    @property
    def weight(self) -> float:
        """Of what is free [N]."""
        return float(self.mass[self.free].sum() * np.linalg.norm(self.gravity))

    @property
    def rest_speed(self) -> float | None:
        """Speed below which a cloth is at rest [m/s], see :func:`speed`; nothing without gravity."""
        speed = REST_SHARE * float(np.sqrt(np.linalg.norm(self.gravity) * self.size))
        return speed or None


@dataclass(frozen=True, slots=True)
class Figures:
    """What a run came to. Stretch is |X_uv| / L - 1 of the type 1 springs: 0.05 means 5 per cent."""

    frames: int
    """Frames, the initial state included [1]."""
    steps_per_frame: int
    """Steps a frame [1]."""
    worst_stretch: float
    """Of any spring in any frame [1]."""
    worst_structural: float
    """The same of the structural springs alone: warp and weft [1]."""
    p99_stretch: float
    """What 99 in 100 springs stay below, over all frames [1]."""
    mean_stretch: float
    """Mean over all springs and frames, a spring shorter than at rest counting as 0 [1]."""
    over_limit: float
    """Share of springs over their limit, over all frames [1]."""
    ms_per_frame: float | None
    """Median wall-clock time of a frame [ms]; nothing for the initial state alone."""
    ms_per_step: float | None
    """That over the steps of a frame [ms]."""
    energy_kept: float | None
    """When the first fall ends: kinetic and elastic energy over what the fall has given [1]."""
    momentum_drift: float | None
    """Largest deviation of the momentum from what gravity gives, over the largest sum of M |V| [1]."""
    rest_time: float | None
    """From when on the cloth moves more slowly than the rest speed [s]; nothing if it does not."""
    fallen: float | None
    """How far the centre of mass is below its start in the last frame [m]; nothing without gravity."""


def measure(cache: Cache, body: Body) -> Figures:
    """Measure a run.

    Raises:
        CacheError: the cache is damaged.
    """
    stretch, limit, structural = type_one(cache)
    ms = cache.diagnostics["ms"][1:]
    steps = int(cache.attributes["substeps"])
    median = float(np.median(ms)) if ms.size else None
    return Figures(
        frames=cache.frames,
        steps_per_frame=steps,
        worst_stretch=float(cache.diagnostics["worst_stretch"].max()),
        worst_structural=float(stretch[:, structural].max(initial=0.0)),
        p99_stretch=float(np.percentile(stretch, 99)) if stretch.size else 0.0,
        mean_stretch=float(stretch.clip(min=0).mean(dtype=np.float64)) if stretch.size else 0.0,
        over_limit=float((stretch > limit + OVER).mean()) if stretch.size else 0.0,
        ms_per_frame=median,
        ms_per_step=None if median is None else median / steps,
        energy_kept=None if body.no_energy else energy_kept(cache),
        momentum_drift=None if body.no_momentum else _momentum_drift(cache, body),
        rest_time=rest_time(cache, body),
        fallen=float(fall(cache, body)[-1]) if body.weight else None,
    )


def type_one(cache: Cache) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    """Stretch of the type 1 springs in the frames, their limits, and which of them are structural.

    Of very large runs fewer frames are looked at, evenly spread: 20 million values in all.

    Returns:
        Arrays of shape (frames, springs), (springs,) and (springs,).
    """
    chosen = cache.spring_kind < 2
    count = max(1, min(cache.frames, _MOST_VALUES // max(1, int(chosen.sum()))))
    frames = np.unique(np.linspace(0, cache.frames - 1, count).round().astype(int))
    stretch = np.stack([cache.stretch(int(frame))[chosen] for frame in frames])
    return stretch, cache.strain_limit[chosen], cache.spring_kind[chosen] == 0


def speed(cache: Cache, body: Body) -> Numbers:
    """Root mean square speed, by mass, at which what is free has moved since the frame before [m/s].

    It is taken from positions: what is seen. A velocity is that of an instant, and where a filter holds taut
    springs many of them go to and fro within a step that leads nowhere.

    Returns:
        Array of shape (frames,), 0 for the initial state.
    """
    share = body.mass * body.free / max(float(body.mass[body.free].sum()), 1e-30)
    speeds = np.zeros(cache.frames)
    before = cache.positions(0).astype(np.float64)
    for frame in range(1, cache.frames):
        now = cache.positions(frame).astype(np.float64)
        way = float(share @ np.sum((now - before) ** 2, axis=1)) ** 0.5
        speeds[frame] = way / float(cache.time[frame] - cache.time[frame - 1])
        before = now
    return speeds


def fall(cache: Cache, body: Body) -> Numbers:
    """How far the centre of mass of what is free is below its start in each frame [m], shape (frames,)."""
    potential = cache.diagnostics["potential_energy"]
    fallen: Numbers = (potential[0] - potential) / body.weight
    return fallen


def rest_time(cache: Cache, body: Body) -> float | None:
    """The time of the first frame from which on the cloth is at rest [s]; nothing if it never is."""
    if body.rest_speed is None:
        return None
    moving = np.flatnonzero(speed(cache, body) >= body.rest_speed)
    first = int(moving[-1]) + 1 if moving.size else 0
    return float(cache.time[first]) if first < cache.frames else None


def energy_kept(cache: Cache) -> float | None:
    """The energy in motion and in springs where the first fall ends, over what has been there to keep [1].

    The first fall ends in the frame in which the potential energy is lowest before it rises again by a
    hundredth of its range. Where it does not rise, the fall ends in its lowest frame. What has been there to
    keep is the potential energy given up until then and the energy at the start.
    """
    numbers = cache.diagnostics
    potential: Numbers = numbers["potential_energy"]
    other: Numbers = numbers["kinetic_energy"] + numbers["elastic_energy"]
    lowest_yet = np.minimum.accumulate(potential)
    risen = np.flatnonzero(potential > lowest_yet + _TURN * np.ptp(potential))
    end = int(np.argmin(potential[: int(risen[0]) if risen.size else None]))
    given = float(other[0] + potential[0] - potential[end])
    return float(other[end]) / given if given > 0 else None


def _momentum_drift(cache: Cache, body: Body) -> float | None:
    """See :attr:`Figures.momentum_drift`; nothing where nothing moves."""
    start = body.mass @ cache.velocities(0).astype(np.float64)
    drift = motion = 0.0
    for frame in range(cache.frames):
        velocities = cache.velocities(frame).astype(np.float64)
        expected = start + body.mass.sum() * body.gravity * cache.time[frame]
        drift = max(drift, float(np.linalg.norm(body.mass @ velocities - expected)))
        motion = max(motion, float(body.mass @ np.linalg.norm(velocities, axis=1)))
    return drift / motion if motion else None
