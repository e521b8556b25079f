"""Random scenes: what may be asked for, in usual and in odd sizes."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.attack.frame import Case

EXPLICIT = ("forward_euler", "midpoint", "rk4", "verlet")
FILTERS = ("sweeps", "sequential", "none", "provot", "rods", "fast_projection", "tethers", "xpbd")
FABRICS = ("cotton", "nylon", "silk", "wool", "denim")
AXES = ("x", "y", "z", "-x", "-y", "-z")


def sheet(cells: list[int], size: float, seed: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A sheet of triangles, its vertices off their places and its cells cut either way."""
    random = np.random.default_rng(seed)
    columns, rows = (max(1, int(count)) for count in cells)
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    x[:, 1:-1] += random.uniform(-0.3, 0.3, x[:, 1:-1].shape)
    y[1:-1] += random.uniform(-0.3, 0.3, y[1:-1].shape)
    vertices = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3) * (size / max(columns, rows))
    index = np.arange(vertices.shape[0]).reshape(rows + 1, columns + 1)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]))
    one = np.stack([a, b, c, a, c, d], axis=1)
    other = np.stack([a, b, d, b, c, d], axis=1)
    turned = random.random(len(a)) < 0.5
    return vertices, np.where(turned[:, None], one, other).reshape(-1, 3)


def scene_of(random: Random) -> Case:
    """A case of :mod:`tests.attack.whole`."""
    meshes: dict[str, Any] = {}
    paths: dict[str, Any] = {}
    scene: dict[str, Any] = {"duration": 10.0, "fps": random.choice([24.0, 30.0, 60.0, 60.0, 120.0, 1000.0])}
    if random.random() < 0.2:
        scene["up"] = "y"
    if random.random() < 0.2:
        scene["gravity"] = vector(random, 15.0)
    if random.random() < 0.15:
        scene["gravity_keyframes"] = [[random.uniform(0.01, 0.5), vector(random, 20.0)]]
    if random.random() < 0.7:
        scene["wind"] = wind(random)
    scene["solver"] = solver(random)
    count = random.choice([1, 1, 1, 2, 3])
    scene["cloth"] = [cloth(random, number, meshes, paths) for number in range(count)]
    hands = [hand(random) for _ in range(random.randint(1, 5))] if random.random() < 0.25 else []
    return {
        "scene": scene,
        "meshes": meshes,
        "paths": paths,
        "hands": hands,
        "frames": random.randint(10, 40),
        "threads": random.choice([1, 2]),
        "twice": random.random() < 0.2,
        "record": random.random() < 0.4,
    }


def size(random: Random, least: float, most: float) -> float:
    """A number, every order of magnitude as likely."""
    return float(f"{10 ** random.uniform(np.log10(least), np.log10(most)):.4g}")


def vector(random: Random, most: float) -> list[float]:
    """Three numbers."""
    return [round(random.uniform(-most, most), 4) for _ in range(3)]


def keys(random: Random, most: float) -> list[Any]:
    """Keyframes of a vector."""
    times = sorted(random.sample(range(1, 60), random.randint(1, 3)))
    return [[time / 100, vector(random, most)] for time in times]


def wind(random: Random) -> dict[str, Any]:
    """Moving air."""
    speed = size(random, 0.1, 40.0)
    found: dict[str, Any] = {
        "velocity": vector(random, speed),
        "model": random.choice(["particle", "triangle"]),
        "law": random.choice(["pressure", "drag_lift"]),
    }
    if random.random() < 0.5:
        strength, period = random.uniform(0, 1), size(random, 0.05, 5.0)
        found["gust"] = {"strength": strength, "period": period, "seed": random.randint(0, 99)}
    if random.random() < 0.2:
        found["keyframes"] = keys(random, speed)
    if random.random() < 0.2:
        place = {"centre": vector(random, 2.0), "core": size(random, 0.01, 1.0)}
        found["elements"] = [
            random.choice(
                [
                    {"kind": "uniform", "velocity": vector(random, 10.0)},
                    {"kind": "source", "flow": random.uniform(-5, 5), **place},
                    {
                        "kind": "vortex",
                        "axis": [0.0, 0.1, 1.0],
                        "circulation": random.uniform(-9, 9),
                        **place,
                    },
                ]
            )
        ]
    return found


def solver(random: Random) -> dict[str, Any]:
    """How it is simulated; half of all scenes as by default."""
    found: dict[str, Any] = {}
    if random.random() < 0.3:
        found["filter"] = random.choice(FILTERS)
        found["iterations"] = random.choice([1, 3, 10, 50])
    if random.random() < 0.3:
        found["integrator"] = random.choice(["euler", "implicit_euler", "bdf2", *EXPLICIT])
    if random.random() < 0.3:
        found["substeps"] = random.choice([1, 2, 4, 8, 24])
        found["force_step"] = random.random() < 0.7
    return found


