"""Random whole scenes, simulated; what they promise is checked by NumPy alone."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any, ClassVar

import numpy as np
import zarr
from numpy.typing import NDArray
from taut import Scene, SceneError, Simulation, SimulationError, record
from taut.scene.template import toml

from tests.attack.frame import Attack, Case, Outcome
from tests.attack.scenery import EXPLICIT, scene_of, sheet

Array = NDArray[np.float64]

TOLERANCE = 1e-5
"""Stretch over the limit that rounding may leave [1]."""
LOST = 0.01
"""Part of the motion that the certificate may take from cloth without moving pins, mean of the steps [1]."""
FARTHEST = 1e9
"""No hand pulls further than that from the origin [m]."""
WORK = 3e7
"""Springs times steps that a case may take [1]."""


class Whole(Attack):
    """Grids, meshes, networks, weights, moves, gusts, hands; all filters and integrators."""

    name: ClassVar[str] = "whole"
    promise: ClassVar[str] = (
        "random whole scenes: limit, finite, pins in place, motion lost, bits over threads"
    )
    unit: ClassVar[str] = "springs"
    short: ClassVar[int] = 14

    def generate(self, random: Random) -> Case:
        """A scene, its meshes and what hands do to it."""
        return scene_of(random)

    def judge(self, case: Case) -> Outcome:
        """Simulate, frame by frame or into a cache."""
        try:
            run = simulated(case)
        except SceneError:
            return Outcome(refused=True)
        if run is None:
            return Outcome(refused=True)
        failure = run.failure or limit(run) or places(run) or motion(run)
        if not failure and case.get("twice"):
            other = simulated({**case, "threads": 3 - case["threads"]})
            if other is None or other.hash != run.hash:
                failure = "another number of threads gives other bits"
        return Outcome(failure, looked_at=len(run.positions) * len(run.springs))

    def files(self, case: Case) -> dict[str, bytes]:
        """The scene and its meshes."""
        document = case["scene"]
        lines = [f"{key} = {toml(value)}" for key, value in document.items()]
        found = {"scene.toml": "\n".join(lines).encode()}
        for name, shape in case["meshes"].items():
            vertices, faces = sheet(**shape)
            text = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
            text += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces.tolist()]
            found[name] = "\n".join(text).encode()
        return found


@dataclass(slots=True)
class Run:
    """What a simulation did."""

    document: dict[str, Any]
    cloths: list[slice]
    """Vertices of each."""
    springs: NDArray[np.int32]
    rest: Array
    bounded: NDArray[np.bool_]
    """Whether a spring has a limit."""
    groups: list[NDArray[np.int32]]
    """Vertices of each pin."""
    time: list[float] = field(default_factory=list)
    positions: list[Array] = field(default_factory=list)
    """Of each frame [m]."""
    finite: bool = True
    told: list[float] = field(default_factory=list)
    """The worst stretch of each frame, as reported [1]."""
    lost: float = 0.0
    """Motion lost, mean of the steps [1]."""
    waited: bool = False
    touched: bool = False
    """Whether hands, moving pins or changing limits had a part in it."""
    free: bool = False
    """Whether pins left their paths, or vertices that are held lie among them."""
    runs_away: bool = False
    """Whether it was told to take steps that nothing keeps from growing."""
    forced: bool = False
    """Whether its steps were forced: where they are too long, what is lost may be no motion."""
    failure: str = ""
    hash: str = ""


def simulated(case: Case) -> Run | None:
    """Simulate a case; nothing if that would take too long.

    Raises:
        SceneError: it is refused.
    """
    meshes = {name: sheet(**shape) for name, shape in case["meshes"].items()}
    paths = {name: followed(path) for name, path in case["paths"].items()}
    scene = Scene(case["scene"], meshes, paths=paths)
    simulation = Simulation(scene, case["threads"])
    document = scene.document
    effort = max(1, len(simulation.springs)) * simulation.substeps
    frames = min(int(case["frames"]), int(WORK / effort))
    if frames < 1:
        return None
    run = Run(
        document,
        [slice(cloth.first_vertex, cloth.first_vertex + cloth.vertices) for cloth in simulation.cloths],
        simulation.springs,
        simulation.rest_length.astype(np.float64),
        np.isfinite(simulation.strain_limit),
        simulation.pin_groups,
    )
    pins = [pin for cloth in document["cloth"] for pin in cloth["pins"]]
    moving = any(pin.get("move") or pin.get("follow") for pin in pins)
    changing = any(cloth.get("strain_limit_keyframes") for cloth in document["cloth"])
    run.touched = moving or changing or bool(case["hands"])
    solver = document["solver"]
    reasons = solver["force_step"], solver["integrator"] in EXPLICIT
    run.forced = solver["force_step"]
    run.runs_away = all(reasons) or (any(reasons) and solver["filter"] != "coarse_to_fine")
    try:
        if case["hands"] or not case["record"]:
            stepwise(run, simulation, frames, case["hands"])
        else:
            recorded(run, simulation, frames)
    except SimulationError as error:
        run.failure = "" if run.runs_away else f"SimulationError: {error}"
    run.hash = simulation.state_hash
    return run


def followed(path: dict[str, Any]) -> Array:
    """Places of pinned vertices that drift off."""
    random = np.random.default_rng(path["seed"])
    start = np.array(path["start"], np.float64)
    drift = random.normal(size=(path["frames"], 1, 3)) * path["far"]
    drift[0] = 0
    return start + np.cumsum(drift, axis=0)


def stepwise(run: Run, simulation: Simulation, frames: int, hands: list[list[Any]]) -> None:
    """Frame after frame, with what hands do before each."""
    keep(run, simulation)
    lost = []
    for frame in range(frames):
        for _, what, *arguments in (hand for hand in hands if hand[0] == frame):
            run.free |= what in ("hold", "shift")
            touch(simulation, what, arguments)
        lost.append(simulation.step(simulation.substeps).mean_lost_motion)
        run.waited |= simulation.report.held_back_pins > 0
        keep(run, simulation)
    run.lost = float(np.mean(lost))


def keep(run: Run, simulation: Simulation) -> None:
    """The present frame."""
    run.time.append(simulation.time)
    run.positions.append(simulation.exact_positions)
    report = simulation.report
    numbers = [report.kinetic_energy, report.elastic_energy, report.potential_energy]
    # Squares of what has run away may be too large for a number.
    run.finite &= bool(
        np.isfinite(simulation.velocities).all() and (run.runs_away or np.isfinite(numbers).all())
    )
    run.told.append(report.worst_stretch)


def refused(pull: Callable[..., None], *arguments: Any) -> None:
    """What has run away is out of a hand's reach: that is said."""
    try:
        pull(*arguments)
    except ValueError as problem:
        if "of the origin" in str(problem):
            return
        raise
    raise AssertionError("a hand reaches further than it may")


