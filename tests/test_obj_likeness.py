"""A user's own OBJ file comes back round cloth that has moved: faces, texture, normals, groups."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Cache, Scene, Simulation, record
from taut.formats import ExportError, export
from taut.formats.obj_reader import read_obj

# A quad, a pentagon and a triangle; a texture seam and a crease along the edge of vertices 2 and 3.
MESH = """\
# a shirt
mtllib shirt.mtl
o shirt
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
v 2 0 1
v 2.5 0.5 1
v 2 1 1
v 3 0.5 1
vt 0 0
vt 0.5 0
vt 0.5 1
vt 0 1
vt 0.6 0.25
vn 0 0 1
vn 0 0.6 0.8
g front
usemtl red
s 1
f 1/1/1 2/2/1 3/3/1 4/4/1
g back sleeve
usemtl blue
f 2/5/2 5//2 6//2 7/2/-1 3/-1/2
f 5 8 6
"""
KEPT = ("o", "g", "s", "usemtl", "mtllib", "vt")


def lines(text: str, *kinds: str) -> list[str]:
    return [line for line in text.splitlines() if line.split()[0] in kinds]


@pytest.fixture
def shirt(tmp_path: Path) -> Path:
    """A cache of two shirts, one of a file and one of a grid."""
    (tmp_path / "shirt.obj").write_text(MESH)
    shirt = {"name": "shirt", "mesh": "shirt.obj", "pins": [{"vertices": [0]}]}
    grid = {"grid": {"size": [1, 1], "cells": [2, 2], "origin": [0, 0, 3]}}
    scene = Scene({"fps": 60, "duration": 0.05, "cloth": [grid, shirt]}, folder=tmp_path)
    record(Simulation(scene, threads=1), tmp_path / "shirt.zarr")
    return tmp_path / "shirt.zarr"


def test_all_of_a_file_comes_back(shirt: Path, tmp_path: Path) -> None:
    cache = Cache.open(shirt)
    export(cache, "obj", tmp_path / "out", like={"shirt": tmp_path / "shirt.obj"})
    for frame, path in enumerate(sorted((tmp_path / "out").glob("*.obj"))):
        text = path.read_text()
        places = np.array([line.split()[1:] for line in lines(text, "v")], np.float32)
        np.testing.assert_array_equal(places, cache.positions(frame))
        assert lines(text, *KEPT) == [
            *lines(MESH, "vt"),
            *lines(MESH, "mtllib", "o"),
            *lines(MESH, "g", "usemtl", "s"),
        ]
        # Nine vertices of the grid come before; its triangles, too.
        assert lines(text, "f")[8:] == [
            "f 10/1/1 11/2/1 12/3/1 13/4/1",
            "f 11/5/2 14//2 15//2 16/2/2 12/5/2",
            "f 14 17 15",
        ]
        normals = np.array([line.split()[1:] for line in lines(text, "vn")], float)
        own = places[9:].astype(float)
        for normal, face in zip(normals, ([0, 1, 2, 3], [1, 4, 5, 6, 2]), strict=True):
            points = own[face] - own[face].mean(axis=0)
            across = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
            np.testing.assert_allclose(normal, across / np.linalg.norm(across), atol=1e-4)
    mesh = read_obj(path)
    np.testing.assert_array_equal(mesh.counts[8:], [4, 5, 3])


def test_the_command_takes_the_file_of_the_only_mesh(
    taut: Callable[..., Any], shirt: Path, tmp_path: Path
) -> None:
    for name in (f"{tmp_path / 'shirt.obj'}", f"shirt={tmp_path / 'shirt.obj'}"):
        done = taut("export", shirt, "--to", "obj", "--out", tmp_path / "out", "--like", name, "--overwrite")
        assert done.status == 0
        assert "usemtl blue" in (tmp_path / "out" / "frame_0000.obj").read_text()
    for name, words in (("coat=a.obj", "no such cloth"), ("shirt=gone.obj", "gone.obj")):
        done = taut("export", shirt, "--to", "obj", "--out", tmp_path / "new", "--like", name)
        assert (done.status, words in done.err) == (2, True), done.err


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (MESH.replace("v 3 0.5 1\n", "").replace("f 5 8 6\n", ""), "has 7 vertices, the cloth 8"),
        (MESH.replace("2/5/2", "2/6/2"), "a face names texture coordinate 6 of 5"),
        (MESH.replace("5//2", "5//3"), "a face names normal 3 of 2"),
        (MESH.replace("5//2", "5//x"), "a face has 'x' where a number from 1 is allowed"),
        (MESH.replace("5//2", "5//-3"), "a face has '-3'"),
        (MESH.replace("5//2", "5//0"), "a face has '0'"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(shirt: Path, tmp_path: Path, mesh: str, words: str) -> None:
    (tmp_path / "other.obj").write_text(mesh)
    with pytest.raises(ExportError, match=words):
        export(Cache.open(shirt), "obj", tmp_path / "out", like={"shirt": tmp_path / "other.obj"})
    assert not (tmp_path / "out").exists()
    with pytest.raises(ExportError, match="pc2 has no place"):
        export(Cache.open(shirt), "pc2", tmp_path / "a.pc2", like={"shirt": "a.obj"})
