"""Frames out: nothing re-ordered, nothing half-written."""

import errno
import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from in_memory import chain, grid, moved
from taut.formats import EXPORTERS, ExportError, MeshError, export, read_mesh, read_pc2
from taut.scene import find_scene


def waving(frames: int = 3):
    still = grid(5, 4)
    points = still.motion[0]
    return moved(still, [points + 0.1 * np.sin(i + 3 * points[:, [0]]) for i in range(frames)])


def test_pc2_bytes(tmp_path):
    frames = waving()
    export(frames, "pc2", tmp_path / "flag.pc2")
    expected = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, 20, 0.0, 1.0, 3)
    for positions in frames.motion:
        for x, y, z in positions.tolist():
            expected += struct.pack("<fff", x, y, z)
    assert (tmp_path / "flag.pc2").read_bytes() == expected
    start, sampling, positions = read_pc2(tmp_path / "flag.pc2")
    assert (start, sampling) == (0.0, 1.0) and np.array_equal(positions, frames.motion)


@pytest.mark.parametrize(
    "change", [lambda b: b[:-1], lambda b: b + b"\0", lambda b: b[:20], lambda b: b"X" + b[1:], lambda b: b""]
)
def test_damaged_pc2(tmp_path, change):
    export(waving(), "pc2", tmp_path / "flag.pc2")
    (tmp_path / "bad.pc2").write_bytes(change((tmp_path / "flag.pc2").read_bytes()))
    with pytest.raises(MeshError, match="bad.pc2"):
        read_pc2(tmp_path / "bad.pc2")


@pytest.mark.parametrize("to", ["obj", "ply"])
def test_folders_of_frames_keep_bits_and_order(tmp_path, to):
    frames = waving()
    export(frames, to, tmp_path / "out" / "flag")
    names = sorted(path.name for path in (tmp_path / "out" / "flag").iterdir())
    assert names == [f"frame_000{i}.{to}" for i in range(3)]
    for frame, name in enumerate(names):
        mesh = read_mesh(tmp_path / "out" / "flag" / name)
        assert np.array_equal(mesh.vertices.astype(np.float32), frames.motion[frame])
        assert np.array_equal(mesh.corners.reshape(-1, 3), frames.faces)
    assert sorted(path.name for path in tmp_path.rglob("*")) == sorted(["out", "flag", *names])


@settings(max_examples=100, deadline=None)
@given(numbers=st.lists(st.floats(allow_nan=False, allow_infinity=False, width=32), min_size=60, max_size=60))
def test_every_float32_survives_obj_and_pc2(tmp_path_factory, numbers):
    frames = moved(grid(5, 4), [np.array(numbers, np.float32).reshape(20, 3)])
    folder = tmp_path_factory.mktemp("export")
    for to in ("obj", "pc2"):
        export(frames, to, folder / to)
    back = read_mesh(folder / "obj" / "frame_0000.obj").vertices.astype(np.float32)
    assert back.tobytes() == frames.motion[0].tobytes()
    assert read_pc2(folder / "pc2")[2].tobytes() == frames.motion.tobytes()


def test_ply_holds_the_stretch_of_each_vertex(tmp_path):
    still = grid(3, 2, width=2)
    pulled = still.motion[0].copy()
    pulled[[2, 5], 0] += 0.5
    export(moved(still, [pulled]), "ply", tmp_path / "ply")
    data = (tmp_path / "ply" / "frame_0000.ply").read_bytes()
    head, _, body = data.partition(b"end_header\n")
    assert b"property float stretch" in head
    vertices = np.frombuffer(body, "<f4", 6 * 4).reshape(6, 4)
    assert np.allclose(vertices[:, 3], [0, 0.5, 0.5, 0, 0.5, 0.5], atol=1e-6)


def test_chains_become_lines(tmp_path):
    frames = chain(3)
    export(frames, "obj", tmp_path / "obj")
    text = (tmp_path / "obj" / "frame_0000.obj").read_text()
    assert [line for line in text.splitlines() if line[0] in "fl"] == ["l 1 2", "l 2 3", "l 3 4"]
    export(frames, "ply", tmp_path / "ply")
    body = (tmp_path / "ply" / "frame_0000.ply").read_bytes().partition(b"end_header\n")[2]
    assert np.frombuffer(body, "<i4", 6, 4 * 16).tolist() == [0, 1, 1, 2, 2, 3]


@pytest.mark.parametrize("to", EXPORTERS)
def test_existing_output(tmp_path, to):
    out = tmp_path / "out"
    export(waving(2), to, out)
    with pytest.raises(ExportError, match="exists already"):
        export(waving(3), to, out)
    export(waving(3), to, out, overwrite=True)
    if to == "pc2":
        assert len(read_pc2(out)[2]) == 3
    else:
        assert len(list(out.iterdir())) == 3
    assert list(tmp_path.iterdir()) == [out]


