"""Scenes: read from TOML or a dict, checked by the engine, with their meshes and paths."""

from taut.scene.meshes import Mesh
from taut.scene.needs import Needs
from taut.scene.paths import FollowedPath
from taut.scene.scene import Scene
from taut.scene.shipped import ShippedScene, find_scene, shipped_scenes

__all__ = ["FollowedPath", "Mesh", "Needs", "Scene", "ShippedScene", "find_scene", "shipped_scenes"]
