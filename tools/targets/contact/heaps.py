"""The row about cloth that comes to lie on cloth: heaped, stacked, and hit from above."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from taut import Simulation

from tools.targets.contact.scenes import FLOOR, SKIN, Fields, Stage, ball, kind, sheet
from tools.targets.contact.watch import Case, Found, Watch, measured, row
from tools.targets.table import Effort, Row

THICKNESS = 0.004  # [m]
LAYERS = 5
HEIGHT = 0.02  # how far the height of a stack may be off
SQUARES = 20
CLOTH: Fields = {"thickness": THICKNESS, "bending": "fabric"}
MORE = {"height": ("height of the stack off [%]", 100.0)}


def heaps(effort: Effort) -> Row:
    """A sheet on its edge, layers, and a ball on a pile."""
    found = measured(_cases(effort), effort)
    target = (
        "sheet of 65² dropped on its edge, five layers, 20 squares on which a ball comes down at 5 m/s; "
        "grids and meshes: no intersection, no crossing, the limit kept, ≤ 1 % of the steps in contact cut; "
        "height of the stack within 2 % of layers x thickness"
    )
    return row(target, found, MORE)


def _cases(effort: Effort) -> Iterator[Case]:
    for mesh in (False, True):
        across = effort.cells(64) + 1
        name = f"on its edge, {kind(mesh)} of {across}²"
        yield name, partial(_heaped, name, on_its_edge(across, mesh), effort)
    for mesh in (False, True):
        across = effort.cells(32) + 1
        name = f"{LAYERS} layers, {kind(mesh)} of {across}²"
        yield name, partial(_stacked, name, layers(across, mesh), effort)
    name = f"ball of 5 m/s on a pile of {SQUARES} squares"
    yield name, partial(_heaped, name, pile(effort.cells(16) + 1), effort)


def on_its_edge(across: int, mesh: bool) -> Stage:
    """A sheet that stands on its lower edge, nearly."""
    fields = CLOTH | sheet(across, mesh=mesh) | {"rotate": [86.0, 3.0, 0.0], "translate": [0, 0, 0.6]}
    return Stage({"fps": 60}).body(FLOOR).cloth("sheet", **fields)


def layers(across: int, mesh: bool) -> Stage:
    """Squares above each other, a little aside and turned."""
    made = Stage({"fps": 60}).body(FLOOR)
    for layer in range(LAYERS):
        place = [0.004 * layer, -0.003 * layer, 0.01 + 2 * THICKNESS * layer]
        fields = CLOTH | {"air_drag": 1.5} | sheet(across, 0.4, mesh, seed=1 + layer)
        made.cloth(f"layer{layer}", translate=place, rotate=[0, 0, 3.0 * layer], **fields)
    return made


def pile(across: int) -> Stage:
    """Squares that fall on a heap, and a ball that comes down on them and goes up again."""
    random = np.random.default_rng(1)
    # It stops where flat squares just have room.
    low = 0.1 + SKIN + (SQUARES + 2) * THICKNESS
    heavy = ball([0, 0, 1.5], 0.1, move=[[1.0, [0, 0, 0]], [1.0 + (1.5 - low) / 5, [0, 0, low - 1.5]]])
    heavy["move"] += [[2.0, heavy["move"][-1][1]], [2.5, [0, 0, 0]]]
    made = Stage({"fps": 60}).body(FLOOR, heavy)
    for square in range(SQUARES):
        place = [*random.uniform(-0.03, 0.03, 2).tolist(), 0.03 + 0.04 * square]
        turned = [*random.uniform(-5, 5, 2).tolist(), float(random.uniform(0, 360))]
        fields = CLOTH | sheet(across, 0.3, mesh=square % 2 == 1, seed=square)
        made.cloth(f"square{square}", translate=place, rotate=turned, **fields)
    return made


def _heaped(name: str, made: Stage, effort: Effort) -> Found:
    return Watch(name, made.simulation()).run(effort.length(3.0)).done()


def _stacked(name: str, made: Stage, effort: Effort) -> Found:
    watch = Watch(name, made.simulation()).run(effort.length(4.0))
    watch.found.add("height", abs(height(watch.simulation) / (LAYERS * THICKNESS) - 1), HEIGHT)
    return watch.done()


def height(simulation: Simulation) -> float:
    """Of a stack: from the skin of the floor to the upper side of the middle of the last layer [m]."""
    last = simulation.cloths[-1]
    places = simulation.exact_positions[last.first_vertex :][: last.vertices]
    middle = np.linalg.norm((places - places.mean(axis=0))[:, :2], axis=1) < 0.1
    return float(places[middle, 2].mean()) + THICKNESS / 2 - SKIN
