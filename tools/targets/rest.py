"""The row about rest: cloth that hangs must hang still, and velocities must be those of its motion."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from taut import Simulation
from taut.bench.trials import Shape, Trial

from tools.targets.record import Motion, rms
from tools.targets.table import Effort, Row

SETTLED = 12.0  # [s], when cloth must be at rest
MOVING = 1.5  # [s] from the start, in which velocities are compared with motion
LIMITS = {"sheet": 2e-5, "garment": 5e-5}  # [m], root mean square of second differences
SINGLE = 5e-4  # [m], of a single vertex in a single frame
SPEED = 5e-3  # [m/s], root mean square of velocities at rest
KINETIC = 0.1  # how far the energy reported may be off that of the motion ..
NEGLIGIBLE = 1e-6  # .. unless both are below this part of mass times gravity times length
IN_MOTION = 10 * SPEED  # [m/s], root mean square: cloth that moves; below, what is left over is no motion
VELOCITIES = 0.05  # how far velocities may be off the motion, relative root mean square
SHAPES: tuple[Shape, ...] = ("grid", "mesh")
SOFT: dict[str, Any] = {"bending": "fabric", "damping": 0.05}
CALMING = 1.5  # [1/s], the air drag of cloth that is to hang: at that of cotton it would swing for a minute
GUST = {"velocity": [0.0, 4.0, 0.0], "gust": {}}
WOKEN = 0.01  # [m], what the centre of mass must move at least in a second after a gust or a moved pin


@dataclass(slots=True)
class Finding:
    """What was found of a case."""

    name: str
    hangs: bool
    """Whether it must have come to rest; else it may swing."""
    garment: bool
    figures: dict[str, float] = field(default_factory=dict)
    limits: dict[str, float] = field(default_factory=dict)

    def add(self, name: str, figure: float, limit: float = np.inf) -> None:
        """A figure, and what it may be."""
        self.figures[name], self.limits[name] = figure, limit

    @property
    def missed(self) -> list[str]:
        """Figures beyond their limit."""
        return [name for name, figure in self.figures.items() if not figure <= self.limits[name]]


def rest(effort: Effort) -> Row:
    """Cloth that hangs, and cloth that swings."""
    found = [_measured(*case, effort) for case in _cases(effort)]
    woken = _wakes(effort)
    hanging = [one for one in found if one.hangs]
    parts = [f"{sum(not one.missed for one in found)} of {len(found)} cases meet all of it"]
    for kind, chosen in (("sheets", False), ("garments", True)):
        worst = {
            name: max(one.figures[name] for one in hanging if one.garment is chosen)
            for name in ("shaking", "single", "speed")
        }
        parts.append(
            f"{kind} that hang: {1e3 * worst['shaking']:.3f} mm, single vertices {1e3 * worst['single']:.2f} "
            f"mm, velocities {1e3 * worst['speed']:.1f} mm/s"
        )
    swinging = [one.figures["trembling"] for one in found if not one.hangs]
    parts.append(f"sheets that swing tremble by {1e3 * max(swinging):.3f} mm")
    moving = max(one.figures["velocities"] for one in found)
    parts.append(f"velocities in motion off by up to {100 * moving:.1f} %")
    parts.append("; ".join(f"{name} moves it by {1e3 * moved:.0f} mm" for name, moved in woken.items()))
    met = not any(one.missed for one in found) and all(moved >= WOKEN for moved in woken.values())
    target = (
        "cloth that has hung for 12 s, second differences from frame to frame: ≤ 0.02 mm root mean square on "
        "a sheet of 1 m, ≤ 0.05 mm on garments, ≤ 0.5 mm for any vertex; velocities < 5 mm/s, kinetic energy "
        "within 10 % of that of the motion; in motion, from 50 mm/s, velocities within 5 % of the centred "
        "differences; gusts and pins wake it"
    )
    return Row(target, "; ".join(parts), met, spread=f"{len(found)} cases, worst", detail=_table(found))


def _cases(effort: Effort) -> Iterator[tuple[str, Trial, bool]]:
    """Name, what, and whether it must come to rest."""
    vertices = effort.vertices(65)
    for scene in ("one-corner", "two-corners"):
        for shape in SHAPES:
            for limit in (0.1, 0.01):
                for cloth in ({}, SOFT):
                    for hangs in (True, False):
                        fields = cloth | ({"air_drag": CALMING} if hangs else {})
                        name = f"{scene}, {shape}, {100 * limit:g} %{', soft' if cloth else ''}"
                        yield name, Trial(scene, vertices, limit, shape, cloth=fields), hangs
    for scene, vertices in (("skirt", 2584), ("shirt", 6400)):
        for cloth in ({}, SOFT):
            trial = Trial(scene, effort.garment(vertices), 0.05, cloth=cloth)
            yield f"{scene}{', soft' if cloth else ''}", trial, True


def _measured(name: str, trial: Trial, hangs: bool, effort: Effort) -> Finding:
    simulation = trial.simulation()
    finding = Finding(name, hangs, trial.scene in ("skirt", "shirt"))
    # Of a shirt on its shoulders little moves, and that is what counts.
    finding.add("velocities", Motion.of(simulation, round(60 * MOVING)).mismatch(IN_MOTION), VELOCITIES)
    if effort.divide == 1:
        simulation.run(round(60 * (SETTLED - MOVING)))
    judge(finding, Motion.of(simulation, 62), trial.extent)
    return finding


def judge(finding: Finding, motion: Motion, extent: float) -> None:
    """Adds what a second of a motion says about rest."""
    shaking, trembling = motion.shaking(), motion.trembling()
    limit = LIMITS["garment" if finding.garment else "sheet"]
    quiet = limit, SINGLE, SPEED
    free = np.inf, np.inf, np.inf
    at_rest, swinging = (quiet, free) if finding.hangs else (free, quiet)
    finding.add("shaking", rms(shaking), at_rest[0])
    finding.add("single", float(shaking.max()), at_rest[1])
    finding.add("trembling", rms(trembling), swinging[0])
    finding.add("single trembling", float(trembling.max()), swinging[1])
    finding.add("speed", rms(np.linalg.norm(motion.velocities, axis=2)), at_rest[2])
    if not finding.hangs:
        finding.add("velocities later", motion.mismatch(IN_MOTION), VELOCITIES)
    said, moved = float(motion.kinetic[1:-1].mean()), float(motion.kinetic_of_motion().mean())
    negligible = NEGLIGIBLE * float(motion.mass.sum()) * 9.81 * extent
    off = 0.0 if max(said, moved) < negligible else abs(said / moved - 1) if moved > 0 else np.inf
    finding.add("kinetic energy", off, KINETIC)


def _wakes(effort: Effort) -> dict[str, float]:
    """How far the centre of mass of a sheet moves within a second [m] of what wakes it from rest."""
    trial = Trial("two-corners", effort.vertices(33), 0.1, cloth={"air_drag": CALMING} | SOFT)
    simulation = trial.simulation()
    simulation.run(round(60 * SETTLED) if effort.divide == 1 else 60)
    blown = replace(trial, document={"wind": GUST}).simulation()
    blown.set_state(simulation.positions, simulation.velocities, simulation.steps)
    found = {"a gust": _moved(blown)}
    for group in range(len(simulation.pin_groups)):
        simulation.shift_pins(group, [0.0, 0.0, 0.05], 0.2)
    return found | {"pins that rise by 50 mm": _moved(simulation)}


def _moved(simulation: Simulation) -> float:
    centre = Motion.of(simulation, 60).centre()
    return float(np.linalg.norm(centre - centre[0], axis=1).max())


def _table(found: list[Finding]) -> str:
    """All figures of all cases; those that miss their limit in bold."""
    columns = {
        "velocities": ("velocities in motion [%]", 100),
        "shaking": ("second differences [mm]", 1e3),
        "single": ("of one vertex [mm]", 1e3),
        "trembling": ("trembling [mm]", 1e3),
        "single trembling": ("of one vertex [mm]", 1e3),
        "speed": ("velocities [mm/s]", 1e3),
        "kinetic energy": ("kinetic energy off [%]", 100),
        "velocities later": ("velocities of the swing [%]", 100),
    }
    lines = ["| cloth | it | " + " | ".join(head for head, _ in columns.values()) + " |"]
    lines.append("|---|---|" + "---|" * len(columns))
    for one in found:
        cells = []
        for name, (_, factor) in columns.items():
            text = f"{factor * one.figures[name]:.3g}" if name in one.figures else "–"
            cells.append(f"**{text}**" if name in one.missed else text)
        lines.append(f"| {one.name} | {'hangs' if one.hangs else 'swings'} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"
