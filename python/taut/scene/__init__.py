"""Scenes: read from TOML or a dict, checked by the engine, with their meshes."""

from taut.scene.meshes import Mesh
from taut.scene.scene import Scene

__all__ = ["Mesh", "Scene"]
