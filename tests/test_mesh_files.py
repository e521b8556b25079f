"""Mesh files in: nothing re-ordered, no file that breaks the reader, no file opened that was not named."""

import base64
import json
import os
import re
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from taut.formats import MESH_EXTENSIONS, MeshError, read_mesh

from tests.attack.leaks import leak

CUBE = trimesh.creation.box()
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read_text(tmp_path: Path, text: str | bytes, name: str = "mesh.obj"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_mesh(path)


# ---- Wavefront OBJ in


def test_obj_keeps_vertices_polygons_and_their_order(tmp_path):
    text = """# a comment
mtllib /etc/passwd
o first
v 1 2 3
v 4 5 6 # comment
v 7 8 9 0.5
vt 0 0
vn 0 0 1
usemtl red
s 1
g left right
f 1/1/1 2/1/1 3/1/1
o second
v -1 -2 -3e0 1 0 0
v\t4.5   5 6
f 5//1 4//1 1//1 2//1
f -1 -2 \\
  -3 -4 \\
  -5
l 1 2
curv 0 1 1 2
"""
    mesh = read_text(tmp_path, text)
    assert mesh.vertices.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9], [-1, -2, -3], [4.5, 5, 6]]
    assert mesh.counts.tolist() == [3, 4, 5]
    assert mesh.corners.tolist() == [0, 1, 2, 4, 3, 0, 1, 4, 3, 2, 1, 0]
    assert mesh.repairs == ()
    assert (mesh.vertices.dtype, mesh.corners.dtype, mesh.counts.dtype) == (np.float64, np.int64, np.int64)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_obj_line_ends_marks_and_foreign_names(tmp_path, end, mark):
    text = mark + (OBJ + "g \xe9\xff\nf 1 2 3 4").replace("\n", end).encode("latin-1")
    mesh = read_text(tmp_path, text, "MESH.OBJ")
    assert mesh.counts.tolist() == [4] and len(mesh.vertices) == 4


def test_obj_faces_may_come_before_their_vertices(tmp_path):
    assert read_text(tmp_path, "f 1 2 3\n" + OBJ).corners.tolist() == [0, 1, 2]


HOSTILE_OBJ = {
    "index too large": (OBJ + "f 1 2 99\n", ":5: face index 99 is out of range, the file has 4 vertices"),
    "index zero": (OBJ + "f 0 1 2\n", ":5: face index 0 is out of range"),
    "index too negative": (OBJ + "f -1 -2 -5\nv 0 0 0\n", ":5: face index -5 .* 4 vertices before this line"),
    "negative before any": ("f -1 -1 -1\n" + OBJ, ":1: face index -1 .* 0 vertices before this line$"),
    "index beyond 64 bits": (OBJ + f"f 1 2 {10**30}\n", ":5: a face index is too large"),
    "index with 5000 digits": (OBJ + f"f 1 2 {'9' * 5000}\n", ":5: not a face"),
    "index is a float": (OBJ + "f 1 2 3.0\n", ":5: not a face"),
    "index is a word": (OBJ + "f 1 2 three\n", ":5: not a face"),
    "index is missing": (OBJ + "f 1 2 /3\n", ":5: not a face"),
    "index is grouped": (OBJ + "f 1 2 0_3\n", ":5: an underscore"),
    "index undecodable": (OBJ.encode() + b"f 1 2 \xff\xfe\n", ":5: not a face"),
    "face of two": (OBJ + "f 1 2\n", ":5: a face needs 3 corners or more, this line has 2"),
    "face of none": (OBJ + "f\n", ":5: a face needs 3 corners or more, this line has 0"),
    "vertex of two": ("v 1 2\n", ":1: a vertex needs 3 coordinates, this line has 2"),
    "vertex 1e999": (OBJ + "v 1e999 0 0\nf 1 2 3\n", ":5: vertex inf 0.0 0.0 is not finite"),
    "vertex nan": (OBJ + "\n\nv 0 nan 0\nf 1 2 3\n", ":7: vertex 0.0 nan 0.0 is not finite"),
    "vertex -inf": ("v 0 0 -inf\n" + OBJ + "f 1 2 3\n", ":1: vertex 0.0 0.0 -inf is not finite"),
    "vertex is a word": ("v a b c\n", ":1: not a vertex"),
    "vertex undecodable": (b"v 1 2 \x80\n", ":1: not a vertex"),
    "vertex with commas": ("v 1,0 2,0 3,0\n", ":1: not a vertex"),
    "vertex hexadecimal": ("v 0x10 0 0\n", ":1: not a vertex"),
    "no vertices": ("f 1 2 3\n", "holds no vertices"),
    "no faces": (OBJ, "holds no faces"),
    "only comments": ("# nothing\n", "holds no vertices"),
    "empty": ("", "is empty"),
    "UTF-16": ((OBJ + "f 1 2 3\n").encode("utf-16"), "is no text file"),
    "binary": (bytes(range(256)) * 20, "is no text file"),
    "noise without zeros": (bytes(range(1, 256)) * 20, "holds no vertices"),
    "line number after continuation": (OBJ + "f 1 \\\n 2 \\\n 3\nf 9 9 9\n", ":8: face index 9"),
    "continuation at the end": (OBJ + "f 1 2 \\", ":5: a face needs"),
    "html": ("<!DOCTYPE html><html>404</html>", "holds no vertices"),
}


