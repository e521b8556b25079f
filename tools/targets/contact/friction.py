"""The row about friction: slopes, a strip over a rod, a sheet that stops, a strip that is pinched."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from taut import Simulation
from taut.bench.meshes import irregular_sheet

from tools.targets.contact.scenes import SKIN, Fields, Stage, kind, sheet
from tools.targets.contact.watch import Found, row
from tools.targets.table import Effort, Row

G = 9.81  # [m/s^2]
THICKNESS = 0.002  # [m]
REST = SKIN + THICKNESS / 2  # of what lies on a body [m]
AIRLESS: Fields = {"air_drag": 0.0, "drag_coefficient": 0.0, "thickness": THICKNESS}
CREEP = 1e-4  # [m/s], of what sticks
WITHIN, CAPSTAN = 0.02, 0.05
ROD = 0.1  # radius of the rod under the strip [m]
HANGING, WIDTH, LIGHT = 0.4, 0.05, 0.05  # of the strip [m], [m], and the lighter weight [kg]
MORE = {
    "creep": ("creeps [mm/s]", 1e3),
    "slides": ("acceleration off [%]", 100.0),
    "stops": ("distance off [%]", 100.0),
    "capstan": ("ratio of the tensions off [%]", 100.0),
    "stays": ("does not slip", 1.0),
}
Points = NDArray[np.float64]


def friction(effort: Effort) -> Row:
    """All of it."""
    found = []
    for on in ("plane", "box", "cloth"):
        for mu in (0.2, 0.5, 1.0):
            for mesh in (False, True):
                found += _slope(on, mu, mesh, effort)
    for speed in (1.0, 3.0):
        for mesh in (False, True):
            found.append(_stop(speed, mesh, effort))
    for mesh in (False, True):
        found += _capstan(0.3, mesh, effort)
    found.append(_pinch(effort))
    target = (
        "slopes of planes, boxes and cloth, friction 0.2 to 1: at 0.95 of its tangent a sheet creeps by "
        "< 0.1 mm/s, at 1.05 it slides with g (sin - mu cos) within 2 %; strip half round a rod: ratio of "
        "the tensions e^(mu phi) within 5 %; a thrown sheet stops after v²/(2 mu g) within 2 %; a pinched "
        "strip creeps by < 0.1 mm/s"
    )
    return row(target, found, MORE)


def _run(simulation: Simulation, seconds: float, effort: Effort) -> Points:
    """Middle of all vertices in every frame [m], shape (frames + 1, 3)."""
    path = [simulation.exact_positions.mean(axis=0)]

    def keep(simulation: Simulation) -> None:
        path.append(simulation.exact_positions.mean(axis=0))

    simulation.run(max(4, round(60 * seconds)) if effort.divide == 1 else effort.frames, keep)
    return np.array(path)


def _creep(simulation: Simulation, effort: Effort) -> float:
    """How fast the vertex goes that goes furthest in two seconds [m/s]."""
    before = simulation.exact_positions
    frames = len(_run(simulation, 2.0, effort)) - 1
    free = ~simulation.pinned
    moved = np.linalg.norm(simulation.exact_positions - before, axis=1)[free]
    return float(moved.max() / frames * 60)


def _acceleration(path: Points, way: Points) -> float:
    """Along a direction, of a motion at 60 frames a second [m/s^2]."""
    time = np.arange(len(path)) / 60
    return 2 * float(np.polyfit(time, path @ way, 2)[0])


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


def _slope(on: str, mu: float, mesh: bool, effort: Effort) -> list[Found]:
    sticks = Found(f"{on}, friction {mu:g}, {kind(mesh)}, sticks")
    simulation = slope(on, mu, 0.95, mesh)[0].simulation()
    _run(simulation, 1.0, effort)
    sticks.add("creep", _creep(simulation, effort), CREEP)
    slides = Found(f"{on}, friction {mu:g}, {kind(mesh)}, slides")
    made, down = slope(on, mu, 1.05, mesh)
    simulation = made.simulation()
    _run(simulation, 0.3, effort)
    angle = np.arctan(1.05 * mu)
    expected = G * (np.sin(angle) - mu * np.cos(angle))
    first = simulation.cloths[0].vertices
    path = _part(simulation, 1.2, effort, first)
    slides.add("slides", abs(_acceleration(path, down) / expected - 1), WITHIN)
    return [sticks, slides]


def _part(simulation: Simulation, seconds: float, effort: Effort, vertices: int) -> Points:
    """Middle of the first vertices in every frame [m]."""
    path: list[Points] = []
    keep: Callable[[Simulation], None] = lambda now: path.append(now.exact_positions[:vertices].mean(axis=0))  # noqa: E731
    simulation.run(max(4, round(60 * seconds)) if effort.divide == 1 else effort.frames, keep)
    return np.array(path)


def _stop(speed: float, mesh: bool, effort: Effort) -> Found:
    """A sheet that is thrown along a plane."""
    mu = 0.3
    found = Found(f"thrown at {speed:g} m/s, {kind(mesh)}")
    made, way = slope("plane", mu, 0.0, mesh)
    simulation = made.simulation()
    simulation.velocities = np.broadcast_to(np.float32(speed * way), simulation.velocities.shape)
    path = _run(simulation, 1.2 * speed / (mu * G) + 0.3, effort) @ way
    found.add("stops", abs((path[-1] - path[0]) / (speed**2 / (2 * mu * G)) - 1), WITHIN)
    return found


def strip(mu: float, heavy: float, mesh: bool) -> Stage:
    """A strip over a rod, with a light weight at one end and a heavy one at the other."""
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
    fields = AIRLESS | {"friction": mu, "strain_limit": 0.02, "density": 0.1}
    return made.cloth("strip", mesh=(places, faces), weights=weights, **fields)


def pull(mu: float, light: float, per_metre: float) -> float:
    """The pull that just drags a strip over the rod against another, its own weight counted [N]."""
    radius, steps = ROD + REST, 10000
    force = light
    for angle in (np.arange(steps) + 0.5) * np.pi / steps:
        own = per_metre * G * radius
        force += (mu * (force + own * np.sin(angle)) + own * np.cos(angle)) * np.pi / steps
    return force


def _capstan(mu: float, mesh: bool, effort: Effort) -> list[Found]:
    per_metre = 0.1 * WIDTH
    own = per_metre * HANGING
    least = pull(mu, (LIGHT + own) * G, per_metre) / G - own  # the heavy weight that just slips [kg]
    found = []
    for part in (0.95, 1.05, 1.4):
        simulation = strip(mu, part * least, mesh).simulation()
        one = Found(f"rod, {part:g} of the weight that slips, {kind(mesh)}")
        _run(simulation, 0.3, effort)
        if part < 1:
            one.add("creep", _creep(simulation, effort), CREEP)
        else:
            path = _part(simulation, 0.3, effort, len(simulation.mass))
            ends = np.array(path)
            one.add("stays", float(abs(ends[-1, 2] - ends[0, 2]) < 1e-4), 0)
            if part > 1.2:
                one.add("capstan", abs(_ratio(simulation, mu, part * least, effort) - 1), CAPSTAN)
        found.append(one)
    return found


def _ratio(simulation: Simulation, mu: float, heavy: float, effort: Effort) -> float:
    """Of the tensions on both sides while it slips, over that of the formula."""
    order = np.argsort(simulation.mass)
    ends = order[-simulation.scene.document["cloth"][0]["weights"][1]["vertices"].__len__() :]
    heights = []

    def keep(now: Simulation) -> None:
        heights.append(float(now.exact_positions[ends, 2].mean()))

    simulation.run(18 if effort.divide == 1 else effort.frames, keep)
    time = np.arange(len(heights)) / 60
    a = -2 * float(np.polyfit(time, heights, 2)[0])
    own = 0.1 * WIDTH * HANGING
    light_side, heavy_side = (LIGHT + own) * (G + a), (heavy + own) * (G - a)
    return heavy_side / light_side / (pull(mu, light_side, 0.1 * WIDTH) / light_side)


def _pinch(effort: Effort) -> Found:
    """A strip that two boxes clamp with less room than it is thick; nobody prescribes their force."""
    found = Found("pinched strip")
    made = Stage({"fps": 60})
    wide, narrow = 2 * SKIN + THICKNESS + 0.01, 0.9 * (2 * SKIN + THICKNESS)
    for side in (-1, 1):
        box = {"center": [side * (wide / 2 + 0.05), 0, 0], "size": [0.1, 0.3, 0.05]}
        move = [[0.3, [side * (narrow - wide) / 2, 0, 0]]]
        made.body({"name": f"box{side + 1}", "box": box, "friction": 0.5, "move": move})
    fields = AIRLESS | {"friction": 0.5, "rotate": [90.0, 0.0, 90.0], "translate": [0, 0, -0.1]}
    simulation = made.cloth("strip", **fields, **sheet(21, 0.3)).simulation()
    upper = np.flatnonzero(simulation.positions[:, 2] > 0.0499)
    simulation.hold(upper, simulation.exact_positions[upper])
    _run(simulation, 0.5, effort)
    simulation.release(upper)
    _run(simulation, 0.5, effort)
    found.add("creep", _creep(simulation, effort), CREEP)
    return found