@pytest.mark.parametrize("to", ["obj", "ply"])
def test_a_folder_with_foreign_files_is_never_replaced(tmp_path, to):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "wedding.jpg").write_text("precious")
    with pytest.raises(ExportError, match="'wedding.jpg', which no export wrote"):
        export(waving(), to, tmp_path / "photos", overwrite=True)
    assert (tmp_path / "photos" / "wedding.jpg").read_text() == "precious"
    (tmp_path / "file").write_text("precious")
    with pytest.raises(ExportError, match="is a file"):
        export(waving(), to, tmp_path / "file", overwrite=True)


@pytest.mark.parametrize("to", EXPORTERS)
@pytest.mark.parametrize("call", ["fsync", "rename"])
def test_full_disk_leaves_nothing(tmp_path, monkeypatch, to, call):
    def fail(*_args: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, {"fsync": "fsync", "rename": "replace" if to == "pc2" else "rename"}[call], fail)
    with pytest.raises(ExportError, match=r"out cannot be written: No space left on device; free some space"):
        export(waving(), to, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("to", EXPORTERS)
def test_a_failed_overwrite_keeps_what_was_there(tmp_path, to):
    out = tmp_path / "out"
    export(waving(2), to, out)
    before = {path: path.read_bytes() for path in [out, *out.rglob("*")] if path.is_file()}
    broken = waving(3)
    broken.motion[2, 7, 1] = np.nan
    with pytest.raises(ExportError, match="frame 2: vertex 7"):
        export(broken, to, out, overwrite=True)
    assert {path: path.read_bytes() for path in [out, *out.rglob("*")] if path.is_file()} == before
    assert list(tmp_path.iterdir()) == [out]


@pytest.mark.parametrize("to", EXPORTERS)
def test_refusals_and_progress(tmp_path, to):
    with pytest.raises(ExportError, match="has no frames"):
        export(moved(grid(3, 3), [np.zeros((9, 3))][:0]), to, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []
    calls = []
    export(waving(3), to, tmp_path / "out", progress=lambda done, total: calls.append((done, total)))
    assert calls == [(1, 3), (2, 3), (3, 3)]


def test_unknown_format(tmp_path):
    with pytest.raises(ExportError, match="cannot export to 'abc': the formats are obj, pc2, ply"):
        export(waving(), "abc", tmp_path / "out")


# ---- the mesh that the scenes use


@pytest.fixture(scope="module")
def cape(tmp_path_factory):
    script = Path(__file__).parents[1] / "tools" / "make_cape.py"
    out = tmp_path_factory.mktemp("cape") / "cape.obj"
    subprocess.run([sys.executable, str(script), "--out", str(out)], check=True)
    return read_mesh(out)


def test_the_cape_is_one_open_irregular_sheet(cape):
    faces = cape.corners.reshape(-1, 3)
    assert 2500 <= len(cape.vertices) <= 4000 and len(np.unique(faces)) == len(cape.vertices)
    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert len(np.unique(halves, axis=0)) == len(halves)  # one side of an edge belongs to one face
    edges, uses = np.unique(np.sort(halves, axis=1), axis=0, return_counts=True)
    assert len(cape.vertices) - len(edges) + len(faces) == 1  # a disc
    valence = np.bincount(edges[np.isin(np.arange(len(edges)), np.flatnonzero(uses == 2))].ravel())
    assert (valence == 6).mean() < 0.6
    length = np.linalg.norm(np.subtract(*cape.vertices[edges.T]), axis=1)
    assert length.min() > 0.012 and length.max() < 0.05


def test_the_shipped_cape_is_the_one_that_its_script_makes(cape):
    shipped = read_mesh(find_scene("cape").parent / "meshes" / "cape.obj")
    np.testing.assert_allclose(cape.vertices, shipped.vertices, atol=2e-6)
    np.testing.assert_array_equal(cape.corners, shipped.corners)


def test_the_cape_has_the_neckline_that_its_script_promises(cape):
    low, high = [-0.12, -0.12, 1.445], [0.12, 0.12, 1.46]
    neck = ((cape.vertices >= low) & (cape.vertices <= high)).all(axis=1)
    assert neck.sum() > 20 and cape.vertices[~neck, 2].max() < 1.44
    assert np.allclose(np.hypot(*cape.vertices[neck, :2].T), 0.09, atol=1e-3)
    for clasp in ([-0.035, -0.083, 1.45], [0.035, -0.083, 1.45], [0.0, 0.09, 1.45]):
        nearest = np.linalg.norm(cape.vertices - clasp, axis=1).argmin()
        assert neck[nearest]
