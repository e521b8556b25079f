"""The same bits with vector registers of any width, and in Python as in the tests of the engine."""

import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from taut import Scene, Simulation, _taut

GOLDENS = Path(__file__).parent.parent / "crates/taut/tests/goldens.txt"
KINDS = {1: "baseline", 4: "neon", 8: "avx2", 16: "avx512"}
FILTERS = [
    "coarse_to_fine",
    "sweeps",
    "sequential",
    "none",
    "provot",
    "rods",
    "fast_projection",
    "tethers",
    "xpbd",
]


def flag(cells: list[int], filter: str, wind: str) -> dict[str, Any]:
    """As the tests of the engine have it."""
    gust = {"strength": 0.3, "period": 1.7, "seed": 1}
    grid = {"size": [1.5, 1.0], "cells": cells, "origin": [0, 0, 1]}
    cloth = {"grid": grid, "fabric": "nylon", "density": 0.2, "pins": [{"edge": "left"}]}
    return {
        "wind": {"velocity": [8.0, 1.5, 0.0], "gust": gust, "model": wind},
        "cloth": [cloth],
        "solver": {"filter": filter, "iterations": 10},
    }


def crooked(cells: int) -> tuple[Any, Any]:
    """A sheet of triangles, its vertices off their places and its cells cut either way."""

    def random(seed: int) -> float:
        return seed * 0.618034 % 1 - 0.5

    def place(at: int, seed: int) -> float:
        return (at + (0.0 if at in (0, cells) else 0.5 * random(seed))) / cells

    side = cells + 1
    vertices = [[place(v % side, 7 * v), place(v // side, 13 * v + 3), 0.0] for v in range(side**2)]
    faces = []
    for cell in range(cells**2):
        a = cell // cells * side + cell % cells
        b, c, d = a + 1, a + side + 1, a + side
        faces += [[a, b, c], [a, c, d]] if random(5 * cell) < 0 else [[a, b, d], [b, c, d]]
    return np.array(vertices), np.array(faces)


def mixed() -> Scene:
    """Two grids, a mesh and a net whose pins travel."""
    large = flag([96, 64], "none", "triangle")["cloth"][0]
    large |= {"name": "large", "weights": [{"corner": "top-right", "mass": 0.01}]}
    mesh = {
        "name": "mesh", "mesh": "crooked", "fabric": "nylon", "density": 0.2, "bending": 1e-5,
        "friction_coefficient": 0.01, "translate": [0, 0, 1], "rotate": [80, 10, -30],
        "pins": [{"nearest": [0, 0, 1]}],
    }  # fmt: skip
    side = 66
    points = [[i / (side - 1), 2.0, j / (side - 1)] for j in range(side) for i in range(side)]
    links = [[j * side + i, j * side + i + 1] for j in range(side) for i in range(side - 1)]
    links += [[j * side + i, (j + 1) * side + i] for j in range(side - 1) for i in range(side)]
    pin = {"box": [[-1, 1, 0.999], [2, 3, 1.1]], "move": [[0.02, [0.02, 0, 0.01]]]}
    net = {
        "name": "net", "network": {"points": points, "links": links, "mass": 2e-5}, "stiffness": 2.0,
        "damping": 1e-5, "strain_limit": 0.02, "pins": [pin],
    }  # fmt: skip
    scene = flag([1, 1], "coarse_to_fine", "triangle")
    scene["wind"]["law"] = "drag_lift"
    scene["cloth"] = [large, mesh, net, large | {"name": "small", "grid": {**large["grid"], "cells": [3, 3]}}]
    return Scene(scene, {"crooked": crooked(66)})


def found() -> Iterator[str]:
    """Lines as in the file of goldens."""
    for filter in FILTERS:
        yield _line(f"flag, {filter}", Scene(flag([24, 16], filter, "particle")), 600)
    yield _line("mixed, coarse_to_fine", mixed(), 12)


def _line(name: str, scene: Scene, steps: int) -> str:
    simulation = Simulation(scene, threads=2)
    simulation.step(steps)
    return f"{simulation.state_hash} {name}"


def run(registers: str, *command: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"TAUT_SIMD": registers}
    return subprocess.run([sys.executable, *command], env=environment, capture_output=True, text=True)


@cache
def available() -> set[str]:
    """Kinds of registers that this processor has: those that it does not refuse."""
    script = "from taut import _taut; print(_taut.simd_lanes())"
    return {kind for kind in KINDS.values() if run(kind, "-c", script).returncode == 0}


def test_the_widest_are_used_where_none_are_named() -> None:
    assert "baseline" in available()
    assert KINDS[_taut.simd_lanes()] == [kind for kind in KINDS.values() if kind in available()][-1]


def test_all_give_the_bits_of_the_engine_s_own_tests() -> None:
    results = {}
    for kind in available():
        done = run(kind, __file__)
        assert done.returncode == 0, done.stderr
        lanes, *results[kind] = done.stdout.splitlines()
        assert KINDS[int(lanes)] == kind
    *flags, _ = results["baseline"]  # the tests of the engine number the vertices of meshes otherwise
    assert len(flags) == len(FILTERS) and set(flags) <= set(GOLDENS.read_text().splitlines())
    assert all(lines == results["baseline"] for lines in results.values()), results


def test_what_is_not_there_is_refused_with_those_that_are(tmp_path: Path) -> None:
    command = "-m", "taut", "run", "flag", "--out", str(tmp_path / "flag.zarr")
    wrong = run("sse9", *command)
    told = (
        'TAUT_SIMD = "sse9": must be one of baseline, neon, avx2, avx512; unset it for the widest registers'
    )
    assert wrong.returncode == 2 and " ".join(wrong.stderr.split()) == f"error: {told}"
    for kind in set(KINDS.values()) - available():
        lacking = run(kind, "-m", "taut", "doctor")
        assert lacking.returncode == 2
        assert f'TAUT_SIMD = "{kind}": this processor lacks it; it has baseline' in lacking.stderr


if __name__ == "__main__":
    print(_taut.simd_lanes())
    print("\n".join(found()))
