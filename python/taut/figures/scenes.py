"""The cloths of the paper's section 4, and the strip of its Fig. 2. Sizes are ours: the paper gives none."""

from dataclasses import dataclass
from typing import Any

Document = dict[str, Any]

LIMIT = 0.10
"""Strain limit of sheets and strip: the example of the paper, section 3 [1]."""

FLAG_LIMIT = 0.05
"""Strain limit of the flags [1]."""

STRIP = (1.0, 0.2)
"""Length and breadth of the strip [m]."""

STRIP_STIFFNESS, STRIP_SHEAR = 20.0, 10.0
"""Of the strip, as of the preset `cotton` [N/m]."""

STRIP_DENSITY = 0.02
"""Of the strip: light, since what it carries is to be the load [kg/m^2]."""

GRAVITY = 9.81
"""[m/s^2]"""


@dataclass(frozen=True, slots=True)
class Size:
    """How large and long everything is."""

    flag: tuple[int, int] = (72, 48)
    """Cells of the flags."""
    sheet: int = 32
    """Cells along a side of the sheets."""
    strip: tuple[int, int] = (25, 5)
    """Cells of the strip."""
    loads: int = 12
    """Loads on the strip."""
    flag_seconds: float = 4.0
    drop_seconds: float = 3.0
    rest_seconds: float = 16.0


QUICK = Size((12, 8), 8, (10, 2), 4, 0.5, 0.6, 1.0)
"""For tests: everything is made, nothing is worth reading."""


def flag(size: Size, wind: tuple[float, float, float], method: str, title: str) -> Document:
    """A flag of 1.5 m x 1 m at a pole, the wind [m/s] with gusts of 30 %."""
    cloth = {
        "name": "flag",
        "grid": {"size": [1.5, 1.0], "cells": list(size.flag), "origin": [0, 0, 1], "axes": ["x", "z"]},
        "fabric": "nylon",
        "strain_limit": FLAG_LIMIT,
        "density": 0.2,
        "pins": [{"edge": "left"}],
    }
    gust = {"strength": 0.3, "period": 1.7, "seed": 1}
    return {
        "title": title,
        "duration": size.flag_seconds,
        "solver": {"filter": method},
        "wind": {"velocity": list(wind), "gust": gust},
        "cloth": [cloth],
    }


def sheet(size: Size, corners: int, seconds: float, method: str, title: str) -> Document:
    """A level sheet of 1 m x 1 m, held by one corner or by two, let go."""
    held = [{"corner": "bottom-left"}, {"corner": "top-left"}][:corners]
    cloth = {
        "name": "sheet",
        "grid": {"size": [1.0, 1.0], "cells": [size.sheet] * 2, "origin": [0, 0, 1.5], "axes": ["x", "y"]},
        "fabric": "cotton",
        "strain_limit": LIMIT,
        "density": 0.2,
        "air_drag": 0.5,
        "pins": held,
    }
    return {"title": title, "duration": seconds, "solver": {"filter": method}, "cloth": [cloth]}


def strip(size: Size, pull: float, method: str) -> Document:
    """A strip that hangs from its upper edge with a mass along its lower edge.

    Args:
        size: how many cells it has.
        pull: force per breadth in its middle, of the mass and of half its own [N/m].
        method: the filter.
    """
    load = STRIP[1] * (pull / GRAVITY - STRIP[0] * STRIP_DENSITY / 2)
    cloth = {
        "grid": {"size": list(STRIP), "cells": list(size.strip), "axes": ["z", "y"]},
        "stiffness": STRIP_STIFFNESS,
        "shear_stiffness": STRIP_SHEAR,
        "damping": 0.004,
        "density": STRIP_DENSITY,
        "strain_limit": LIMIT,
        "pins": [{"edge": "right"}],
        "weights": [{"edge": "left", "mass": load}],
    }
    return {"gravity": [0.0, 0.0, -GRAVITY], "solver": {"filter": method}, "cloth": [cloth]}
