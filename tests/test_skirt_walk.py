"""The shipped scene `skirt-walk` is what its script makes, and the figure walks as people do."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from taut.formats import read_mesh
from taut.scene import find_scene

from tools.make_skirt_walk import ANKLE, SHIN, THIGH, leg, walked

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("skirt")
    subprocess.run([sys.executable, ROOT / "tools" / "make_skirt_walk.py", "--out", out], check=True)
    return out


def test_the_shipped_scene_and_mesh_are_those_that_the_script_makes(made: Path) -> None:
    shipped = find_scene("skirt-walk")
    assert (made / "skirt-walk.toml").read_text() == shipped.read_text()
    mesh, kept = (read_mesh(folder / "meshes" / "skirt.obj") for folder in (made, shipped.parent))
    np.testing.assert_allclose(mesh.vertices, kept.vertices, atol=2e-5)
    np.testing.assert_array_equal(mesh.corners, kept.corners)


def test_the_skirt_is_a_tube_without_flaws(made: Path) -> None:
    mesh = read_mesh(made / "meshes" / "skirt.obj")
    faces = mesh.corners.reshape(-1, 3)
    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert len(np.unique(halves, axis=0)) == len(halves)  # one side of an edge belongs to one face
    edges, uses = np.unique(np.sort(halves, axis=1), axis=0, return_counts=True)
    assert uses.max() == 2 and len(mesh.vertices) - len(edges) + len(faces) == 0  # round, with two borders
    a, b, c = mesh.vertices[faces].transpose(1, 0, 2)
    outwards = np.einsum("nc,nc->n", np.cross(b - a, c - a)[:, :2], (a + b + c)[:, :2])
    assert (outwards > 0).all()
    length = np.linalg.norm(np.subtract(*mesh.vertices[edges.T]), axis=1)
    assert length.min() > 0.015 and length.max() < 0.035


def test_feet_stand_still_while_they_bear() -> None:
    time = np.linspace(0.0, 4.5, 901)
    way = walked(time)
    assert abs(way[0]) < 1e-12 and (np.diff(way) > -1e-12).all()
    ahead, above = [], []
    for side in (-1, 1):
        thigh, shin, knee = leg(way, side)
        ahead.append(knee[:, 0] + SHIN * np.sin(np.radians(shin)))
        above.append(knee[:, 1] - SHIN * np.cos(np.radians(shin)))
        hip = knee - THIGH * np.stack([np.sin(np.radians(thigh)), -np.cos(np.radians(thigh))], axis=1)
        np.testing.assert_allclose(hip[:, 0], way, atol=1e-9)
        assert np.ptp(hip[:, 1]) < 1e-9  # an even height
    speed = np.abs(np.diff(ahead, axis=1)).min(axis=0) / (time[1] - time[0])
    assert np.quantile(speed, 0.98) < 1e-6  # one of them stands; both move in the moment in which they change
    assert np.min(above) > ANKLE - 1e-9
    np.testing.assert_allclose([one[-1] for one in ahead], way[-1], atol=1e-9)
