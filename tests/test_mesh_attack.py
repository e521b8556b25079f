"""Damaged mesh files of every format: each is a mesh, or refused in taut's own words."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from taut.formats import MeshError, read_mesh
from taut.formats.gltf_document import Document
from taut.formats.triangles import cut

from tests.attack.leaks import leak
from tests.attack.meshes import FORMATS, glb, gltf_tree, judge, mutants, prefixes, valid

MUTANTS = 400
"""Of each format [1]; a longer attack has more."""


def written(folder: Path, content: bytes, extension: str) -> Path:
    path = folder / f"mesh.{extension}"
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("extension", FORMATS)
def test_whole_files_are_read(tmp_path: Path, extension: str) -> None:
    for content in valid(extension):
        assert judge(written(tmp_path, content, extension)) is None


@pytest.mark.slow
@pytest.mark.parametrize("extension", FORMATS)
def test_files_that_are_cut_at_any_byte(tmp_path: Path, extension: str) -> None:
    for content in prefixes(extension):
        judge(written(tmp_path, content, extension))


@pytest.mark.parametrize("extension", FORMATS)
def test_mutants_are_meshes_or_refused_in_our_own_words(tmp_path: Path, extension: str) -> None:
    said = [judge(written(tmp_path, content, extension)) for content in mutants(extension, 18, MUTANTS)]
    assert 0.02 * MUTANTS < said.count(None) < 0.8 * MUTANTS, (
        "mutants must be neither all whole nor all broken"
    )
    assert [*mutants(extension, 7, 3)] == [*mutants(extension, 7, 3)] != [*mutants(extension, 8, 3)]


@pytest.mark.parametrize(
    ("extension", "count"), [("ply", 3), ("stl", 2), ("off", 1), ("glb", 1), ("gltf", 1)]
)
def test_another_reader_finds_the_same_triangles(tmp_path: Path, extension: str, count: int) -> None:
    # The others it does not read: polygons of several sizes, and faces with colours.
    for content in valid(extension)[:count]:
        mesh = read_mesh(written(tmp_path, content, extension))
        other = trimesh.load_scene(tmp_path / f"mesh.{extension}", process=False).to_mesh()
        found = mesh.vertices[mesh.corners.reshape(-1, 3)]
        np.testing.assert_allclose(found, other.vertices[other.faces], atol=1e-12)
        if extension in ("ply", "off"):
            assert mesh.corners.tolist() == other.faces.ravel().tolist()


def test_polygons_are_cut_as_elsewhere() -> None:
    chance = np.random.default_rng(1)
    for sizes in ([3, 3], [4, 4, 4], [3, 4, 3, 4], [5, 3, 7, 4, 3, 6, 4]):
        polygons = [chance.permutation(9)[:size].tolist() for size in sizes]
        mesh = cut("a", chance.normal(size=(9, 3)), np.array(sum(polygons, [])), np.array(sizes))
        assert mesh.corners.tolist() == trimesh.geometry.triangulate_quads(polygons).ravel().tolist()


def test_errors_that_quote_others_are_found() -> None:
    def raised(text: Callable[[Exception], str]) -> Exception:
        try:
            try:
                struct.unpack("<I", b"")
            except struct.error as error:
                raise MeshError(text(error)) from None
        except MeshError as error:
            return error
        raise AssertionError

    assert leak(raised(lambda error: f"a.glb: {error}")) is not None
    assert leak(raised(lambda error: f"a.glb: {type(error).__name__}")) == "error"
    assert leak(raised(lambda error: "a.glb: is cut short")) is None


# ---- what was found once


def changed(place: str, index: int, **values: Any) -> bytes:
    tree = gltf_tree(None, 78)
    tree[place][index].update(values)
    return glb(tree)


OFF = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n"
GLB, STL = valid("glb")[0], valid("stl")[0]
FOUND: dict[str, tuple[str, bytes, str]] = {
    "a face of too many": ("off", OFF + b"999999999 0 1 2\n", ":6: `999999999 0 1 2` is no face"),
    "a face of too few": ("off", OFF + b"4 0 1 2\n", ":6: .* how many corners follow"),
    "more than declared": ("off", OFF + b"3 0 1 2\n3 0 2 1\n", ":7: there is more than the 3 vertices"),
    "an external buffer": ("glb", changed("buffers", 0, uri="a.bin"), "'a.bin', which is not opened; save"),
    "too long a length": (
        "glb",
        GLB[:8] + struct.pack("<I", 9999) + GLB[12:],
        "is cut short: .* 9999 bytes",
    ),
    "too short a length": ("glb", GLB[:8] + struct.pack("<I", 40) + GLB[12:], "too long: its head says 40"),
    "too long a chunk": ("glb", GLB[:12] + struct.pack("<I", 2**31) + GLB[16:], "the chunk at byte 20"),
    "a truncated STL": ("stl", STL[:-7], "it declares 3 triangles, which take 234 bytes"),
    "an STL without an end": ("stl", STL[:50], "the head of an STL file has 84 bytes, there are 50"),
    "two parents": ("glb", changed("nodes", 1, children=[2]), r"nodes\[2\] is reached twice"),
    "a loop of nodes": ("glb", changed("nodes", 2, children=[0]), r"nodes\[0\] is reached twice"),
    "no such mesh": (
        "glb",
        changed("nodes", 1, mesh=7),
        r"nodes\[1\].mesh asks for meshes\[7\]",
    ),
    "a huge count": ("glb", changed("accessors", 0, count=2**62), r"accessors\[0\] needs .* bytes"),
    "too large an index": ("glb", changed("accessors", 0, count=3), r"primitives\[0\] has the index 3"),
    "sparse numbers": ("glb", changed("accessors", 0, sparse={}), "is sparse; export it without"),
    "too large a scale": ("glb", changed("nodes", 1, scale=[10**400, 1, 1]), "scale = .* 3 finite numbers"),
    "JSON that stops": ("gltf", valid("gltf")[0][:100], "its JSON is damaged in line 13, column 1"),
    "JSON that is no text": ("gltf", b'{"a": "\xff"}', "byte 7 of its JSON is no UTF-8"),
}


@pytest.mark.parametrize("name", FOUND)
def test_what_was_found_once(tmp_path: Path, name: str) -> None:
    extension, content, words = FOUND[name]
    path = written(tmp_path, content, extension)
    assert judge(path) is not None
    with pytest.raises(MeshError, match=words):
        read_mesh(path)


@pytest.mark.filterwarnings("error")
def test_matrices_of_tiny_numbers_are_read_silently(tmp_path: Path) -> None:
    tiny = [3e-320, 0, 0, 0, 0, 1e-320, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    assert judge(written(tmp_path, changed("nodes", 1, matrix=tiny), "glb")) is None


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("extension", ["stl", "ply", "glb"])
def test_signalling_nans_are_refused_as_any_others(tmp_path: Path, extension: str) -> None:
    content = next(content for content in valid(extension) if struct.pack("<f", 1) in content)
    content = content.replace(struct.pack("<f", 1), b"\x01\x00\xa0\x7f")
    said = judge(written(tmp_path, content, extension))
    assert said is not None and "finite" in said


@pytest.mark.parametrize("deep", [True, False])
def test_nodes_are_looked_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, deep: bool) -> None:
    count, asked, entry = 5000, [], Document.entry

    def counted(self: Document, kind: str, index: int, asking: str) -> Any:
        asked.append(kind)
        return entry(self, kind, index, asking)

    tree = gltf_tree(None, 78)
    children = [[node + 1] if node + 1 < count else [] for node in range(count)] if deep else [[]] * count
    tree["nodes"] = [{"mesh": 0, "translation": [0, 0, 1], "children": below} for below in children]
    tree["scenes"][0]["nodes"] = [0] if deep else list(range(count))
    monkeypatch.setattr(Document, "entry", counted)
    mesh = read_mesh(written(tmp_path, glb(tree), "glb"))
    assert len(mesh.counts) == 3 * count
    assert mesh.vertices[:, 2].max() == (count if deep else 1) + 0.25
    assert len(asked) < 2 * count + 20


def test_json_of_many_levels_is_refused(tmp_path: Path) -> None:
    said = judge(written(tmp_path, glb(json.loads("[" * 500 + "]" * 500)), "glb"))
    assert said is not None and "must be a table" in said
    said = judge(written(tmp_path, b"[" * 100_000, "gltf"))
    assert said is not None and "nested too deeply" in said
