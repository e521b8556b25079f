"""What scenes take: said beforehand, and refused where it is not there."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Scene, SceneError, Simulation, record

CLOSE = 0.3
"""An estimate is right to this part [1]."""

MEASURE = """
import ctypes, json, sys
import numpy as np
from taut import Scene, Simulation
def peak():
    with open("/proc/self/status") as status:
        return 1024 * next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
document = json.load(sys.stdin)
meshes = {name: (np.array(mesh[0]), np.array(mesh[1])) for name, mesh in document.pop("meshes").items()}
scene = Scene(document, meshes)
Simulation(Scene({"cloth": [{"grid": {"cells": [4, 4]}}]}), threads=2).step()
ctypes.CDLL(None).malloc_trim(0)  # What reading the scene has left free must not serve the simulation unseen.
with open("/proc/self/clear_refs", "w") as reset:
    reset.write("5")
before = peak()
simulation = Simulation(scene, threads=2)
simulation.step()
print(json.dumps([scene.needs().memory, peak() - before]))
"""

LIMITED = """
import resource, sys
from taut import Scene, SceneError, Simulation
Simulation(Scene({"cloth": [{"grid": {"cells": [4, 4]}}]}), threads=1).step()
with open("/proc/self/statm") as status:
    own = int(status.read().split()[0]) * resource.getpagesize()
room = own + int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_AS, (room, room))
try:
    Simulation(Scene({"cloth": [{"grid": {"cells": [int(sys.argv[2])] * 2}}]}), threads=1).step()
except SceneError as error:
    print("refused:", error)
else:
    print("simulated")
"""

linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is measured on Linux only")


def mesh(side: int) -> tuple[Any, Any]:
    """A crooked sheet of triangles with so many edges along each side."""
    y, x = np.mgrid[: side + 1, : side + 1].astype(float)
    shift = np.random.default_rng(0).uniform(-0.2, 0.2, (2, *x.shape))
    vertices = np.stack([x + shift[0], y + shift[1], 0.2 * np.sin(1.7 * x + y)], -1).reshape(-1, 3) / side
    index = np.arange((side + 1) ** 2).reshape(side + 1, side + 1)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = [np.stack(corners, -1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))]
    return vertices, np.concatenate(faces)


def net(side: int) -> dict[str, Any]:
    """A net with so many meshes along each side."""
    y, x = np.mgrid[: side + 1, : side + 1]
    points = np.stack([x / side, y / side, 0 * x], -1).reshape(-1, 3)
    index = np.arange((side + 1) ** 2).reshape(side + 1, side + 1)
    links = [np.stack([index[:, :-1], index[:, 1:]], -1), np.stack([index[:-1], index[1:]], -1)]
    return {
        "network": {
            "points": points.tolist(),
            "links": np.concatenate([link.reshape(-1, 2) for link in links]).tolist(),
            "mass": 1e-4,
        },
        "stiffness": 1.0,
    }


def python(code: str, *arguments: str, text: str = "") -> str:
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], input=text, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@linux
@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "cloth", "solver"),
    [
        ("grid", {}, {}),
        ("grid", {"pins": [{"box": [[-1, -1, -1], [0.02, 2, 2]]}]}, {}),
        ("grid", {"bending": "fabric"}, {}),
        ("grid", {"flexion_stiffness": 0.01}, {}),
        ("grid", {"bending": "fabric", "bending_model": "choi_ko"}, {}),
        ("grid", {"thickness": 0.0005}, {}),
        ("mesh", {"thickness": 0.0005}, {}),
        ("network", {"thickness": 0.0005}, {}),
        ("grid", {}, {"filter": "none"}),
        ("grid", {}, {"filter": "xpbd"}),
        ("grid", {}, {"filter": "fast_projection"}),
        ("grid", {}, {"integrator": "bdf2"}),
        ("mesh", {}, {}),
        ("mesh", {"bending": "fabric"}, {}),
        ("mesh", {}, {"filter": "sweeps"}),
        ("mesh", {}, {"integrator": "implicit_euler"}),
        ("network", {}, {}),
        ("network", {"bending": 1e-9}, {}),
        ("network", {}, {"filter": "none"}),
    ],
)
def test_the_memory_that_is_said_is_what_processes_take(
    kind: str, cloth: dict[str, Any], solver: dict[str, Any]
) -> None:
    shape: dict[str, Any] = {"grid": {"cells": [250, 250]}}
    meshes: dict[str, Any] = {}
    if kind == "mesh":
        shape = {"mesh": "sheet"}
        vertices, faces = mesh(150)
        meshes["sheet"] = vertices.tolist(), faces.tolist()
    elif kind == "network":
        shape = net(150)
    document = {"cloth": [shape | cloth | {"strain_limit": 0.05}], "solver": solver, "meshes": meshes}
    said, taken = json.loads(python(MEASURE, text=json.dumps(document)))
    assert abs(said / taken - 1) < CLOSE, f"{said / 1e6:.0f} MB said, {taken / 1e6:.0f} MB taken"


@pytest.mark.parametrize("place", [[0.0, 0.0, 0.0], [5000.0, 0.0, 0.0]])
def test_the_disk_that_is_said_is_what_a_run_writes(place: list[float], tmp_path: Path) -> None:
    cloth = {"grid": {"cells": [80, 60]}, "translate": place, "pins": [{"edge": "left"}], "fabric": "nylon"}
    scene = Scene({"duration": 0.5, "wind": {"velocity": [6.0, 1.0, 0.0], "gust": {}}, "cloth": [cloth]})
    record(Simulation(scene), tmp_path / "run.zarr")
    taken = sum(file.stat().st_size for file in (tmp_path / "run.zarr").rglob("*") if file.is_file())
    said = scene.needs().disk
    assert abs(said / taken - 1) < CLOSE, f"{said / 1e6:.1f} MB said, {taken / 1e6:.1f} MB taken"


@linux
@pytest.mark.parametrize(("room", "cells"), [(2_000_000_000, 3999), (300_000_000, 999), (60_000_000, 500)])
def test_memory_that_is_not_there_is_an_error(room: int, cells: int) -> None:
    said = python(LIMITED, str(room), str(cells))
    assert said.startswith(
        f"refused: scene.cloth[0].grid.cells = [{cells}, {cells}]: the scene needs about "
    ), said
    assert "GB of memory" in said and said.count("\n") == 1


@linux
def test_memory_that_is_there_is_used() -> None:
    # Where this much is enough, what is a little too much must be refused before the system does.
    for cells in (100, 200, 300, 330, 360, 400, 450):
        assert python(LIMITED, "150000000", str(cells)).split(":")[0].strip() in ("simulated", "refused")
    assert python(LIMITED, "150000000", "300") == "simulated\n"


def test_many_grids_together_are_bounded() -> None:
    cloth = {"grid": {"cells": [2999, 2999]}}
    with pytest.raises(SceneError, match=r"cloth\[1\]\.grid\.cells = .* in all grids together, not 18000000"):
        Scene({"cloth": [cloth, cloth]})


def test_a_dry_run_says_what_a_scene_needs(taut: Callable[..., Any], flag_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "flag.zarr"
    told = taut("run", flag_file, "--out", out, "--dry-run", "--set", "cloth[0].grid.cells=[999, 999]")
    assert told.status == 0
    table = dict(line.split(maxsplit=1) for line in told.out.splitlines())
    assert (table["frames"].strip(), table["vertices"].strip()) == ("30", "1000000")
    assert table["memory"].startswith("about 6") and table["disk"].startswith("about 9")
    assert not out.exists()