def touch(simulation: Simulation, what: str, arguments: list[Any]) -> None:
    """What a hand does; vertices are given as parts of all of them."""
    vertices = len(simulation.positions)
    match what, arguments:
        case "hold" | "lead", [part, offset, how]:
            vertex = int(part * vertices) % vertices
            pull = simulation.hold if what == "hold" else simulation.lead
            target = simulation.exact_positions[vertex] + offset
            if np.abs(target).max() <= FARTHEST:
                pull(vertex, target, how)
            else:
                refused(pull, vertex, target, how)
        case "release", [part]:
            simulation.release(int(part * vertices) % vertices)
        case "shift", [group, offset, speed] if group < len(simulation.pin_groups):
            simulation.shift_pins(group, offset, speed)
        case "gravity", [value]:
            simulation.gravity = value
        case "wind", [value]:
            simulation.wind = value
        case "back", []:
            snapshot, before = simulation.snapshot(), simulation.state_hash
            simulation.step(1)
            simulation.restore(snapshot)
            if simulation.state_hash != before:
                raise AssertionError("a snapshot restores another state")


def recorded(run: Run, simulation: Simulation, frames: int) -> None:
    """Into a cache, which is read without taut."""
    out = Path("whole.zarr")
    shutil.rmtree(out, ignore_errors=True)
    try:
        record(simulation, out, frames + 1)
    finally:
        keep_all(run, zarr.open_group(out, mode="r"))


