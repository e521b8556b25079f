"""The row about garments: on a figure that walks, and on one whose arm shuts on the cloth."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from taut.bench.meshes import cape, skirt
from taut.bench.shirt import shirt
from taut.bench.walker import SHOULDER, WAIST, squeezer, walk, walker

from tools.targets.contact.scenes import Fields, Stage
from tools.targets.contact.watch import Case, Found, Watch, measured, row
from tools.targets.table import Effort, Row

WORN = (("skirt", 5000), ("shirt", 6400), ("cape", 8000), ("skirt", 16000))
BLOWN = ((2, (-4.0, 6.0, -2.0)), (5, (5.5, 0.3, -0.9)), (7, (7.0, 5.0, -1.0)))  # seeds, and winds [m/s]
BLOWN_VERTICES = 3000
SQUEEZED = 6400  # vertices of the shirt
SECONDS = 4.0  # [s]
MADE = {"skirt": (skirt, WAIST), "shirt": (shirt, SHOULDER - 0.55), "cape": (cape, SHOULDER + 0.3)}
"""What makes a garment, and where its origin is on the figure [m]."""
CLOTH: Fields = {
    "thickness": 0.002,
    "bending": "fabric",
    "strain_limit": 0.05,
    "density": 0.2,
    "friction": 0.3,
}


def garments(effort: Effort) -> Row:
    """All of them."""
    found = measured(_cases(effort), effort)
    target = (
        "skirts of 5,000 and 16,000 vertices, shirt and cape on a walking figure of capsules, skirts of "
        "3,000 in wind that blows them between its legs, shirt on a closed mesh of 10,000 faces whose arm "
        "shuts on it: no intersection, no crossing, the limit kept, ≤ 1 % of the steps in contact cut, no "
        "frame without motion"
    )
    return row(target, found, {})


def _cases(effort: Effort) -> Iterator[Case]:
    for garment, wanted in WORN:
        vertices = effort.garment(wanted)
        name = f"{garment} of {vertices} on a walker"
        yield name, partial(_measured, name, worn(garment, vertices), effort)
    for seed, wind in BLOWN:
        vertices = effort.garment(BLOWN_VERTICES)
        speeds = ", ".join(f"{speed:g}" for speed in wind)
        name = f"skirt of {vertices} on a walker, wind of {speeds} m/s"
        yield name, partial(_measured, name, worn("skirt", vertices, seed, wind), effort)
    vertices = effort.garment(SQUEEZED)
    name = f"shirt of {vertices}, an arm that shuts"
    yield name, partial(_measured, name, squeezed(vertices), effort)


def _measured(name: str, made: Stage, effort: Effort) -> Found:
    return Watch(name, made.simulation()).run(effort.length(SECONDS), driven=True).done(still=0)


def worn(garment: str, vertices: int, seed: int = 1, wind: Sequence[float] = (0.0, 0.0, 0.0)) -> Stage:
    """A garment on a figure that walks, in a wind [m/s]; skirt and cape are held by their upper edge."""
    arms = {"shirt": "spread", "cape": "hanging"}.get(garment, "none")
    made = Stage({"fps": 60}).body(*walker(SECONDS + 1.0, arms))  # type: ignore[arg-type]
    if any(wind):
        made.document["wind"] = {"velocity": list(wind)}
    make, height = MADE[garment]
    mesh = make(vertices, seed=seed)
    if garment == "shirt":
        return made.cloth(garment, mesh=mesh, translate=[0, 0, height], **CLOTH)
    upper = np.flatnonzero(mesh[0][:, 2] > -1e-4).tolist()
    pins = [{"vertices": upper, "move": walk(SECONDS + 1.0)}]
    return made.cloth(garment, mesh=mesh, translate=[0, 0, height], pins=pins, **CLOTH)


def squeezed(vertices: int) -> Stage:
    """A shirt on a torso, one arm of which shuts on the cloth between."""
    places, faces, path = squeezer(SECONDS)
    made = Stage({"fps": 60}, {"figure": (places, faces)}, {"arm": path})
    made.body({"name": "figure", "mesh": "figure", "motion": "arm"})
    return made.cloth("shirt", mesh=shirt(vertices), **CLOTH)