@pytest.mark.parametrize("name", HOSTILE_OBJ)
def test_hostile_obj(tmp_path, name):
    text, message = HOSTILE_OBJ[name]
    with pytest.raises(MeshError, match=message) as error:
        read_text(tmp_path, text)
    assert str(error.value).startswith(str(tmp_path / "mesh.obj"))
    assert leak(error.value) is None


def test_obj_cut_anywhere_is_read_or_refused(tmp_path):
    whole = (OBJ + "vn 0 0 1\nf 1//1 2//1 3//1\nf -4 -2 -1 \\\n -3\n").encode()
    for length in range(len(whole)):
        try:
            mesh = read_text(tmp_path, whole[:length])
        except MeshError:
            continue
        assert mesh.corners.max() < len(mesh.vertices)


coordinate = st.floats(allow_nan=False, allow_infinity=False, width=64)


@settings(max_examples=200, deadline=None)
@given(data=st.data())
def test_obj_written_and_read_is_the_same(tmp_path_factory, data):
    vertices = data.draw(st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=1, max_size=20))
    index = st.integers(0, len(vertices) - 1)
    faces = data.draw(st.lists(st.lists(index, min_size=3, max_size=7), min_size=1, max_size=20))
    negative = data.draw(st.booleans())
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices]
    lines += ["f " + " ".join(str(i - len(vertices) if negative else i + 1) for i in face) for face in faces]
    mesh = read_text(tmp_path_factory.mktemp("obj"), "\n".join(lines))
    assert mesh.vertices.tolist() == [list(vertex) for vertex in vertices]
    assert mesh.counts.tolist() == [len(face) for face in faces]
    assert mesh.corners.tolist() == [i for face in faces for i in face]


@settings(max_examples=300, deadline=None)
@given(noise=st.binary(max_size=200), extension=st.sampled_from(MESH_EXTENSIONS))
def test_noise_is_read_or_refused(tmp_path_factory, noise, extension):
    name = f"a.{extension}"
    head = {"a.obj": b"v 0 0 0\nf ", "a.ply": b"ply\nformat ascii 1.0\n", "a.off": b"OFF\n"}.get(name, b"")
    try:
        mesh = read_text(tmp_path_factory.mktemp("noise"), head + noise, name)
    except MeshError:
        return
    assert np.isfinite(mesh.vertices).all() and mesh.corners.max() < len(mesh.vertices)


# ---- other formats in


def ply(vertices: list[str], faces: list[str], **counts: int) -> bytes:
    head = f"""ply
format ascii 1.0
element vertex {counts.get("vertex", len(vertices))}
property float x
property float y
property float z
element face {counts.get("face", len(faces))}
property list uchar int vertex_indices
end_header
"""
    return (head + "\n".join(vertices + faces) + "\n").encode()


CORNERS = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]


def gltf(uri: str | None = None, **accessor: object) -> bytes:
    """One triangle; `accessor` changes its first accessor, `uri` where its numbers lie."""
    numbers = struct.pack("<9f3H", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 2)
    first = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"} | accessor
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [first, {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "buffers": [{"byteLength": 42, "uri": uri or "data:x;base64," + base64.b64encode(numbers).decode()}],
    }
    return json.dumps(document).encode()


@pytest.mark.parametrize("extension", ["ply", "stl", "off", "glb"])
def test_other_formats_give_the_same_cube(tmp_path, extension):
    mesh = read_text(tmp_path, CUBE.export(file_type=extension), f"cube.{extension}")
    assert len(mesh.vertices) == 8 and mesh.counts.tolist() == [3] * 12
    triangles = mesh.vertices[mesh.corners.reshape(-1, 3)]
    assert np.allclose(triangles, CUBE.vertices[CUBE.faces])
    if extension in ("ply", "off"):
        assert np.allclose(mesh.vertices, CUBE.vertices) and mesh.repairs == ()
    if extension == "stl":
        assert "36 vertices were joined into 8" in mesh.repairs[0]


def test_ascii_stl_and_embedded_gltf(tmp_path):
    assert len(read_text(tmp_path, CUBE.export(file_type="stl_ascii"), "cube.stl").vertices) == 8
    mesh = read_text(tmp_path, gltf(), "one.gltf")
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]] and mesh.corners.tolist() == [0, 1, 2]