def keep_all(run: Run, root: zarr.Group) -> None:
    """The frames of a cache."""

    def read(name: str) -> Any:
        return np.asarray(root[name])

    origins, local, world = read("origins"), read("local_positions"), read("positions")
    counts = [cloth.stop - cloth.start for cloth in run.cloths]
    for frame in range(len(world)):
        far = bool(origins[frame].any())
        places = local[frame] if far else world[frame]
        run.positions.append(np.repeat(origins[frame], counts, axis=0) + places.astype(np.float64))
    run.time = read("time").tolist()
    run.finite = bool(np.isfinite(read("velocities")).all())
    run.told = read("diagnostics/worst_stretch").tolist()
    run.lost = float(np.append(read("diagnostics/mean_lost_motion")[1:], 0).mean())
    run.waited = bool(read("diagnostics/held_back_pins").any())


def limit(run: Run) -> str:
    """What is over its limit or not finite, in any frame."""
    if not run.finite or not all(np.isfinite(places).all() for places in run.positions):
        return "a number is not finite"
    if not len(run.springs):
        return ""
    u, v = run.springs.T
    first = run.positions[0][v] - run.positions[0][u]
    size = np.abs(run.positions[0]).max(initial=0)
    if (np.abs(np.linalg.norm(first, axis=1) - run.rest) > 1e-6 * run.rest + 4e-7 * size).any():
        return "a rest length is not that of the start"
    keeps = run.document["solver"]["filter"] == "coarse_to_fine"
    before = np.zeros(len(run.springs))
    for frame, (time, places) in enumerate(zip(run.time, run.positions, strict=True)):
        stretch = np.linalg.norm(places[v] - places[u], axis=1) / run.rest - 1
        worst = float(stretch[run.bounded].max(initial=-np.inf))  # springs without a limit are not reported
        if (
            not run.runs_away
            and np.isfinite(worst)
            and abs(worst - run.told[frame]) > 1e-4 * (1 + abs(worst))
        ):
            return f"frame {frame}: a stretch of {worst} is reported as {run.told[frame]}"
        # A limit that tightens may be reached later, but nothing beyond it may grow.
        most = np.maximum(limits(run, time), before.max()) if run.touched else limits(run, time)
        over = np.where(run.bounded, stretch - most, 0)
        if keeps and over.max() > TOLERANCE:
            spring = int(over.argmax())
            stretched = f"stretched by {stretch[spring]}, its limit is {most[spring]}"
            return f"frame {frame}: spring {spring} is {stretched}"
        before = np.where(run.bounded, stretch, 0)
    return ""


def limits(run: Run, time: float) -> Array:
    """The limit of each spring at a time [1]."""
    found = np.zeros(len(run.springs))
    for cloth, part in zip(run.document["cloth"], run.cloths, strict=True):
        keys = [[0.0, cloth["strain_limit"]], *cloth.get("strain_limit_keyframes", [])]
        here = (run.springs[:, 0] >= part.start) & (run.springs[:, 0] < part.stop)
        found[here] = np.interp(time, *np.transpose(keys))
    return found


def places(run: Run) -> str:
    """Pins that are not where they should be."""
    if run.free or run.waited:
        return ""
    pins = [pin for cloth in run.document["cloth"] for pin in cloth["pins"]]
    held = np.concatenate([*run.groups, np.zeros(0, np.int32)])
    start = run.positions[0]
    for number, (pin, group) in enumerate(zip(pins, run.groups, strict=True)):
        alone = group[[np.count_nonzero(held == vertex) == 1 for vertex in group]]
        if pin.get("follow") or not len(alone):
            continue
        keys = [[0.0, [0.0, 0.0, 0.0]], *(key for key in pin.get("move", []) if key[0] > 0)]
        times = [time for time, _ in keys]
        size = 0.0
        for frame, now in enumerate(run.positions):
            path = [np.interp(run.time[frame], times, [key[1][axis] for key in keys]) for axis in range(3)]
            off = float(np.abs(now[alone] - start[alone] - path).max())
            extent = np.abs(now[alone] - now.mean(axis=0)).max()
            if run.runs_away:
                # It may come back, and pins with it: they are rounded as far as it has been.
                extent = max(size, np.abs(now - now.mean(axis=0)).max())
            size = extent + np.abs(path).max()
            if off > 1e-6 * (1 + size):
                return f"frame {frame}: pin {number} is {off} m off its place"
    return ""


def motion(run: Run) -> str:
    """Motion that was lost without need."""
    if (
        run.touched
        or run.forced
        or run.runs_away
        or run.document["solver"]["filter"] != "coarse_to_fine"
        or run.lost <= LOST
    ):
        return ""
    return f"{100 * run.lost:.2f} % of the motion was lost without moving pins"
