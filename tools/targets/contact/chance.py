"""The row about scenes that chance makes: bodies of all shapes that move and turn, cloths, wind."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from taut.bench.walker import closed

from tools.targets.contact.scenes import FLOOR, Fields, Stage, corner_up, keyframes, sheet
from tools.targets.contact.watch import Case, Found, Watch, measured, row
from tools.targets.table import Effort, Row

SCENES, STEPS = 30, 1000
Random = np.random.Generator


def chance(effort: Effort) -> Row:
    """All scenes; none is left out because it fails."""
    found = measured(_cases(effort), effort)
    target = (
        f"{SCENES} scenes of chance, {STEPS} steps each: spheres, capsules, boxes, meshes that move and "
        "turn, one to three cloths of up to 25², wind: no intersection, no crossing, the limit kept"
    )
    return row(target, found, {})


def _cases(effort: Effort) -> Iterator[Case]:
    for seed in range(SCENES if effort.whole else 4):
        yield f"seed {seed},", partial(_measured, seed, effort)


def _measured(seed: int, effort: Effort) -> Found:
    watch = Watch(f"seed {seed}", scene(seed, effort).simulation())
    steps = STEPS if effort.whole else 20
    # Bodies may press cloth against each other and the floor: there steps are cut.
    return watch.run(steps // watch.simulation.substeps).done(cut=np.inf)


def scene(seed: int, effort: Effort) -> Stage:
    """A scene from its seed."""
    random = np.random.default_rng(seed)
    made = Stage({"fps": 60})
    if random.uniform() < 0.8:
        made.body(FLOOR)
    for number in range(random.integers(1, 5)):
        made.body(_body(f"body{number}", random, made))
    if random.uniform() < 0.5:
        made.document["wind"] = {"velocity": random.uniform(-6, 6, 3).tolist(), "gust": {}}
    for number in range(random.integers(1, 4)):
        _cloth(f"cloth{number}", 1.3 + 0.25 * number, random, made, effort)
    return made


def _body(name: str, random: Random, made: Stage) -> Fields:
    """Somewhere below 1 m."""
    place = np.array([*random.uniform(-0.4, 0.4, 2), random.uniform(0.35, 0.75)])
    size = float(random.uniform(0.05, 0.2))
    shape = random.choice(["sphere", "capsule", "box", "mesh"])
    fields: Fields = {"name": name, "friction": float(random.uniform(0, 0.8))}
    if shape == "sphere":
        fields["sphere"] = {"center": place.tolist(), "radius": size}
    elif shape == "capsule":
        end = place + random.uniform(-0.2, 0.2, 3)
        fields["capsule"] = {"from": place.tolist(), "to": end.tolist(), "radius": size / 2}
    elif shape == "box":
        fields["box"] = corner_up(place, size)["box"] | {"rotate": random.uniform(0, 360, 3).tolist()}
    else:
        made.meshes[name] = _stone(random, size)
        fields |= {"mesh": name, "translate": place.tolist()}
    if random.uniform() < 0.8:
        times = np.cumsum(random.uniform(0.3, 2.0, 8))
        ways = random.uniform(-1, 1, (8, 3)) * [0.5, 0.5, 0.5] + [0, 0, 0.3]
        fields["move"] = keyframes(times, ways)
    if random.uniform() < 0.8:
        angles = np.cumsum(random.uniform(-360, 360, 8))
        angle = keyframes(np.cumsum(random.uniform(0.3, 2.0, 8)), angles)
        fields["turn"] = {"axis": random.normal(size=3).tolist(), "point": place.tolist(), "angle": angle}
    return fields


def _stone(random: Random, radius: float) -> tuple[Any, Any]:
    """A closed, uneven surface round the origin."""
    around, count = 16, 9
    angle = np.arange(around) * 2 * np.pi / around
    slope = np.linspace(0, np.pi, count + 2)[1:-1, None]
    flat = np.broadcast_to(np.sin(slope), (count, around))
    rings = np.stack([flat * np.cos(angle), flat * np.sin(angle), -np.cos(slope) + 0 * flat], axis=-1)
    return closed(radius * rings * random.uniform(0.8, 1.2, (count, around, 1)))


def _cloth(name: str, height: float, random: Random, made: Stage, effort: Effort) -> None:
    across = effort.cells(int(random.integers(8, 25))) + 1
    fields: Fields = {
        "thickness": float(random.uniform(0.002, 0.006)),
        "friction": float(random.uniform(0, 0.8)),
        "strain_limit": float(random.choice([0.01, 0.05, 0.1])),
        "bending": random.choice(["fabric", "none"]),
        "translate": [*random.uniform(-0.1, 0.1, 2).tolist(), height],
        "rotate": [0, 0, float(random.uniform(0, 360))],
    }
    if fields["bending"] == "none":
        del fields["bending"]
    if random.uniform() < 0.4:
        fields["pins"] = [{"vertices": [0]}]
    size, mesh, seed = float(random.uniform(0.4, 1.0)), random.uniform() < 0.5, int(random.integers(1, 99))
    made.cloth(name, **sheet(across, size, mesh, seed), **fields)
