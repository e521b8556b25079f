"""`make wind`: one flag under every form and law of the wind, for docs/methods/wind.md.

Rewrites the table between the markers of that page and its picture. Everything is measured in the last four
seconds of six; docs/methods/wind.md says how.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import taut
from numpy.typing import NDArray
from taut.render import RenderOptions, render_still

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "methods" / "wind.md"
PICTURE = ROOT / "docs" / "pictures" / "wind.jpg"
BEGIN, END = "<!-- comparison: begin -->\n", "<!-- comparison: end -->"

LENGTH, HEIGHT, CELLS = 2.0, 1.0, (64, 32)
START, SECONDS, FPS = 2.0, 6.0, 60.0
AIR = 1.2

FRICTION = 0.01
GUST = {"strength": 0.3, "period": 1.7, "seed": 1}

WINDS: dict[str, dict[str, Any]] = {
    "pressure on particles": {},
    "pressure on triangles": {"model": "triangle"},
    "drag and lift on particles": {"law": "drag_lift"},
    "drag and lift on triangles": {"law": "drag_lift", "model": "triangle"},
    "pressure and friction": {"friction": FRICTION},
    "pressure, two vortices": {"vortices": 0.5},
    "pressure, gusts": {"gust": GUST},
    "drag and lift, gusts": {"law": "drag_lift", "gust": GUST},
    "drag and lift, gusts, two vortices": {"law": "drag_lift", "gust": GUST, "vortices": 0.5},
}
SHOWN = [list(WINDS)[row] for row in (0, 2, 6, 8)]


@dataclass(frozen=True)
class Flown:
    """What a flag did."""

    drag: float
    """Mean force along the wind over the dynamic pressure and the area of one side [1]."""
    hang: float
    """Mean angle from the hoist's middle down to the middle of the free edge [degrees]."""
    sway: float
    """Root mean square of the sideways motion of the middle of the free edge, in lengths of the flag [1]."""
    beat: float
    """Its mean frequency (passes through its mean, in pairs) times the length over the wind speed [1]."""
    rough: float
    """Root mean square fold between the triangles of a cell, mean over time [degrees]."""


def scene(name: str, speed: float) -> taut.Scene:
    """The flag of a row, at a mean wind speed [m/s]."""
    wind = dict(WINDS[name])
    vortices = vortices_of(wind.pop("vortices", 0.0) * speed)
    flag = {
        "grid": {"size": [LENGTH, HEIGHT], "cells": list(CELLS), "origin": [0, 0, 1]},
        "fabric": "nylon",
        "density": 0.12,
        "air_drag": 0.0,
        "bending": 1e-5,
        "friction_coefficient": wind.pop("friction", 0.0),
        "pins": [{"edge": "left"}],
    }
    document = {
        "title": f"{name[0].upper()}{name[1:]}, {speed:g} m/s",
        "duration": SECONDS,
        "fps": FPS,
        "wind": {"velocity": [speed, 0.05 * speed, 0.0], "density": AIR, "elements": vortices, **wind},
        "cloth": [flag],
    }
    return taut.Scene(document)


def vortices_of(circulation: float) -> list[dict[str, Any]]:
    """Two vortices of opposite sense [m^2/s] beside the flag, as behind a pole; 0 for none."""
    places = [(0.7, 0.35, circulation), (1.5, -0.35, -circulation)]
    shape = {"kind": "vortex", "axis": [0, 0, 1], "core": 0.25}
    return [{**shape, "centre": [x, y, 0.0], "circulation": turn} for x, y, turn in places if turn]


def fly(name: str, speed: float) -> Flown:
    """Simulate a row's flag and measure it."""
    simulation = taut.Simulation(scene(name, speed))
    tip = (CELLS[0] + 1) * (CELLS[1] // 2) + CELLS[0]
    forces, tips, folds = [], [], []

    def look(now: taut.Simulation) -> None:
        if now.time > START:
            forces.append(now.external_forces()[:, 0].sum(dtype=float))
            tips.append(now.positions[tip].astype(float))
            folds.append(roughness(now.positions, now.faces))

    simulation.run(round(SECONDS * FPS), look)
    path = np.array(tips)
    side = path[:, 1] - path[:, 1].mean()
    beats = np.count_nonzero(np.diff(np.signbit(side))) / 2 / (SECONDS - START)
    drop = 1.0 + HEIGHT / 2 - path[:, 2].mean()
    return Flown(
        drag=float(np.mean(forces)) / (0.5 * AIR * speed**2 * LENGTH * HEIGHT),
        hang=float(np.degrees(np.arctan2(drop, path[:, 0].mean()))),
        sway=float(np.sqrt(np.mean(side**2))) / LENGTH,
        beat=beats * LENGTH / speed,
        rough=float(np.mean(folds)),
    )


def roughness(positions: NDArray[np.float32], faces: NDArray[np.int32]) -> float:
    """Root mean square fold between the two triangles of each cell [degrees]."""
    a, b, c = (positions[faces[:, corner]].astype(float) for corner in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    folds = np.arccos(np.clip(np.sum(normals[0::2] * normals[1::2], axis=1), -1.0, 1.0))
    return float(np.degrees(np.sqrt(np.mean(folds**2))))


def picture() -> None:
    """Four of the flags side by side."""
    with tempfile.TemporaryDirectory() as folder:
        caches = [Path(folder) / f"{index}.zarr" for index in range(len(SHOWN))]
        for name, cache in zip(SHOWN, caches, strict=True):
            taut.record(taut.Simulation(scene(name, 8.0)), cache)
        options = RenderOptions(frame=280, color="fabric", size=(420, 400), overwrite=True)
        render_still([taut.Cache.open(cache) for cache in caches], PICTURE, options)


def main() -> None:
    """Measure, rewrite the page, draw."""
    speeds = (4.0, 8.0, 16.0)
    rows = ["| wind | " + " | ".join(f"{speed:g} m/s" for speed in speeds) + " |", "|---|---|---|---|"]
    for name in WINDS:
        flown = [fly(name, speed) for speed in speeds]
        cells = [f"{f.drag:.3f}, {round(f.hang)}°, {f.sway:.2f}, {f.beat:.2f}, {f.rough:.1f}°" for f in flown]
        rows.append(f"| {name} | " + " | ".join(cells) + " |")
        print(rows[-1], flush=True)
    head, rest = PAGE.read_text().split(BEGIN)
    PAGE.write_text(head + BEGIN + "\n".join(rows) + "\n" + END + rest.split(END)[1])
    picture()


if __name__ == "__main__":
    main()
