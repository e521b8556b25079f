"""Write the shipped scene `skirt-walk` and its mesh: a figure of capsules walks in a skirt.

The skirt is half a circle of cloth, closed to a cone round the z axis, its waist at z = 0. Rings have as many
vertices as fit at even distances, and each is turned against the last, so that it is no grid.

The figure walks towards -x at an even height. Its feet stand still on the floor while they bear it: where the
knees have to be follows from hips and ankles. Only these keyframes are why the scene is written by a script.

Metres, seconds, degrees. The result is the same, byte for byte, every time.
"""

import argparse
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

SCENES = Path(__file__).resolve().parent.parent / "python/taut/scenes"

WAIST_RADIUS = 0.125
LENGTH, SLOPE = 0.56, 0.5
"""From waist to hem along the cloth; distance from the axis for each metre of it."""
SPACING = 0.024

HIP, ANKLE = 0.895, 0.055
"""Heights of joints."""
THIGH, SHIN = 0.43, 0.43
APART = 0.085
"""How far a leg is from the middle."""
STEP, STEPS, LIFT, ROLL = 0.46, 5, 0.07, 0.025
"""Length and number of steps, how high a foot is lifted, and how much its ankle rises before that."""
SPEED, START, GATHER = 1.0, 0.5, 0.6
"""Of walking, when it begins, and how long it takes to reach the speed and to stop."""
KEY = 0.05
"""Time between keyframes of legs; between those of arms twice as much."""
SWAY = 22.0
"""How far arms swing."""
WIDTH = 118
"""Longest line of keyframes."""

Array = NDArray[np.float64]


def skirt() -> tuple[Array, NDArray[np.int64]]:
    """Vertices and triangles, turned outwards."""
    rows = round(LENGTH / (SPACING * np.sqrt(0.75))) + 1
    along = np.linspace(0, LENGTH, rows)
    radius = WAIST_RADIUS + SLOPE * along
    counts = np.round(2 * np.pi * radius / SPACING).astype(int)
    angles = [2 * np.pi * (np.arange(n) + 0.5 * (row % 2)) / n for row, n in enumerate(counts)]
    places = [
        np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full_like(angle, -down)])
        for r, angle, down in zip(radius, angles, along * np.sqrt(1 - SLOPE**2), strict=True)
    ]
    first = np.concatenate([[0], np.cumsum(counts)])
    faces = [
        strip(angles[row], angles[row + 1], first[row], first[row + 1]) for row in range(len(counts) - 1)
    ]
    return np.concatenate(places), np.concatenate(faces)


def strip(upper: Array, lower: Array, first_up: int, first_low: int) -> NDArray[np.int64]:
    """Triangles between two rings: whichever ring has the nearer next vertex goes on."""
    faces, i, j = [], 0, 0
    while i < len(upper) or j < len(lower):
        next_up = upper[i + 1] if i + 1 < len(upper) else upper[0] + 2 * np.pi
        next_low = lower[j + 1] if j + 1 < len(lower) else lower[0] + 2 * np.pi
        a, b = first_up + i % len(upper), first_low + j % len(lower)
        if j == len(lower) or (i < len(upper) and next_up < next_low):
            i += 1
            faces.append([a, b, first_up + i % len(upper)])
        else:
            j += 1
            faces.append([a, b, first_low + j % len(lower)])
    return np.array(faces)


def walked(time: Array) -> Array:
    """How far the hips have come: as long as it takes to gather speed they go half as fast."""
    end = START + GATHER + STEPS * STEP / SPEED
    rise = np.clip((time - START) / GATHER, 0, 1)
    fall = np.clip((time - end + GATHER) / GATHER, 0, 1)
    full = np.clip(time, START + GATHER, end - GATHER) - START - GATHER
    return np.asarray(SPEED * (full + GATHER * (eased(rise) + fall - eased(fall))))


def eased(part: Array) -> Array:
    """The way so far where speed grows smoothly from 0 to 1 in the time from 0 to 1."""
    return np.asarray(part**3 - part**4 / 2)


def ankle(way: float, side: int) -> tuple[float, float]:
    """Where an ankle is ahead of where it began, and above the floor, when the hips have come so far.

    Feet stand on multiples of the step, and each bears the hips from half a step before it to half a step
    behind. The others swing forward meanwhile. The first and the last step are half ones.
    """
    number = min(int(np.floor(way / STEP + 0.5)), STEPS)
    if number % 2 == (side > 0):
        aside = abs(way / STEP - number) * 2
        return number * STEP, ANKLE + ROLL * aside**3
    first, last = max(0.0, (number - 0.5) * STEP), min(STEPS * STEP, (number + 0.5) * STEP)
    part = np.clip((way - first) / (last - first), 0, 1)
    start, end = max(0, number - 1) * STEP, min(STEPS, number + 1) * STEP
    smooth = part**2 * (3 - 2 * part)
    roll = ROLL * ((number > 0) * (1 - smooth) + (number < STEPS) * smooth)
    return float(start + (end - start) * smooth), float(ANKLE + roll + LIFT * np.sin(np.pi * part) ** 2)


def leg(way: Array, side: int) -> tuple[Array, Array, Array]:
    """Angles of thigh and shin, forward, and where the knee is, ahead of the start and above the floor."""
    found = []
    for one in way.tolist():
        foot, height = ankle(one, side)
        ahead, down = foot - one, HIP - height
        far = np.hypot(ahead, down)
        bend = np.arccos(np.clip((THIGH**2 + far**2 - SHIN**2) / (2 * THIGH * far), -1, 1))
        thigh = np.arctan2(ahead, down) + bend
        x, z = THIGH * np.sin(thigh), THIGH * np.cos(thigh)
        found.append([thigh, np.arctan2(ahead - x, down - z), one + x, HIP - z])
    thigh, shin, *knee = np.array(found).T
    return np.degrees(thigh), np.degrees(shin), np.column_stack(knee)


