"""Every shipped scene runs, and the frames it writes say what the reports say: checked by NumPy alone."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import zarr
from taut import Scene, Simulation, _taut, record
from taut.formats import read_mesh, read_pc2
from taut.scene import find_scene, shipped_scenes

ROOT = Path(__file__).resolve().parent.parent
SCENES = shipped_scenes()
TAUT = Path(sys.executable).with_name("taut")
ROUNDING = 1e-5
"""How far rounding to single precision may seem to lead over a limit [1]."""


def taut(*arguments: str | Path) -> None:
    subprocess.run([TAUT, *arguments], check=True, capture_output=True, cwd=ROOT)


def stretches(cache: Path) -> np.ndarray:
    """Largest |X_uv| / L - 1 of each frame."""
    group = zarr.open_group(cache, mode="r")
    u, v = group["springs"][:].T
    rest = group["rest_length"][:].astype(np.float64)
    frames = group["positions"][:]
    ends = ((x[v].astype(np.float64), x[u].astype(np.float64)) for x in frames)
    return np.array([(np.linalg.norm(one - other, axis=1) / rest).max() - 1 for one, other in ends])


@pytest.fixture(scope="module", params=SCENES, ids=lambda scene: scene.name)
def cache(request, tmp_path_factory):
    """The first 150 frames of each shipped scene; not to be changed."""
    folder = tmp_path_factory.mktemp("shipped")
    record(Simulation(Scene.load(request.param.name)), folder / "cache.zarr", 150)
    yield folder / "cache.zarr"
    shutil.rmtree(folder)


@pytest.mark.slow
def test_no_spring_of_a_shipped_scene_is_over_its_limit(cache):
    group = zarr.open_group(cache, mode="r")
    u, v = group["springs"][:].T
    longest = group["rest_length"][:].astype(np.float64) * (1 + group["strain_limit"][:].astype(np.float64))
    for frame, x in enumerate(group["positions"][:]):
        x = x.astype(np.float64)
        assert (np.linalg.norm(x[v] - x[u], axis=1) / longest).max() <= 1 + ROUNDING, frame
    assert frame == 149
    between = group["diagnostics/worst_stretch_in_steps"][:].max()
    assert between <= group["strain_limit"][:].max() + ROUNDING


@pytest.mark.slow
def test_scene_runs_and_reports_what_its_frames_hold(cache):
    group = zarr.open_group(cache, mode="r")
    assert group["positions"].shape[0] == 150
    assert np.isfinite(group["positions"][:]).all()
    np.testing.assert_allclose(stretches(cache), group["diagnostics/worst_stretch"][:], atol=1e-5)
    np.testing.assert_allclose(group["time"][:], np.arange(150) / 60, rtol=1e-12)


def test_scenes_cover_the_papers_experiments():
    names = {scene.name for scene in SCENES}
    assert {"flag", "flag-light", "flag-strong", "flag-across", "one-corner", "two-corners"} <= names
    assert {"curtain", "cape", "net"} <= names


def test_the_unconstrained_drop_over_stretches_and_the_constrained_one_does_not(tmp_path):
    worst = {}
    for method in ("none", "sweeps", "coarse_to_fine"):
        cache = tmp_path / f"{method}.zarr"
        settings = ("--set", f"solver.filter={method}")
        taut("run", "one-corner", "--out", cache, "--frames", "60", "--quiet", *settings)
        worst[method] = stretches(cache).max()
    assert worst["none"] > 3.0  # [1], super-elasticity: over 300 %
    assert worst["sweeps"] < 0.12  # [1], the limit is 10 %; plain sweeps come near it, not below
    assert worst["coarse_to_fine"] <= 0.1 + ROUNDING


def test_moving_pins_follow_their_keyframes(tmp_path):
    cache = tmp_path / "curtain.zarr"
    taut(
        "run",
        "curtain",
        "--out",
        cache,
        "--frames",
        "100",
        "--quiet",
        "--set",
        "solver.iterations=20",
    )
    group = zarr.open_group(cache, mode="r")
    last = group["positions"][99][group["pins"][:]]
    way = 0.8 * (99 / 60 - 0.5) / 2.0  # the last ring: [0.5 s, 0] to [2.5 s, -0.8 m]
    assert np.abs(last[:, 0] - (1.6 - way)).min() < 1e-5


def test_a_users_mesh_comes_back_in_its_own_vertex_order(tmp_path):
    mesh = find_scene("cape").parent / "meshes" / "cape.obj"
    (tmp_path / "mine.obj").write_bytes(mesh.read_bytes())
    pins = "{ nearest = [-0.035, -0.083, 1.45] }, { nearest = [0.0, 0.09, 1.45] }"
    scene = tmp_path / "mine.toml"
    scene.write_text(f'[[cloth]]\nmesh = "mine.obj"\npins = [{pins}]\n')
    cache = tmp_path / "mine.zarr"
    taut("run", scene, "--out", cache, "--frames", "10", "--quiet")
    taut("export", cache, "--to", "pc2", "--out", tmp_path / "mine.pc2")
    taut("export", cache, "--to", "obj", "--out", tmp_path / "frames")
    original = read_mesh(mesh)
    assert len(original.vertices) > 2000
    _, _, frames = read_pc2(tmp_path / "mine.pc2")
    np.testing.assert_allclose(frames[0], original.vertices, atol=1e-6)
    first, last = (read_mesh(tmp_path / "frames" / f"frame_{frame:04d}.obj") for frame in (0, 9))
    np.testing.assert_allclose(first.vertices, original.vertices, atol=1e-6)
    np.testing.assert_array_equal(first.corners, original.corners)
    np.testing.assert_array_equal(last.vertices.astype(np.float32), frames[9])
    assert (np.abs(frames[9] - frames[0]).max(axis=1) == 0).sum() == 2  # the pins alone have not moved


def test_the_schema_in_the_documents_is_the_engines():
    assert (ROOT / "docs" / "scene.schema.json").read_text().strip() == _taut.scene_schema().strip()
