"""Meshes in, frames out.

>>> polygons = read_mesh("shirt.obj")
>>> export(Cache.open("shirt.zarr"), "pc2", "shirt.pc2")
"""

from taut.formats.exporting import EXPORTERS, export
from taut.formats.pc2 import read_pc2
from taut.formats.polygons import MeshError, Polygons
from taut.formats.read import MESH_EXTENSIONS, read_mesh
from taut.formats.writing import ExportError
from taut.output import OutputError

__all__ = [
    "EXPORTERS",
    "MESH_EXTENSIONS",
    "ExportError",
    "MeshError",
    "OutputError",
    "Polygons",
    "export",
    "read_mesh",
    "read_pc2",
]