def angles(time: Array, values: Array) -> str:
    """Keyframes of a turn."""
    return wrapped(f"[{t:.4g}, {number(angle, 1)}]" for t, angle in zip(time, values, strict=True))


def moves(time: Array, places: Array) -> str:
    """Keyframes of a displacement, from ways ahead and up."""
    return wrapped(
        f"[{t:.4g}, [{number(-x, 3)}, 0, {number(z, 3)}]]" for t, (x, z) in zip(time, places, strict=True)
    )


def point(ahead: float, side: float, height: float) -> str:
    """A point."""
    return f"[{number(-ahead, 3)}, {number(side, 3)}, {number(height, 3)}]"


def number(value: float, digits: int) -> str:
    """Rounded, and never -0."""
    return f"{round(float(value), digits) + 0.0:g}"


def wrapped(keys: Iterable[str]) -> str:
    """As an array over several lines."""
    lines = [""]
    for key in keys:
        if len(lines[-1]) + len(key) + 2 > WIDTH:
            lines.append("")
        lines[-1] += f" {key}," if lines[-1] else f"{key},"
    return "[\n" + "".join(f"    {line}\n" for line in lines) + "]"


def limb(name: str, start: str, end: str, radius: float, **motion: str) -> str:
    """A body."""
    lines = [f'[[body]]\nname = "{name}"', f"capsule = {{ from = {start}, to = {end}, radius = {radius} }}"]
    if "angle" in motion:
        lines.append(f"turn.axis = [0, 1, 0]\nturn.point = {start}\nturn.angle = {motion['angle']}")
    lines.append(f"move = {motion['move']}")
    return "\n".join(lines) + "\n"


def scene() -> str:
    """The text of the scene."""
    end = START + GATHER + STEPS * STEP / SPEED
    gather = GATHER * np.array([0.25, 0.5, 0.75, 1.0])
    time = np.concatenate([[START], START + gather, end - gather[::-1], [end]])
    way = walked(time)
    trunk = moves(time, np.column_stack([way, np.zeros_like(way)]))
    bodies = [
        TRUNK + limb("hips", point(0, -0.05, 0.93), point(0, 0.05, 0.93), 0.085, move=trunk),
        limb("trunk", point(0, 0, 1.0), point(0, 0, 1.31), 0.105, move=trunk),
        limb("head", point(0, 0, 1.51), point(0, 0, 1.55), 0.08, move=trunk),
        LIMBS,
    ]
    for side, name in ((-1, "left"), (1, "right")):
        bodies += limbs(side, name, trunk, np.arange(START, end + KEY, KEY))
    return HEAD + "\n".join(bodies) + TAIL.replace("MOVE", trunk)


def limbs(side: int, name: str, trunk: str, time: Array) -> list[str]:
    """Arm, thigh and shin of a side: as the figure stands, and keyframes of what differs from that."""
    way, y = walked(time), APART * side
    thigh, shin, knee = leg(way, side)
    hip, joint, foot = point(0, y, HIP), point(knee[0, 0], y, knee[0, 1]), point(0, y, ANKLE)
    shoulder, hand = point(0, 0.16 * side, 1.36), point(0, 0.25 * side, 0.88)
    sway = -side * SWAY * np.gradient(way, time) / SPEED * np.sin(np.pi * way / STEP)
    slow = slice(None, None, 2)
    return [
        limb(f"arm-{name}", shoulder, hand, 0.04, move=trunk, angle=angles(time[slow], sway[slow])),
        limb(f"thigh-{name}", hip, joint, 0.065, move=trunk, angle=angles(time, thigh - thigh[0])),
        limb(
            f"shin-{name}",
            joint,
            foot,
            0.05,
            move=moves(time, knee - knee[0]),
            angle=angles(time, shin - shin[0]),
        ),
    ]


HEAD = """\
# A figure of capsules walks and stops; its skirt hangs from the waist, swings and folds over the legs.
title = "Skirt on a figure that walks"
duration = 4.5                          # [s]

[[body]]
name = "floor"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }

"""

TRUNK = "# Hips, trunk and head go along, at an even height.\n"
LIMBS = "# Keyframes of arms and legs, made by tools/make_skirt_walk.py: feet stand still while they bear.\n"
TAIL = """
# The waist is pinned, and goes with the trunk.
[[cloth]]
name = "skirt"
mesh = "meshes/skirt.obj"
translate = [0, 0, 1.0]                 # [m]
fabric = "cotton"
bending = "fabric"
thickness = 0.003                       # [m]
friction = 0.3

[[cloth.pins]]
box = [[-0.2, -0.2, 0.999], [0.2, 0.2, 1.001]]
move = MOVE
"""


def main() -> None:
    """Write scene and mesh, into the folder that the command line names."""
    parser = argparse.ArgumentParser(description="Write the scene skirt-walk and its mesh.")
    parser.add_argument("--out", type=Path, default=SCENES)
    out: Path = parser.parse_args().out
    places, faces = skirt()
    lines = [f"# a skirt: {len(places)} vertices, {len(faces)} triangles\n"]
    lines += [f"v {x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in places.round(5) + 0.0]
    lines += [f"f {a} {b} {c}\n" for a, b, c in faces + 1]
    (out / "meshes").mkdir(exist_ok=True)
    (out / "meshes" / "skirt.obj").write_text("".join(lines), encoding="ascii", newline="\n")
    (out / "skirt-walk.toml").write_text(scene(), encoding="ascii", newline="\n")


if __name__ == "__main__":
    main()
