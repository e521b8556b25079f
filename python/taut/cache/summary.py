"""The few numbers that people ask of a finished run."""

from dataclasses import dataclass

import numpy as np

from taut.cache.reader import Cache


@dataclass(frozen=True)
class Summary:
    """Numbers of a run. Stretch is a fraction of the rest length: 0.05 means 5 per cent."""

    title: str
    version: str
    """Version of taut that wrote it."""
    frames: int
    """Whole frames, the initial state included [1]."""
    vertices: int
    springs: int
    duration: float
    """Time of the last frame [s]."""
    substeps: int
    """Steps per frame [1]."""
    step_length: float
    """[s]"""
    threads: int
    ms_per_frame: float | None
    """Median wall-clock time of the simulation of a frame [ms]; nothing for the initial state alone."""
    real_time: float | None
    """Simulated time per wall-clock time of the simulation [1]."""
    limit: float | None
    """Largest strain limit [1]; nothing where a spring has none."""
    worst_stretch: float
    """Largest stretch of any spring in any frame [1]."""
    worst_frame: int
    """First frame in which it occurs."""
    worst_time: float
    """Its time [s]."""
    worst_spring: int
    """Index of the spring; -1 where there are no springs."""
    worst_cloth: str | None
    """Name of the spring's cloth."""
    worst_vertices: tuple[int, int] | None
    """The spring's ends, as indices into `positions`."""
    worst_stretch_in_steps: float
    """Largest stretch after any step, between frames too [1]."""
    limited_steps: int
    """Steps in which the filter changed a velocity [1]."""
    cuts: int
    """Times that the certificate had to shorten the step of a cloth to keep its limit [1]."""
    held_back_pins: int
    """Times that pins of a cloth had to wait: it is not long enough between them, or could not follow [1]."""
    pinched: int
    """Rows of contact that shared too little room, since what they keep apart was pressed from two sides;
    summed over the steps [1]. There skins and thicknesses give way."""
    held_back_bodies: int
    """Bodies that ended behind their paths, since cloth was pressed between them and something else; summed
    over the steps [1]."""
    lost_motion: float
    """Largest part of its motion that the certificate, or the bound on the kinetic energy, took from a
    cloth in a step [1]."""
    mean_lost_motion: float
    """The same, mean of the steps [1]."""
    contacts: int
    """Rows of contact, summed over the steps [1]."""
    contact_cuts: int
    """Steps that were shortened where something would have crossed something else [1]."""
    halved_steps: int
    """Steps that contact had taken in halves, quarters or eighths [1]."""
    closest: float
    """Least distance that the steps found between what touches [m]; infinite where nothing was near."""
    penetrations: int
    """Places where something still intersected in the last frame [1]."""
    detection_ms: float
    """Wall-clock time that contact took to find pairs, summed over the frames [ms]; 0 in caches from before
    that was measured, as are the next two."""
    solve_ms: float
    """The same of springs and rows and of the strain limit's certificate [ms]."""
    certificate_ms: float
    """The same of the certificate of contact [ms]."""
    kinetic_energy: float
    """In the last frame [J]."""
    elastic_energy: float
    """In the last frame [J]."""
    potential_energy: float
    """In the last frame, relative to the origin [J]."""
    state_hash: str
    """XXH3 hash of the last frame, 16 hexadecimal digits."""


def summarize(cache: Cache) -> Summary:
    """Gather the numbers of a run from its cache.

    Raises:
        CacheError: the cache is damaged.
    """
    numbers, attributes = cache.diagnostics, cache.attributes
    worst_frame = int(np.argmax(numbers["worst_stretch"]))
    worst_spring = int(numbers["worst_spring"][worst_frame])
    ends = tuple(map(int, cache.springs[worst_spring])) if worst_spring >= 0 else None
    ms = numbers["ms"][1:]
    limit = float(str(np.max(cache.strain_limit, initial=0.0)))  # the decimal number that was asked for
    return Summary(
        title=cache.title,
        version=str(attributes["version"]),
        frames=cache.frames,
        vertices=cache.vertices,
        springs=len(cache.springs),
        duration=float(cache.time[-1]),
        substeps=int(attributes["substeps"]),
        step_length=float(attributes["step_length"]),
        threads=int(attributes["threads"]),
        ms_per_frame=float(np.median(ms)) if ms.size else None,
        real_time=_ratio(1e3 * float(cache.time[-1]), float(ms.sum())),
        limit=limit if np.isfinite(limit) and len(cache.springs) else None,
        worst_stretch=float(numbers["worst_stretch"][worst_frame]),
        worst_frame=worst_frame,
        worst_time=float(cache.time[worst_frame]),
        worst_spring=worst_spring,
        worst_cloth=cloth_of(cache, ends[0])[0] if ends else None,
        worst_vertices=(ends[0], ends[1]) if ends else None,
        worst_stretch_in_steps=float(np.max(numbers["worst_stretch_in_steps"])),
        limited_steps=int(numbers["limited_steps"].sum()),
        cuts=int(numbers["cuts"].sum()),
        held_back_pins=int(numbers["held_back_pins"].sum()),
        pinched=int(numbers["pinched"].sum()),
        held_back_bodies=int(numbers["held_back_bodies"].sum()),
        lost_motion=float(np.max(numbers["lost_motion"])),
        # Every frame but the first, the initial state, has as many steps.
        mean_lost_motion=float(np.mean(numbers["mean_lost_motion"][1:])) if ms.size else 0.0,
        contacts=int(numbers["contacts"].sum()),
        contact_cuts=int(numbers["contact_cuts"].sum()),
        halved_steps=int(numbers["halved_steps"].sum()),
        closest=float(np.min(numbers["closest"])),
        penetrations=int(numbers["penetrations"][-1]),
        detection_ms=float(numbers["detection_ms"].sum()),
        solve_ms=float(numbers["solve_ms"].sum()),
        certificate_ms=float(numbers["certificate_ms"].sum()),
        kinetic_energy=float(numbers["kinetic_energy"][-1]),
        elastic_energy=float(numbers["elastic_energy"][-1]),
        potential_energy=float(numbers["potential_energy"][-1]),
        state_hash=f"{int(numbers['state_hash'][-1]):016x}",
    )


def cloth_of(cache: Cache, vertex: int) -> tuple[str, int]:
    """Name of the cloth that a vertex belongs to, and the vertex's index within it."""
    for cloth in cache.attributes["cloths"]:
        index = vertex - int(cloth["first_vertex"])
        if 0 <= index < int(cloth["vertices"]):
            return str(cloth["name"]), index
    return "", vertex


def _ratio(simulated: float, measured: float) -> float | None:
    return simulated / measured if measured > 0 else None
