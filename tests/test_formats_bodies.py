"""Bodies in exports: files of their own beside the cloth's, whose files stay as they are."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Cache, Scene, Simulation, record
from taut.formats import export, read_mesh

BODIES: list[dict[str, Any]] = [
    {"name": "a  ball", "sphere": {"center": [0, 5, 0], "radius": 0.5}},
    {"name": "crate", "box": {"center": [0, -5, 0], "size": [1, 2, 1]}},
    {"name": "wall", "plane": {"normal": [0, -1, 0], "point": [0, 8, 0]}},
]


def exported(flag: dict[str, Any], folder: Path, to: str, **move: Any) -> tuple[Cache, Path]:
    """The flag beside bodies, three frames of it in another format."""
    flag["body"] = [BODIES[0] | move, *BODIES[1:]]
    record(Simulation(Scene(flag), threads=1), folder / "flag.zarr", 3)
    cache = Cache.open(folder / "flag.zarr")
    export(cache, to, folder / "out")
    return cache, folder / "out"


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_bodies_that_stay_are_one_file(flag: dict[str, Any], tmp_path: Path) -> None:
    cache, out = exported(flag, tmp_path, "obj")
    assert names(out) == ["bodies.obj", *(f"frame_000{frame}.obj" for frame in range(3))]
    text = (out / "bodies.obj").read_text().splitlines()
    assert [line for line in text if line.startswith("o ")] == ["o a ball", "o crate", "o wall"]
    mesh = read_mesh(out / "bodies.obj")
    own = mesh.vertices[-12:-4].astype(np.float32)
    np.testing.assert_array_equal(own, cache.bodies(0)["crate"].positions)
    ball = mesh.vertices[:-12]
    np.testing.assert_allclose(np.linalg.norm(ball - [0, 5, 0], axis=1), 0.5, atol=1e-6)
    assert mesh.counts[-1] == 4 and (mesh.vertices[-4:, 1] == 8).all()
    # The files of the cloth hold the cloth alone.
    assert len(read_mesh(out / "frame_0002.obj").vertices) == cache.vertices
    export(cache, "obj", out, overwrite=True)


def test_bodies_that_move_are_a_file_a_frame(flag: dict[str, Any], tmp_path: Path) -> None:
    cache, out = exported(flag, tmp_path, "obj", move=[[0.05, [0, 0, 1]]])
    assert names(out) == [f"{kind}_000{frame}.obj" for kind in ("bodies", "frame") for frame in range(3)]
    for frame in range(3):
        ball = read_mesh(out / f"bodies_000{frame}.obj").vertices[:-12]
        middle = (ball.min(axis=0) + ball.max(axis=0)) / 2
        np.testing.assert_allclose(middle, cache.bodies(frame)["a  ball"].positions[0], atol=1e-6)


@pytest.mark.parametrize("to", ["ply", "pc2"])
def test_other_formats_leave_bodies_out(flag: dict[str, Any], tmp_path: Path, to: str) -> None:
    _, out = exported(flag, tmp_path, to)
    assert out.is_file() or names(out) == [f"frame_000{frame}.ply" for frame in range(3)]
