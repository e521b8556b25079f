"""All attacks, by name."""

from __future__ import annotations

from importlib import import_module

from tests.attack.frame import Attack

_PLACES = {
    "whole": "tests.attack.whole:Whole",
    "texts": "tests.attack.texts:Texts",
    "orders": "tests.attack.orders:Orders",
    "sockets": "tests.attack.sockets:Sockets",
    "snapshots": "tests.attack.snapshots:Snapshots",
    "caches": "tests.attack.caches:Caches",
    "resumes": "tests.attack.resumes:Resumes",
    "scenes": "tests.attack.fields:Fields",
    "meshes": "tests.attack.mesh_files:MeshFiles",
}


def names() -> list[str]:
    """In the order in which they take turns."""
    return list(_PLACES)


def find(name: str) -> type[Attack]:
    """The attack of this name, or at this place: `module:Class`."""
    module, _, kind = _PLACES.get(name, name).partition(":")
    found: type[Attack] = getattr(import_module(module), kind)
    return found
