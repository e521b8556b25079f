"""The tutorial does what it says, in an empty folder."""

import re
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
import trimesh
from PIL import Image
from taut import Cache

from tools.tutorial import follow


def is_a_picture_of_something(path: Path) -> bool:
    """Whether a picture has a few hundred colours, in its middle too."""
    pixels = np.asarray(Image.open(path).convert("RGB"))
    middle = pixels[len(pixels) // 4 : -len(pixels) // 4].reshape(-1, 3)
    return len(np.unique(middle, axis=0)) > 300


@pytest.mark.slow
def test_every_step_of_the_tutorial(tmp_path: Path) -> None:
    printed = follow(tmp_path)
    for still in ("flag.png", "pennant.png", "both.png"):
        assert is_a_picture_of_something(tmp_path / still), still
    frames, _ = imageio_ffmpeg.count_frames_and_secs(tmp_path / "pennant.mp4")
    cache = Cache.open(tmp_path / "pennant.zarr")
    assert frames == cache.frames == 60
    mesh = trimesh.load_mesh(tmp_path / "pennant.obj", process=False)
    assert (len(mesh.vertices), len(mesh.faces)) == (231, 400)
    assert (mesh.face_normals[:, 1] < -0.99).all()  # all faces are turned the same way
    moved = np.linalg.norm(cache.positions(59) - cache.positions(0), axis=1)
    assert (moved[mesh.vertices[:, 0] == 0] == 0).all()  # the pole
    assert moved.max() > 0.1
    assert cache.scene["cloth"][0]["fabric"] == "nylon"
    assert len(list((tmp_path / "frames").glob("*.obj"))) == 60
    worst = [float(word) for word in re.findall(r"worst stretch +([\d.]+)\s?%", printed)]
    assert max(worst) > 5.0  # without the limit
    sags = re.findall(r"limit +(\d+)%: tip at [\d.]+ m, worst stretch ([\d.]+)%", printed)
    assert [limit for limit, _ in sags] == ["10", "5", "1"]
    assert all(float(stretch) <= float(limit) + 0.01 for limit, stretch in sags)
