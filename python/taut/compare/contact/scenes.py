"""Small scenes with contact, on which methods in NumPy take seconds."""

from collections.abc import Callable, Sequence
from typing import Any

from taut.compare.names import chosen
from taut.scene import Scene

Fields = dict[str, Any]

_FLOOR: Fields = {"name": "floor", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
_CLOTH: Fields = {
    "density": 0.5,
    "thickness": 0.01,
    "friction": 0.3,
    "bending": "fabric",
    "air_drag": 0.5,
}


def _grid(cells: int | tuple[int, int], size: tuple[float, float], origin: list[float], axes: str) -> Fields:
    counts = [cells, cells] if isinstance(cells, int) else list(cells)
    return {"grid": {"size": list(size), "cells": counts, "origin": origin, "axes": list(axes)}}


def _ball() -> Fields:
    ball = {"name": "ball", "sphere": {"center": [0, 0, 0.3], "radius": 0.2}, "friction": 0.3}
    sheet = _CLOTH | _grid(16, (0.8, 0.8), [-0.37, -0.41, 0.53], "xy")
    return {"title": "Sheet on a ball", "duration": 0.8, "body": [_FLOOR, ball], "cloth": [sheet]}


def _heap() -> Fields:
    sheet = _CLOTH | _grid(16, (0.6, 0.6), [-0.3, 0.0, 0.02], "xz") | {"rotate": [7, 0, 0]}
    return {"title": "Sheet dropped on its edge", "duration": 0.7, "body": [_FLOOR], "cloth": [sheet]}


def _layers() -> Fields:
    box = {"name": "box", "box": {"center": [0, 0, 0.2], "size": [0.2, 0.2, 0.2]}, "friction": 0.3}
    low = _CLOTH | _grid(10, (0.5, 0.5), [-0.24, -0.27, 0.32], "xy") | {"name": "low"}
    high = _CLOTH | _grid(10, (0.5, 0.5), [-0.27, -0.23, 0.36], "xy") | {"name": "high"}
    return {"title": "Two sheets on a box", "duration": 0.6, "body": [_FLOOR, box], "cloth": [low, high]}


def _twist() -> Fields:
    def end(edge: str, way: float) -> Fields:
        angle = [[1.0, 360.0 * way]]
        moves = [[0.3, [0.03 * way, 0, 0]], [1.0, [0.1 * way, 0, 0]]]
        return {"edge": edge, "turn": {"axis": [1, 0, 0], "point": [0, 0, 0], "angle": angle}, "move": moves}

    strip = _CLOTH | _grid((16, 8), (0.6, 0.3), [-0.3, -0.15, 0.0], "xy")
    pins = [end("left", 1.0), end("right", -1.0)]
    return {"title": "Twisted strip", "duration": 1.0, "cloth": [strip | {"pins": pins}]}


_BUILT: dict[str, Callable[[], Fields]] = {
    "ball": _ball,
    "heap": _heap,
    "layers": _layers,
    "twist": _twist,
}

NAMES = tuple(_BUILT)
"""All scenes, in the order of tables."""


def built_in(names: Sequence[str] = ("all",), settings: Sequence[str] = ()) -> dict[str, Scene]:
    """Scenes by name, in the order given, each once.

    Args:
        names: some of :data:`NAMES`, or `all`.
        settings: changes of fields, for all of them, see :meth:`taut.Scene.with_settings`.

    Raises:
        CompareError: a name is unknown, or there is none.
        SceneError: a setting is not valid for one of them.
    """
    return {name: Scene(_BUILT[name]()).with_settings(settings) for name in chosen("scenes", names, NAMES)}