def test_quads_of_ply_are_cut_and_it_is_said(tmp_path):
    mesh = read_text(tmp_path, ply(CORNERS, ["4 0 1 2 3"]), "quad.ply")
    assert mesh.counts.tolist() == [3, 3]
    assert mesh.repairs == ("faces were cut into triangles (1 became 2); OBJ keeps polygons whole",)
    mesh = read_text(
        tmp_path, ply([*CORNERS, "0.5 2 0"], ["3 0 1 4", "5 0 1 2 4 3", "4 0 1 2 3"]), "mixed.ply"
    )
    assert mesh.counts.tolist() == [3] * 6 and len(mesh.vertices) == 5
    assert mesh.repairs == ("faces were cut into triangles (3 became 6); OBJ keeps polygons whole",)
    mesh = read_text(tmp_path, "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n", "quad.off")
    assert mesh.counts.tolist() == [3, 3] and len(mesh.repairs) == 1


def test_ply_keeps_vertices_where_textures_meet(tmp_path):
    text = ply(CORNERS, ["3 0 1 2 6 0 0 0 1 1 1", "3 0 2 3 6 .5 .5 0 0 0 1"])
    text = text.replace(b"end_header", b"property list uchar float texcoord\nend_header")
    assert len(read_text(tmp_path, text, "seam.ply").vertices) == 4


