"""The row about cloth that is pulled: twisted into a rope, drawn through a funnel, tied into a knot."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tools.targets.contact.knot import knot
from tools.targets.contact.scenes import Fields, Stage, kind, sheet
from tools.targets.contact.travel import rotation
from tools.targets.contact.watch import CUT, Case, Found, Watch, measured, row
from tools.targets.table import Effort, Row

TWIST, DRAWN, TIED = 4.0, 4.0, 4.0  # [s], how long it is pulled
TURNS = 2.0  # of one end against the other
NEARER = 0.45  # what the ends come nearer, so that there is a rope to become [m]
WIDE, TUBE = 0.45, 0.12  # radii of a funnel [m]
CLOTH: Fields = {"thickness": 0.003, "bending": "fabric", "friction": 0.2, "air_drag": 0.5}
BEHIND = 0.01  # [m], how far pins may be from where they should be at the end
TREMBLE = 0.004  # [m], second differences of what is twisted from frame to frame, root mean square
KNOTS = ((0.01, 0.0025), (0.01, 0.0024), (0.0105, 0.0026))  # breadth of ribbons and their cells [m]
Points = NDArray[np.float64]


def pulled(effort: Effort) -> Row:
    """The twist, the funnel and the knot."""
    found = measured(_cases(effort), effort)
    target = (
        "sheet of 49² twisted by two turns under tension, sheet of 65² drawn through a funnel, ribbons of "
        "10 mm in reef knots pulled tight; grids and meshes: no intersection, no crossing, the limit kept, "
        "≤ 1 % of the steps in contact cut (but in knots, which are squeezed), no frame without motion "
        "while pulled, pins within 10 mm of where they should be at the end; what is twisted trembles by "
        "≤ 4 mm (second differences from frame to frame, root mean square)"
    )
    told = {"behind": ("pins behind at the end [mm]", 1e3), "trembles": ("trembles by [mm]", 1e3)}
    return row(target, found, told)


def _cases(effort: Effort) -> Iterator[Case]:
    for mesh in (False, True):
        across = effort.cells(48) + 1
        name = f"twist, {kind(mesh)} of {across}²"
        yield name, partial(_measured, name, twist(across, mesh), TWIST, effort, tremble=TREMBLE)
    for mesh in (False, True):
        across = effort.cells(64) + 1
        name = f"funnel, {kind(mesh)} of {across}²"
        yield name, partial(_measured, name, funnel(across, mesh), DRAWN, effort)
    for mesh in (False, True):
        for broad, cell in KNOTS[:1] if mesh else KNOTS:
            name = f"reef knot of {1e3 * broad:.3g} mm, cells of {1e3 * cell:.2g} mm, {kind(mesh)}"
            yield name, partial(_measured, name, knot(TIED, mesh, broad, cell), TIED, effort, cut=np.inf)


def _measured(
    name: str, made: Stage, seconds: float, effort: Effort, cut: float = CUT, tremble: float = np.inf
) -> Found:
    frames = effort.length(seconds)
    simulation = made.simulation()
    places = [simulation.positions.copy()]
    watch = Watch(name, simulation).run(frames, True, lambda now: places.append(now.positions.copy()))
    # Before that the sheet falls into its twist.
    turns = np.linalg.norm(np.diff(places[frames // 4 :], 2, axis=0), axis=2)
    watch.found.add("trembles", float(np.sqrt((turns**2).mean())), tremble)
    behind = 0.0
    for path, group in zip(made.paths.values(), simulation.pin_groups, strict=True):
        held, should = simulation.exact_positions[group], np.asarray(path)
        off = np.linalg.norm(held - should[min(frames, len(should) - 1)], axis=1)
        behind = max(behind, float(off.max()))
    watch.found.add("behind", behind, BEHIND)
    return watch.done(cut, still=0)


def _followed(made: Stage, fields: Fields, path: Points, chosen: NDArray[np.int64]) -> Stage:
    """With a cloth some vertices of which follow a path."""
    made.paths["path"] = path
    return made.cloth("sheet", pins=[{"vertices": chosen.tolist(), "follow": "path"}], **fields)


def twist(across: int, mesh: bool) -> Stage:
    """A sheet whose ends turn against each other and come nearer, so that it can become a rope."""
    fields = CLOTH | sheet(across, (1.0, 0.5), mesh)
    places = _vertices(fields, across)
    ends = np.flatnonzero(np.abs(places[:, 0]) > 0.5 - 1e-9)
    path = []
    for part in np.linspace(0, 1, round(60 * TWIST) + 1):
        # Soon enough for the edges, which the first turn already makes detours.
        nearer = NEARER / 2 * np.sin(np.pi * min(0.5, part))
        path.append(
            [
                place @ rotation([1, 0, 0], np.pi * TURNS * part * side).T - [nearer * side, 0, 0]
                for place, side in zip(places[ends], np.sign(places[ends, 0]), strict=True)
            ]
        )
    return _followed(Stage({"fps": 60}), fields, np.array(path), ends)


def funnel(across: int, mesh: bool) -> Stage:
    """A sheet on a funnel, drawn down by its middle."""
    size = 0.8
    fields = CLOTH | sheet(across, (size, size), mesh) | {"translate": [0.0, 0.0, 0.02]}
    places = _vertices(fields, across)
    middle = np.flatnonzero(np.linalg.norm(places, axis=1) < max(0.03, 0.8 * size / across))
    start = places[middle] + fields["translate"]
    down = np.linspace(0, 1, round(60 * DRAWN) + 1)[:, None, None] * [0.0, 0.0, -1.3]
    made = Stage({"fps": 60}, {"funnel": shell()})
    made.body({"name": "funnel", "mesh": "funnel", "friction": 0.2})
    return _followed(made, fields, start + down, middle)


def shell(around: int = 64) -> tuple[Points, NDArray[np.int64]]:
    """A funnel with a wall of 10 mm, round the z axis: wide at z = 0, a tube below; it is closed."""
    bend = np.linspace(0, np.pi / 4, 7)
    cone = np.column_stack([np.linspace(WIDE, TUBE + 0.06, 12), np.linspace(0, TUBE + 0.06 - WIDE, 12)])
    last = cone[-1]
    # Where the cone becomes the tube it is rounded.
    radius = 0.06 / (1 - np.cos(np.pi / 4))
    back = bend[::-1]
    drop = radius * (np.sin(np.pi / 4) - np.sin(back))
    arc = np.column_stack([TUBE + radius * (1 - np.cos(back)), last[1] - drop])
    tube = np.column_stack([np.full(8, TUBE), np.linspace(arc[-1, 1], arc[-1, 1] - 0.3, 9)[1:]])
    inner = np.concatenate([cone, arc[1:], tube])
    way = np.gradient(inner, axis=0)
    out = np.column_stack([-way[:, 1], way[:, 0]])
    outer = inner + 0.01 * out / np.linalg.norm(out, axis=1)[:, None]
    profile = np.concatenate([inner, outer[::-1]])
    angle = np.arange(around) * 2 * np.pi / around
    places = np.stack(
        [
            profile[:, None, 0] * np.cos(angle),
            profile[:, None, 0] * np.sin(angle),
            np.broadcast_to(profile[:, None, 1], (len(profile), around)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    number = np.arange(len(places)).reshape(len(profile), around)
    a, b = number, np.roll(number, -1, axis=1)
    c, d = np.roll(b, -1, axis=0), np.roll(a, -1, axis=0)
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return places, faces


def _vertices(fields: Fields, across: int) -> Points:
    """Of a sheet, before it is turned and displaced [m]."""
    if "mesh" in fields:
        return np.asarray(fields["mesh"][0], np.float64)
    grid = fields["grid"]
    low, high = np.array(grid["origin"][:2]), np.array(grid["origin"][:2]) + grid["size"]
    x, y = (np.linspace(low[axis], high[axis], across) for axis in (0, 1))
    yy, xx = np.meshgrid(y, x, indexing="ij")
    return np.column_stack([xx.ravel(), yy.ravel(), np.zeros(across**2)])
