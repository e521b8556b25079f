"""The run loop: simulate a frame, write it, tell who watches."""

import operator
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from taut import _taut
from taut.cache import Cache, CacheWriter, Frame, Header, mesh_hash
from taut.errors import CacheError, SimulationError
from taut.report import Report
from taut.simulation import Simulation


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run has come."""

    frame: int
    """Index of the frame that was just written."""
    frames: int
    """Frames that there will be, the initial state included [1]."""
    worst_stretch: float
    """Largest stretch in all frames so far [1]."""
    report: Report
    """What happened in this frame."""


@dataclass(frozen=True, slots=True)
class Recording:
    """What :func:`record` did."""

    path: Path
    """The cache."""
    frames: int
    """Frames in it [1]."""
    resumed_at: int | None
    """Frames that it had before; nothing for a new cache."""
    notes: list[str]
    """What was found and repaired in a cache that was resumed, one sentence each."""


Existing = Literal["refuse", "resume", "overwrite"]
"""What to do with a cache that is there."""


def record(
    simulation: Simulation,
    out: str | Path,
    frames: int | None = None,
    existing: Existing = "refuse",
    on_frame: Callable[[Progress], object] | None = None,
) -> Recording:
    """Simulate from the start and write every frame to a cache, see :class:`taut.cache.Cache`.

    A run that is stopped or killed at any moment leaves whole frames; with ``existing="resume"`` it goes
    on from the last of them and ends in the same state, bit by bit.

    Args:
        simulation: a simulation at its start; when a cache is resumed it is moved to the cache's last frame.
        out: where the cache is, or will be.
        frames: frames in the cache, the initial state included [1]; those of the scene when left out.
        existing: what to do with a cache that is there: ``refuse``, ``resume`` or ``overwrite`` it.
        on_frame: called after each frame; an exception that it raises stops the run, and no frame is lost.

    Raises:
        CacheError: `out` exists, is being written, or belongs to another scene.
        CacheWriteError: the disk is full, say; the frames written before stay readable.
        SimulationError: a vertex became non-finite; the frames before are in the cache.
        ValueError: fewer than one frame, an unknown `existing`, or the simulation is not at its start.
    """
    frames = simulation.scene.frames if frames is None else operator.index(frames)
    if existing not in get_args(Existing):
        raise ValueError(f"existing = {existing!r}: must be one of {', '.join(get_args(Existing))}")
    if frames < 1:
        raise ValueError(f"frames = {frames}: must be 1 or more; frame 0 is the initial state")
    if simulation.steps != 0:
        raise ValueError(
            f"the simulation is at t = {simulation.time} s: a cache starts at t = 0; make a new Simulation"
        )
    out = Path(out)
    resumed_at = None
    if existing == "resume" and os.path.exists(out):
        writer = CacheWriter.resume(out, _header(simulation))
        resumed_at = writer.frames
    else:
        writer = CacheWriter.create(
            out, _header(simulation), _frame(simulation, ms=0.0), existing == "overwrite"
        )
    with writer:
        worst = simulation.report.worst_stretch
        if resumed_at is not None and resumed_at < frames:
            cache = Cache.open(out)
            worst = float(cache.diagnostics["worst_stretch"].max())
            _move_to(simulation, cache, resumed_at - 1)
        while writer.frames < frames:
            frame = _advance(simulation, writer.frames)
            writer.append(frame)
            worst = max(worst, frame.report.worst_stretch)
            if on_frame is not None:
                on_frame(Progress(writer.frames - 1, frames, worst, frame.report))
    return Recording(out, writer.frames, resumed_at, writer.notes)


def _advance(simulation: Simulation, index: int) -> Frame:
    start = time.perf_counter()
    try:
        simulation.step(simulation.substeps)
    except SimulationError as error:
        raise SimulationError(f"frame {index}: {error}; frames 0 to {index - 1} are kept") from None
    return _frame(simulation, ms=1e3 * (time.perf_counter() - start))


def _move_to(simulation: Simulation, cache: Cache, frame: int) -> None:
    state = cache.local_positions(frame), cache.velocities(frame)
    past = cache.past(frame)
    if past is not None and simulation.past is not None and past.shape != simulation.past.shape:
        raise CacheError(
            f"{cache.path}: keeps {len(past)} vectors of each frame's past, this version needs "
            f"{len(simulation.past)}: another version of taut wrote it; start anew with --overwrite"
        )
    simulation.set_state(*state, frame * simulation.substeps, past, cache.origins(frame))


def _frame(simulation: Simulation, ms: float) -> Frame:
    positions, velocities, past = simulation.positions, simulation.velocities, simulation.past
    origins = simulation.origins
    moved = bool(origins.any())
    local = simulation.local_positions if moved else positions
    # Of what is kept: the hash of a simulation counts pins that a user moved as well.
    found = _taut.state_hash(local, velocities, past, origins)
    bodies = _moving_bodies(simulation)
    frame = Frame(positions, velocities, simulation.report, ms, found, past, bodies=bodies)
    return replace(frame, origins=origins, local_positions=local) if moved else frame


def _moving_bodies(simulation: Simulation) -> NDArray[np.float64] | None:
    moving = [body for body in simulation.body_ranges if body.moves]
    if not moving:
        return None
    places = simulation.body_positions
    return np.concatenate([places[body.first_vertex :][: body.vertices] for body in moving])


def _header(simulation: Simulation) -> Header:
    attributes = {
        "version": _taut.__version__,
        "scene": simulation.scene.document,
        "title": simulation.scene.title,
        "warnings": simulation.warnings,
        "cloths": [cloth._asdict() for cloth in simulation.cloths],
        "substeps": simulation.substeps,
        "step_length": simulation.step_length,
        "threads": simulation.threads,
        "meshes": {name: mesh_hash(mesh) for name, mesh in simulation.meshes.items()}
        | {name: mesh_hash((places,)) for name, (places, _) in simulation.paths.items()},
    }
    arrays: dict[str, NDArray[Any]] = {
        "faces": simulation.faces,
        "springs": simulation.springs,
        "spring_kind": simulation.spring_kind,
        "rest_length": simulation.rest_length,
        "strain_limit": simulation.strain_limit,
        "pins": np.flatnonzero(simulation.pinned),
    }
    if simulation.body_ranges:
        attributes["bodies"] = [body._asdict() for body in simulation.body_ranges]
        arrays["bodies/rest"] = simulation.body_positions
        arrays["bodies/faces"] = simulation.body_triangles
    past = simulation.past
    return Header(attributes, arrays, len(simulation.positions), 0 if past is None else len(past))