BINARY_PLY = CUBE.export(file_type="ply")
HOSTILE_OTHER = {
    "ply index too large": ("a.ply", ply(CORNERS, ["3 0 1 9"])),
    "ply index negative": ("a.ply", ply(CORNERS, ["3 0 1 -1"])),
    "ply nan": ("a.ply", ply(["nan 0 0", *CORNERS[1:]], ["3 0 1 2"])),
    "ply 1e999": ("a.ply", ply(["1e999 0 0", *CORNERS[1:]], ["3 0 1 2"])),
    "ply word": ("a.ply", ply(["one 0 0", *CORNERS[1:]], ["3 0 1 2"])),
    "ply huge counts": ("a.ply", ply(CORNERS, ["3 0 1 2"], vertex=10**12)),
    "ply huger counts": ("a.ply", ply(CORNERS, ["3 0 1 2"], face=10**40)),
    "ply fewer faces": ("a.ply", ply(CORNERS, ["3 0 1 2"], face=2)),
    "ply huge binary counts": ("a.ply", BINARY_PLY.replace(b"vertex 8", b"vertex 4000000000")),
    "ply no faces": ("a.ply", ply(CORNERS, [])),
    "ply no vertices": ("a.ply", ply([], [])),
    "ply no header end": ("a.ply", ply(CORNERS, []).partition(b"end_header")[0]),
    "ply unknown type": ("a.ply", ply(CORNERS, ["3 0 1 2"]).replace(b"float z", b"quad z")),
    "ply without z": ("a.ply", ply(CORNERS, ["3 0 1 2"]).replace(b"float z", b"float w")),
    "ply is noise": ("a.ply", bytes(range(256))),
    "stl huge count": ("a.stl", b"\0" * 80 + struct.pack("<I", 2**32 - 1)),
    "stl zero triangles": ("a.stl", b"\0" * 84),
    "stl nan": ("a.stl", b"\0" * 80 + struct.pack("<I12fH", 1, 0, 0, 1, *[float("nan")] * 9, 0)),
    "stl word": ("a.stl", CUBE.export(file_type="stl_ascii").replace("vertex ", "vertex x")),
    "stl without end": ("a.stl", CUBE.export(file_type="stl_ascii").replace("endsolid", "")),
    "stl is noise": ("a.stl", bytes(range(256))),
    "off index too large": ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
    "off index negative": ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
    "off 1e999": ("a.off", "OFF\n3 1 0\n0 0 1e999\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "off huge counts": ("a.off", "OFF\n999999999999 1 0\n0 0 0\n"),
    "off negative counts": ("a.off", "OFF\n-3 -1 0\n0 0 0\n"),
    "off no faces": ("a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"),
    "off face of two": ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n"),
    "gltf huge count": ("a.gltf", gltf(count=10**10)),
    "gltf huge count of zeros": ("a.gltf", gltf(count=10**9).replace(b'"bufferView": 0, ', b"", 1)),
    "gltf negative count": ("a.gltf", gltf(count=-1)),
    "gltf count is text": ("a.gltf", gltf(count="3")),
    "gltf other file": ("a.gltf", gltf(uri="secret.bin")),
    "gltf path": ("a.gltf", gltf(uri="../../etc/passwd")),
    "gltf address": ("a.gltf", gltf(uri="file:///etc/passwd")),
    "gltf web address": ("a.gltf", gltf(uri="https://example.com/a.bin")),
    "gltf list": ("a.gltf", b"[]"),
    "gltf deep": ("a.gltf", b"[" * 100_000),
    "gltf empty object": ("a.gltf", b"{}"),
    "glb header only": ("a.glb", b"glTF" + struct.pack("<II", 2, 12)),
    "glb huge chunk": ("a.glb", b"glTF" + struct.pack("<IIII", 2, 2**32 - 1, 2**32 - 1, 0x4E4F534A)),
    "glb is noise": ("a.glb", bytes(range(256))),
}


@pytest.mark.parametrize("name", HOSTILE_OTHER)
def test_hostile_files_of_other_formats(tmp_path, name, capfd):
    file, content = HOSTILE_OTHER[name]
    with pytest.raises(MeshError) as error:
        read_text(tmp_path, content, file)
    message = str(error.value)
    assert re.match(rf"{re.escape(str(tmp_path / file))}(:\d+)?: ", message)
    assert leak(error.value) is None
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("extension", ["ply", "stl", "stl_ascii", "off", "glb"])
def test_other_formats_cut_anywhere_lose_nothing_silently(tmp_path, extension):
    whole = CUBE.export(file_type=extension)
    whole = whole if isinstance(whole, bytes) else whole.encode()
    steps = max(1, len(whole) // 150)
    for length in range(0, len(whole.rstrip()) - 1, steps):
        try:
            mesh = read_text(tmp_path, whole[:length], f"cube.{extension.removesuffix('_ascii')}")
        except MeshError:
            continue
        # What is cut off may be the last digits of a number; never a face or a vertex.
        assert len(mesh.counts) == 12 and len(mesh.vertices) == 8, length


def test_no_referenced_file_is_opened(tmp_path, monkeypatch):
    (tmp_path / "secret.bin").write_bytes(struct.pack("<9f3H", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 2))
    (tmp_path / "secret.mtl").write_text("newmtl red\nmap_Kd secret.png\n")
    texture = b"comment TextureFile secret.png\nelement vertex"
    files = {
        "a.obj": b"mtllib secret.mtl\ncall secret.obj\n" + OBJ.encode() + b"f 1 2 3\n",
        "a.ply": ply(CORNERS, ["3 0 1 2"]).replace(b"element vertex", texture),
        "a.gltf": gltf(uri="secret.bin"),
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
        try:
            read_mesh(tmp_path / name)  # the readers' own modules are loaded now
        except MeshError:
            assert name == "a.gltf"
    opened = []
    monkeypatch.chdir(tmp_path)
    watching = [True]
    sys.addaudithook(lambda event, args: watching and event == "open" and opened.append(str(args[0])))
    for name in files:
        try:
            read_mesh(name)
        except MeshError:
            assert name == "a.gltf"
    watching.clear()
    assert set(opened) == set(files)


def test_files_that_are_none(tmp_path):
    with pytest.raises(MeshError, match="cannot be opened: No such file"):
        read_mesh(tmp_path / "none.obj")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(MeshError, match="not a regular file"):
        read_mesh(tmp_path / "folder.obj")
    os.mkfifo(tmp_path / "pipe.obj")
    with pytest.raises(MeshError, match="not a regular file"):
        read_mesh(tmp_path / "pipe.obj")
    with pytest.raises(MeshError, match="'?.blend is not a mesh format; readable are .obj, .ply, .stl"):
        read_mesh(tmp_path / "cloth.blend")
    with pytest.raises(MeshError, match="no extension is not"):
        read_mesh(tmp_path / "cloth")


def test_too_large_files_are_refused_unread(tmp_path):
    with (tmp_path / "large.ply").open("wb") as file:
        file.truncate((1 << 30) + 1)
    with pytest.raises(MeshError, match=r"is too large \(1.1 GB\); the limit is 1.1 GB"):
        read_mesh(tmp_path / "large.ply")
