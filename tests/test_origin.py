"""Cloth far from the origin: what Python sees of it, and that a cache has all its bits."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Cache, Scene, SceneError, Simulation, record
from taut.formats import export

FAR = [99_000.1, -20_000.7, 0.0]
"""Where the cloth is put [m]; its grid begins 1 m above that."""


def carried(flag: dict[str, Any], way: float) -> dict[str, Any]:
    """The small flag far away, its pole travelling along x; a second cloth stays near the origin."""
    (cloth,) = flag["cloth"]
    moving = cloth | {"translate": FAR, "pins": [{"edge": "left", "move": [[0.5, [way, 0, 0]]]}]}
    return flag | {"cloth": [moving, cloth | {"name": "near"}]}


def test_positions_are_places_in_the_world(flag: dict[str, Any]) -> None:
    near, far = Simulation(Scene(flag)), Simulation(Scene(carried(flag, 0.0)))
    own = slice(0, len(near.positions))
    assert far.origins.tolist() == [[FAR[0], FAR[1], 1.0], [0, 0, 0]]
    near.step(40)
    far.step(40)
    np.testing.assert_array_equal(near.local_positions, near.positions)
    np.testing.assert_array_equal(far.local_positions[len(near.positions) :], near.positions)
    np.testing.assert_allclose(
        far.exact_positions[own] - far.origins[0], far.local_positions[own], atol=1e-10
    )
    np.testing.assert_array_equal(far.positions, far.exact_positions.astype(np.float32))
    exact = far.exact_positions
    far.set_state(exact, far.velocities, far.steps)
    np.testing.assert_allclose(far.exact_positions, exact, atol=1e-7)
    local, origins, before = far.local_positions, far.origins, far.state_hash
    far.set_state(local, far.velocities, far.steps, origins=origins)
    assert far.state_hash == before
    snapshot = far.snapshot()
    far.step(5)
    far.restore(snapshot)
    assert far.state_hash == before
    with pytest.raises(ValueError, match=r"origins must be a float64 array of shape \(2, 3\)"):
        far.set_state(local, far.velocities, far.steps, origins=origins[:1])


@pytest.mark.parametrize("integrator", ["euler", "bdf2"])
def test_a_run_that_travels_goes_on_with_its_bits(
    flag: dict[str, Any], tmp_path: Path, integrator: str
) -> None:
    scene = Scene(carried(flag, 20.0)).with_settings([f"solver.integrator={integrator}"])
    record(Simulation(scene), tmp_path / "whole.zarr")
    for frames in (7, 16, None):
        record(Simulation(scene), tmp_path / "parts.zarr", frames, existing="resume")
    whole, parts = Cache.open(tmp_path / "whole.zarr"), Cache.open(tmp_path / "parts.zarr")
    np.testing.assert_array_equal(whole.diagnostics["state_hash"], parts.diagnostics["state_hash"])
    assert whole.origins(-1)[0, 0] > whole.origins(0)[0, 0] == FAR[0]
    assert all(whole.is_whole(frame) for frame in range(whole.frames))
    exact = whole.exact_positions(-1)
    np.testing.assert_array_equal(exact.astype(np.float32), whole.positions(-1))
    worst = whole.diagnostics["worst_stretch"][-1]
    assert whole.stretch(-1).max() == pytest.approx(worst, abs=1e-5)
    # A frame whose local positions are lost is not whole.
    (tmp_path / "whole.zarr/local_positions" / f"c.{whole.frames - 1}.0.0").unlink()
    again = Cache.open(tmp_path / "whole.zarr")
    assert not again.is_whole(-1) and again.is_whole(-2)


def test_near_the_origin_nothing_more_is_stored(recorded: Path) -> None:
    cache = Cache.open(recorded)
    assert not cache.origins(-1).any()
    np.testing.assert_array_equal(cache.local_positions(-1), cache.positions(-1))
    assert [path.name for path in (recorded / "local_positions").iterdir()] == ["zarr.json"]
    assert json.loads((recorded / "local_positions/zarr.json").read_text())["shape"][0] == cache.frames


def test_meshes_that_are_too_far_away_are_refused() -> None:
    vertices = np.array([[0, 0, 0], [1e6, 0, 0], [0, 1e6, 0]])
    document = {"cloth": [{"mesh": "m", "fabric": "cotton"}]}
    with pytest.raises(
        SceneError, match=r"cloth\[0\]\.mesh.* vertex 1 is at .*; is the mesh in millimetres\?"
    ):
        Simulation(Scene(document, meshes={"m": (vertices, [[0, 1, 2]])}))


def test_meshes_and_nets_far_away_move_and_are_written_as_near_the_origin(tmp_path: Path) -> None:
    vertices = np.array([[x / 8, y / 8, 0.001 * ((3 * x + y) % 4)] for y in range(9) for x in range(9)])
    quads = [9 * y + x for y in range(8) for x in range(8)]
    faces = np.array([[a + step for step in steps] for a in quads for steps in ((0, 1, 10), (0, 10, 9))])
    points = [[0.05 * bead, 2.0, 0.0] for bead in range(11)]
    net = {"points": points, "links": [[bead, bead + 1] for bead in range(10)], "mass": 0.01}
    shapes: list[dict[str, Any]] = [
        {"name": "mesh", "mesh": "sheet", "pins": [{"vertices": [0]}]},
        {"name": "net", "network": net, "pins": [{"vertices": [0]}]},
    ]
    way = np.array([1e5, -1e5, 1e5])
    written = {}
    for name, off in (("near", np.zeros(3)), ("far", way)):
        cloth = [shape | {"strain_limit": 0.02, "translate": off.tolist()} for shape in shapes]
        scene = Scene({"duration": 0.5, "cloth": cloth}, {"sheet": (vertices, faces)})
        record(Simulation(scene), tmp_path / f"{name}.zarr")
        cache = Cache.open(tmp_path / f"{name}.zarr")
        for kind in ("obj", "ply"):
            export(cache, kind, tmp_path / f"{name}.{kind}.frames")
        obj = max((tmp_path / f"{name}.obj.frames").iterdir()).read_text().splitlines()
        ply = max((tmp_path / f"{name}.ply.frames").iterdir()).read_bytes()
        real = "<f4" if name == "near" else "<f8"
        assert (b"property double x" in ply) == (name == "far")
        row = np.dtype([("x", real, 3), ("stretch", "<f4")])
        table = np.frombuffer(ply.split(b"end_header\n", 1)[1], row, len(vertices) + len(points))
        read = np.array([[float(part) for part in line.split()[1:]] for line in obj if line.startswith("v ")])
        written[name] = [cache.exact_positions(-1) - off, read - off, table["x"] - off]
    for near, far in zip(written["near"], written["far"], strict=True):
        np.testing.assert_allclose(far, near, atol=1e-6)
    assert np.ptp(written["far"][0][:81, 2]) > 0.2, "it moves"