def cloth(random: Random, number: int, meshes: dict[str, Any], paths: dict[str, Any]) -> dict[str, Any]:
    """One cloth with its pins and weights."""
    found: dict[str, Any] = {"name": f"cloth {number}"}
    kind = random.choice(["grid", "grid", "mesh", "network"])
    length = size(random, 0.05, 5.0)
    if kind == "grid":
        cells = [random.randint(1, random.choice([4, 24])) for _ in range(2)]
        first, second = random.sample(AXES, 2)
        while first[-1] == second[-1]:
            second = random.choice(AXES)
        sides = [length, float(f"{length * size(random, 0.3, 3):.4g}")]
        found["grid"] = {"size": sides, "cells": cells, "axes": [first, second]}
        vertices = (cells[0] + 1) * (cells[1] + 1)
    elif kind == "mesh":
        cells = [random.randint(1, 16), random.randint(1, 16)]
        name = f"mesh{number}.obj"
        meshes[name] = {"cells": cells, "size": length, "seed": random.randint(0, 999)}
        found["mesh"] = name
        vertices = (cells[0] + 1) * (cells[1] + 1)
    else:
        found["network"] = network(random, length)
        vertices = len(found["network"]["points"])
    if random.random() < 0.3:
        found["rotate"] = [float(random.randint(-180, 180)) for _ in range(3)]
    if random.random() < 0.3:
        found["translate"] = vector(random, random.choice([1.0, 10.0, 1e5]))
    material(random, found, kind)
    selectors = [selector(random, kind, vertices) for _ in range(random.choice([0, 1, 1, 1, 2, 3]))]
    found["pins"] = [moved(random, chosen, length) for chosen in selectors]
    if kind == "network" and not {"rotate", "translate"} & found.keys() and random.random() < 0.3:
        found["pins"] = [following(random, found["network"]["points"], f"path{number}.npy", paths)]
    if random.random() < 0.25:
        found["weights"] = [{**selector(random, kind, vertices), "mass": size(random, 1e-4, 1.0)}]
    return found


def network(random: Random, length: float) -> dict[str, Any]:
    """A chain, a net, or points joined at random."""
    kind = random.choice(["chain", "net", "random"])
    mass = size(random, 1e-4, 0.05)
    if kind == "chain":
        count = random.randint(2, 40)
        points = [[length * index / count, 0.0, 0.0] for index in range(count)]
        links = [[index, index + 1] for index in range(count - 1)]
    elif kind == "net":
        side = random.randint(2, 9)
        points = [[length * (i % side) / side, 0.0, length * (i // side) / side] for i in range(side**2)]
        links = [[i, i + 1] for i in range(side**2) if i % side < side - 1]
        links += [[i, i + side] for i in range(side * (side - 1))]
    else:
        count = random.randint(2, 30)
        points = [vector(random, length) for _ in range(count)]
        pairs = {tuple(sorted(random.sample(range(count), 2))) for _ in range(2 * count)}
        links = [list(pair) for pair in sorted(pairs)]
    masses = mass if random.random() < 0.7 else [mass * random.uniform(0.5, 20) for _ in points]
    return {"points": points, "links": links, "mass": masses}


def material(random: Random, found: dict[str, Any], kind: str) -> None:
    """Fields that say what it is made of."""
    if random.random() < 0.7 and kind != "network":
        found["fabric"] = random.choice(FABRICS)
    if kind == "network":
        found["stiffness"] = size(random, 1.0, 300.0)
    elif random.random() < 0.3:
        found["stiffness"] = size(random, 1.0, 500.0)
        found["density"] = size(random, 0.02, 2.0)
    if random.random() < 0.6:
        found["strain_limit"] = random.choice([0.005, 0.01, 0.02, 0.05, 0.1, 0.3])
    if random.random() < 0.1:
        found["strain_limit_keyframes"] = [[0.05, random.choice([0.01, 0.1, 0.2])], [0.2, 0.05]]
    if random.random() < 0.3:
        found["bending"] = size(random, 1e-7, 1e-3)
        found["bending_model"] = random.choice(["quadratic", "choi_ko"])
    if random.random() < 0.2:
        found["damping"] = size(random, 1e-4, 0.1)
    if random.random() < 0.2:
        found["air_drag"] = size(random, 0.01, 5.0)
    if random.random() < 0.1:
        found["flexion_stiffness"] = size(random, 0.1, 10.0)
    if random.random() < 0.2:
        found["friction_coefficient"] = size(random, 1e-3, 0.1)


def selector(random: Random, kind: str, vertices: int) -> dict[str, Any]:
    """Some vertices."""
    choice = random.choice(["edge", "corner", "vertices", "nearest"])
    if choice == "edge" and kind == "grid":
        return {"edge": random.choice(["left", "right", "top", "bottom"])}
    if choice == "corner" and kind == "grid":
        return {"corner": random.choice(["top-left", "top-right", "bottom-left", "bottom-right"])}
    if choice == "nearest":
        return {"nearest": vector(random, 2.0)}
    return {"vertices": sorted(random.sample(range(vertices), random.randint(1, min(3, vertices))))}


def moved(random: Random, pin: dict[str, Any], length: float) -> dict[str, Any]:
    """A pin that may travel."""
    if random.random() < 0.25:
        return {**pin, "move": keys(random, length * random.choice([0.1, 1.0]))}
    return pin


def following(random: Random, points: list[list[float]], name: str, paths: dict[str, Any]) -> dict[str, Any]:
    """A pin that drifts along an array."""
    chosen = sorted(random.sample(range(len(points)), random.randint(1, 2)))
    paths[name] = {
        "start": [points[vertex] for vertex in chosen],
        "frames": random.randint(2, 40),
        "far": size(random, 1e-4, 0.1),
        "seed": random.randint(0, 999),
    }
    return {"vertices": chosen, "follow": name}


def hand(random: Random) -> list[Any]:
    """Frame, what, and the arguments that :func:`tests.attack.whole.touch` wants."""
    offset = vector(random, size(random, 0.01, 3.0))
    part, speed = round(random.random(), 6), size(random, 0.1, 20.0)
    what = random.choice(
        [
            ["hold", part, offset, random.choice([0.0, 0.1])],
            ["lead", part, offset, speed],
            ["release", part],
            ["shift", random.randint(0, 2), offset, speed],
            ["gravity", vector(random, 20.0)],
            ["wind", random.choice([None, vector(random, 20.0)])],
            ["back"],
        ]
    )
    return [random.randint(0, 10), *what]
