"""The row about grids of any number of cells: scenes of chance, each beside one with powers of two."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from taut import Scene, Simulation
from taut.bench import Runs, Spread, Window

from tools.targets.speed import timed
from tools.targets.table import Effort, Row

SEEDS = range(1, 49)
FRAMES = 90
CELLS = (20, 140)
"""Along a side, drawn by their logarithm."""
HELD = ("one corner", "two corners", "three corners", "four corners", "left edge", "patches")
FACTOR = 2.0
"""What a vertex may cost beside one of the grid with powers of two of cells."""


@dataclass(frozen=True, slots=True)
class Chance:
    """A sheet of chance in a wind of chance."""

    seed: int
    columns: int
    """Cells along x [1]."""
    rows: int
    """Cells along z [1]."""
    size: tuple[float, float]
    """[m]"""
    held: str
    """One of :data:`HELD`."""
    strain_limit: float
    """Lambda [1]."""
    fabric: str
    speed: float
    """Of the wind, without its gusts [m/s]."""

    @classmethod
    def of(cls, seed: int, divide: int = 1) -> "Chance":
        """The scene of a seed."""
        draw = np.random.default_rng(seed)
        columns, rows = (
            int(cells) // divide for cells in np.exp(draw.uniform(np.log(CELLS[0]), np.log(CELLS[1]), 2))
        )
        size = float(draw.uniform(0.5, 3.0))
        # Cells of 1:1.5 to 1.5:1.
        other = size * rows / columns * float(1.5 ** draw.uniform(-1.0, 1.0))
        held, limit = str(draw.choice(HELD)), float(draw.choice([0.01, 0.03, 0.05, 0.1]))
        fabric, speed = str(draw.choice(["nylon", "cotton", "silk"])), float(draw.uniform(0.0, 15.0))
        return cls(seed, max(4, columns), max(4, rows), (size, other), held, limit, fabric, speed)

    def in_powers(self) -> "Chance":
        """The same cloth with the nearest powers of two of cells."""
        columns, rows = (2 ** round(np.log2(cells)) for cells in (self.columns, self.rows))
        return replace(self, columns=columns, rows=rows)

    @property
    def scene(self) -> str:
        """For the tables."""
        return (
            f"{self.columns} x {self.rows} of {self.size[0]:.2g} x {self.size[1]:.2g} m, {self.held}, "
            f"{100 * self.strain_limit:g} %, {self.fabric}, {self.speed:.0f} m/s"
        )

    @property
    def cells(self) -> int:
        """Cells along the shorter side [1]."""
        return min(self.columns, self.rows)

    def simulation(self) -> Simulation:
        """Return the scene at its start."""
        cloth: dict[str, Any] = {
            "grid": {"size": self.size, "cells": (self.columns, self.rows), "axes": ["x", "z"]},
            "fabric": self.fabric,
            "strain_limit": self.strain_limit,
            "pins": self._pins(),
        }
        gust = {"strength": 0.3, "period": 1.3, "seed": self.seed}
        wind = {"velocity": [0.6 * self.speed, 0.8 * self.speed, 0.0], "gust": gust}
        return Simulation(Scene({"wind": wind, "cloth": [cloth]}), 1)

    def _pins(self) -> list[dict[str, Any]]:
        corners = [{"corner": corner} for corner in ("top-left", "top-right", "bottom-left", "bottom-right")]
        if self.held == "left edge":
            return [{"edge": "left"}]
        if self.held == "patches":
            across, first = self.columns + 1, self.rows * (self.columns + 1)
            patch = [first - down * across + along for down in range(3) for along in range(3)]
            ends = [vertex + across - 3 for vertex in patch]
            return [{"vertices": patch}, {"vertices": ends}]
        return corners[: 1 + ("one", "two", "three", "four").index(self.held.split()[0])]


@dataclass(frozen=True, slots=True)
class Pair:
    """A scene, and the same cloth with powers of two of cells, timed in turn."""

    chance: Chance
    runs: tuple[Runs, Runs]

    @classmethod
    def of(cls, chance: Chance, window: Window) -> "Pair":
        """Times both."""
        own, other = timed([chance, chance.in_powers()], window)
        return cls(chance, (own, other))

    @property
    def ratio(self) -> float:
        """Cost of a vertex of one over that of the other [1]."""
        own, other = (runs.ms / runs.row.vertices for runs in self.runs)
        return float(np.median(own / other))

    def cells(self) -> list[str]:
        """Those of the table."""
        ratio = f"{self.ratio:.2f}" if self.ratio <= FACTOR else f"**{self.ratio:.2f}**"
        return [self.chance.scene, ratio, *map(said, self.runs)]


def said(runs: Runs) -> str:
    """A mean frame, the slowest one, and cycles of a step."""
    return f"{np.median(runs.ms):.2f} ({runs.row.ms_worst:.0f}) ms, {runs.cycles.mean():.1f}"


def grids(effort: Effort) -> Row:
    """Cost of a vertex beside that of powers of two, in scenes that nothing was chosen on."""
    window = Window(min(effort.frames, FRAMES), np.inf, effort.runs)
    found = [
        Pair.of(Chance.of(seed, effort.divide), window) for seed in (SEEDS if effort.whole else SEEDS[:2])
    ]
    ratios = [pair.ratio for pair in found]
    worst = max(found, key=lambda pair: pair.ratio)
    held = sum(ratio <= FACTOR for ratio in ratios)
    reached = (
        f"{held} of {len(found)} scenes hold it; worst {worst.ratio:.1f} x: {worst.chance.scene} "
        f"({said(worst.runs[0])}; powers of two {said(worst.runs[1])})"
    )
    target = (
        f"grids of {CELLS[0]} to {CELLS[1]} cells along a side, held at one to four corners, an edge or "
        "patches, wind of up to 15 m/s, λ 1 to 10 %, scenes of chance, first 1.5 s: a vertex costs ≤ 2 x one "
        "of the same cloth with powers of two of cells"
    )
    head = ["scene", "cost of a vertex", "a frame (slowest), cycles a step", "with powers of two"]
    lines = [
        "| " + " | ".join(cells) + " |" for cells in (head, ["---"] * 4, *(pair.cells() for pair in found))
    ]
    spread = f"{Spread.of(ratios).text()} x over the scenes, each the median of {effort.runs}"
    return Row(target, reached, worst.ratio <= FACTOR, "1", spread, "\n".join(lines) + "\n")
