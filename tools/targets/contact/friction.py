"""The row about friction: slopes, a strip over a rod, a sheet that stops, a strip that is pinched."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from taut import Simulation
from taut.bench.meshes import irregular_sheet

from tools.targets.contact.scenes import SKIN, Fields, Stage, kind, sheet
from tools.targets.contact.watch import Case, Found, measured, row
from tools.targets.rest import CALMING
from tools.targets.table import FULL, Effort, Row

G = 9.81  # [m/s^2]
THICKNESS = 0.002  # [m]
REST = SKIN + THICKNESS / 2  # of what lies on a body [m]
AIRLESS: Fields = {"air_drag": 0.0, "drag_coefficient": 0.0, "thickness": THICKNESS}
CREEP = 1e-4  # [m/s], of what sticks
WITHIN, CAPSTAN = 0.02, 0.05
ROD = 0.1  # radius of the rod under the strip [m]
HANGING, WIDTH, LIGHT = 0.4, 0.05, 0.05  # of the strip [m], [m], and the lighter weight [kg]
FRICTIONS = (0.2, 0.5, 1.0)
DENSITY = 0.1  # of the strip [kg/m^2]
MORE = {
    "creep": ("creeps [mm/s]", 1e3),
    "slides": ("acceleration off [%]", 100.0),
    "stops": ("distance off [%]", 100.0),
    "capstan": ("ratio of the tensions off [%]", 100.0),
    "stays": ("does not slip", 1.0),
}
Points = NDArray[np.float64]
Chosen = NDArray[np.int64] | slice
ALL = slice(None)


def friction(effort: Effort) -> Row:
    """All of it."""
    found = measured(_cases(effort), effort)
    target = (
        "slopes of planes, boxes and cloth, friction 0.2 to 1: at 0.95 of its tangent a sheet creeps by "
        "< 0.1 mm/s, at 1.05 it slides with g (sin - mu cos) within 2 %; strip half round a rod: ratio of "
        "the tensions e^(mu phi) within 5 %; a thrown sheet stops after v²/(2 mu g) within 2 %; a pinched "
        "strip creeps by < 0.1 mm/s"
    )
    return row(target, found, MORE)


def _cases(effort: Effort) -> Iterator[Case]:
    for on in ("plane", "box", "cloth"):
        for mu in FRICTIONS if effort.whole else FRICTIONS[:1]:
            for mesh in (False, True):
                name = f"{on}, friction {mu:g}, {kind(mesh)}"
                yield f"{name}, sticks", partial(_sticks, f"{name}, sticks", on, mu, mesh, effort)
                yield f"{name}, slides", partial(slides, f"{name}, slides", on, mu, mesh, effort)
    for mesh in (False, True):
        for speed in (1.0, 3.0):
            name = f"thrown at {speed:g} m/s, {kind(mesh)}"
            yield name, partial(_stops, name, speed, mesh, effort)
        for part in (0.95, 1.05, 1.4):
            name = f"rod, {part:g} of the weight that slips, {kind(mesh)}"
            yield name, partial(_rod, name, part, mesh, effort)
    for mesh in (False, True):
        for room in (0.9, 0.5):
            name = f"strip pinched to {room:g} of its thickness, {kind(mesh)}"
            yield name, partial(_pinched, name, room, mesh, effort)


def _middles(simulation: Simulation, seconds: float, effort: Effort, chosen: Chosen = ALL) -> Points:
    """Middle of some vertices in every frame [m], shape (frames + 1, 3)."""
    path = [simulation.exact_positions[chosen].mean(axis=0)]

    def keep(now: Simulation) -> None:
        path.append(now.exact_positions[chosen].mean(axis=0))

    simulation.run(effort.length(seconds), keep)
    return np.array(path)


def _creep(simulation: Simulation, effort: Effort, chosen: Chosen) -> float:
    """How fast the vertex goes that goes furthest in two seconds, of those that touch something [m/s]."""
    before = simulation.exact_positions
    frames = effort.length(2.0)
    simulation.run(frames)
    moved = np.linalg.norm(simulation.exact_positions - before, axis=1)[chosen]
    return float(moved.max() / frames * 60)


def _acceleration(path: Points) -> float:
    """Of a motion along a line, at 60 frames a second [m/s^2]."""
    return 2 * float(np.polyfit(np.arange(len(path)) / 60, path, 2)[0])


def slope(on: str, mu: float, steep: float, mesh: bool) -> tuple[Stage, Points]:
    """A sheet on a slope of `steep` times the tangent at which it starts to slide; and the way down."""
    angle = np.arctan(steep * mu)
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    down = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    made, height = Stage({"fps": 60}), REST
    turned = [0.0, float(np.degrees(angle)), 0.0]
    if on == "plane":
        made.body({"name": "slope", "friction": mu, "plane": {"point": [0, 0, 0], "normal": normal.tolist()}})
    elif on == "box":
        box = {"center": (-0.1 * normal).tolist(), "size": [6.0, 2.0, 0.2], "rotate": turned}
        made.body({"name": "slope", "friction": mu, "box": box})
    fields = AIRLESS | {"friction": mu}
    height += 1e-5
    made.cloth("sheet", **fields, **sheet(17, 0.3, mesh), rotate=turned, translate=(height * normal).tolist())
    if on == "cloth":
        # All of it is held: a slope of cloth.
        lower = sheet(33, 1.6, mesh, seed=2)
        place = ((height - THICKNESS - 1e-5) * normal + 0.4 * down).tolist()
        held = [{"vertices": list(range(33**2))}]
        made.cloth("slope", **fields, **lower, rotate=turned, translate=place, pins=held)
    return made, down


def _sticks(name: str, on: str, mu: float, mesh: bool, effort: Effort) -> Found:
    found = Found(name)
    simulation = slope(on, mu, 0.95, mesh)[0].simulation()
    simulation.run(effort.length(1.0))
    found.add("creep", _creep(simulation, effort, slice(simulation.cloths[0].vertices)), CREEP)
    return found


def slides(name: str, on: str, mu: float, mesh: bool, effort: Effort) -> Found:
    """A sheet on a slope of 1.05 times the tangent at which it starts to slide."""
    found = Found(name)
    made, down = slope(on, mu, 1.05, mesh)
    simulation = made.simulation()
    simulation.run(effort.length(0.3))
    angle = np.arctan(1.05 * mu)
    expected = G * (np.sin(angle) - mu * np.cos(angle))
    path = _middles(simulation, 1.2, effort, slice(simulation.cloths[0].vertices))
    found.add("slides", abs(_acceleration(path @ down) / expected - 1), WITHIN)
    return found


def _stops(name: str, speed: float, mesh: bool, effort: Effort) -> Found:
    """A sheet that is thrown along a plane."""
    found, mu = Found(name), 0.3
    made, way = slope("plane", mu, 0.0, mesh)
    simulation = made.simulation()
    simulation.velocities = np.broadcast_to(np.float32(speed * way), simulation.velocities.shape)
    path = _middles(simulation, 1.2 * speed / (mu * G) + 0.3, effort) @ way
    found.add("stops", abs((path[-1] - path[0]) / (speed**2 / (2 * mu * G)) - 1), WITHIN)
    return found


def strip(mu: float, heavy: float, mesh: bool, drag: float = 0.0) -> Stage:
    """A strip over a rod, light and heavy weights at its ends, in air of such a drag [1/s]."""
    radius = ROD + REST + 2e-4
    cells = round((np.pi * radius + 2 * HANGING) / 0.0125), 4
    length = np.pi * radius + 2 * HANGING
    vertices, faces = irregular_sheet(cells, (length, WIDTH), quads=not mesh)
    along = vertices[:, 0] - HANGING
    angle = np.clip(along / radius, 0, np.pi)
    below = np.where(along < 0, along, np.minimum(0, np.pi * radius - along))
    places = np.column_stack(
        [-radius * np.cos(angle), vertices[:, 1] - WIDTH / 2, radius * np.sin(angle) + below]
    )
    ends = [np.flatnonzero(vertices[:, 0] == end).tolist() for end in (0.0, vertices[:, 0].max())]
    weights = [{"vertices": end, "mass": mass} for end, mass in zip(ends, (LIGHT, heavy), strict=True)]
    rod = {"from": [0, -0.3, 0], "to": [0, 0.3, 0], "radius": ROD}
    made = Stage({"fps": 60}).body({"name": "rod", "capsule": rod, "friction": mu})
    fields = AIRLESS | {"friction": mu, "strain_limit": 0.02, "density": DENSITY, "air_drag": drag}
    return made.cloth("strip", mesh=(places, faces), weights=weights, **fields)


def pull(mu: float, light: float, per_metre: float) -> float:
    """The pull that just drags a strip over the rod against another, its own weight counted [N]."""
    radius, steps = ROD + REST, 10000
    force = light
    for angle in (np.arange(steps) + 0.5) * np.pi / steps:
        own = per_metre * G * radius
        force += (mu * (force + own * np.sin(angle)) + own * np.cos(angle)) * np.pi / steps
    return force


def _rod(name: str, part: float, mesh: bool, effort: Effort) -> Found:
    """A strip over a rod with so much of the weight that would just make it slip."""
    found, mu = Found(name), 0.3
    per_metre = DENSITY * WIDTH
    own = per_metre * HANGING
    heavy = part * (pull(mu, (LIGHT + own) * G, per_metre) / G - own)
    # Weights that bounce and sway pull more than at rest: what is to stick must have come to rest.
    made = strip(mu, heavy, mesh, CALMING if part < 1 else 0.0)
    simulation = made.simulation()
    simulation.run(effort.length(4.0 if part < 1 else 0.3))
    if part < 1:
        found.add("creep", _creep(simulation, effort, np.flatnonzero(simulation.positions[:, 2] > 0)), CREEP)
        return found
    ends = np.array(made.document["cloth"][0]["weights"][1]["vertices"])
    heights = _middles(simulation, 0.3, effort, ends)[:, 2]
    found.add("stays", float(heights[0] - heights[-1] < 1e-4), 0)
    if part > 1.2:
        # What hangs moves alike: its acceleration says what the tensions are on both sides.
        down = -_acceleration(heights)
        light = (LIGHT + own) * (G + down)
        found.add("capstan", abs((heavy + own) * (G - down) / pull(mu, light, per_metre) - 1), CAPSTAN)
    return found


def pinched(cells: int, mesh: bool, room: float, mu: float, up: float = 0.0) -> Stage:
    """A strip of 0.3 m between two boxes that leave a part of its room, and rise from 1 to 2 s [m]."""
    made = Stage({"fps": 60})
    wide, narrow = 2 * SKIN + THICKNESS + 0.01, room * (2 * SKIN + THICKNESS)
    for side in (-1, 1):
        box = {"center": [side * (wide / 2 + 0.05), 0, 0], "size": [0.1, 0.3, 0.05]}
        way = side * (narrow - wide) / 2
        move = [[0.3, [way, 0, 0]], [1.0, [way, 0, 0]], [2.0, [way, 0, up]]]
        made.body({"name": f"box{side + 1}", "box": box, "friction": mu, "move": move})
    fields = AIRLESS | {"friction": mu, "rotate": [90.0, 0.0, 90.0], "translate": [0, 0, -0.1]}
    return made.cloth("strip", **fields, **sheet(cells + 1, 0.3, mesh))


def let_go(simulation: Simulation, effort: Effort = FULL) -> Chosen:
    """Holds the strip by its upper edge until boxes have closed on it. Returns what is between them then."""
    upper = np.flatnonzero(simulation.positions[:, 2] > 0.0499)
    simulation.hold(upper, simulation.exact_positions[upper])
    simulation.run(effort.length(0.5))
    simulation.release(upper)
    return np.flatnonzero(np.abs(simulation.positions[:, 2]) < 0.023)


def _pinched(name: str, room: float, mesh: bool, effort: Effort) -> Found:
    """A strip that two boxes clamp with less room than it is thick; nobody prescribes their force."""
    found = Found(name)
    simulation = pinched(20, mesh, room, 0.5).simulation()
    between = let_go(simulation, effort)
    found.add("creep", _creep(simulation, effort, between), CREEP)
    return found
