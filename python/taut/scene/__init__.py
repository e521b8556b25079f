"""Scenes: read from TOML or a dict, checked by the engine, with their meshes."""

from taut.scene.meshes import Mesh
from taut.scene.scene import Scene
from taut.scene.shipped import ShippedScene, find_scene, shipped_scenes

__all__ = ["Mesh", "Scene", "ShippedScene", "find_scene", "shipped_scenes"]
