"""Bodies that wear garments: one of capsules that walks, and one of a closed mesh that shuts an arm."""

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.bench.meshes import Faces, Vertices

Arms = Literal["spread", "hanging", "none"]
Path = NDArray[np.float64]
"""Places in every frame [m], shape (frames, vertices, 3)."""

WAIST = 1.0
"""Height of the waist of a `walker` [m]: that of a `skirt` without its own."""
SHOULDER = 1.4
"""Height of its shoulders [m]."""
HIP, STRIDE = 0.92, 25.0  # height of the hips [m], and how far legs and arms swing [degrees]
PACE = 1.0  # double steps [1/s]
SPEED = 1.2  # of walking [m/s]
RATE = 60  # keyframes [1/s]
STAND, START = 0.5, 0.5  # it stands, then sets off [s]

ARM = ((0.19, 0.0, 0.55), (0.43, 0.0, 0.43), 0.04)
"""Ends and radius of an arm in a `shirt`, whose hem is at the origin [m]."""


def walker(seconds: float, arms: Arms = "none") -> list[dict[str, Any]]:
    """Make a figure that stands for a moment and walks towards -y, its feet near z = 0.

    Args:
        seconds: how long it walks; the time at which it stands still again [s].
        arms: `spread` for a shirt, `hanging` for a cape.

    Returns:
        Bodies of a scene; they overlap where they are joined.
    """
    time = np.arange(round(seconds * RATE) + 1) / RATE
    path = walk(seconds)
    swing = STRIDE * gait(time) * np.sin(2 * np.pi * PACE * (time - STAND))

    def limb(name: str, start: ArrayLike, end: ArrayLike, radius: float, angle: Any = None) -> dict[str, Any]:
        capsule = {
            "from": np.asarray(start).tolist(),
            "to": np.asarray(end).tolist(),
            "radius": radius,
        }
        body: dict[str, Any] = {"name": name, "capsule": capsule, "move": path}
        if angle is not None:
            axis = [0, 0, 1] if name.startswith("spread") else [1, 0, 0]
            keys = [list(key) for key in zip(time[1:].tolist(), angle[1:].tolist(), strict=True)]
            body["turn"] = {"axis": axis, "point": np.asarray(start).tolist(), "angle": keys}
        return body

    bodies = [limb("neck", [0, 0, SHOULDER], [0, 0, SHOULDER + 0.25], 0.045)]
    bodies.append(limb("shoulders", [-0.15, 0, SHOULDER], [0.15, 0, SHOULDER], 0.05))
    for side, name in ((-1, "left"), (1, "right")):
        bodies.append(limb(f"torso-{name}", [0.035 * side, 0, 0.97], [0.035 * side, 0, 1.36], 0.07))
        foot = [0.08 * side, 0, 0.1]
        bodies.append(limb(f"leg-{name}", [0.06 * side, 0, HIP], foot, 0.055, side * swing))
        if arms == "spread":
            (x, y, z), (end_x, end_y, end_z), radius = ARM
            low = SHOULDER - z
            bodies.append(
                limb(
                    f"spread-{name}",
                    [x * side, y, z + low],
                    [end_x * side, end_y, end_z + low],
                    radius,
                    swing,
                )
            )
        elif arms == "hanging":
            start, end = [0.15 * side, 0, SHOULDER - 0.04], [0.2 * side, 0, 0.9]
            bodies.append(limb(f"arm-{name}", start, end, 0.04, -side * swing))
    return bodies


def walk(seconds: float) -> list[list[Any]]:
    """Keyframes of the way of a `walker`, for what is pinned to it.

    Args:
        seconds: as there [s].
    """
    time = np.arange(round(seconds * RATE) + 1) / RATE
    speed = gait(time)
    forward = SPEED * np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2)]) / RATE
    # It is lowest where the legs are furthest apart.
    sunk = 0.02 * speed * (np.cos(4 * np.pi * PACE * (time - STAND)) - 1) / 2
    places = np.column_stack([np.zeros(len(time)), -forward, sunk])
    return [list(key) for key in zip(time[1:].tolist(), places[1:].tolist(), strict=True)]


def gait(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """How fast a `walker` goes, from 0 to 1."""
    part = np.clip((time - STAND) / START, 0, 1)
    return np.asarray(part * part * (3 - 2 * part))


def squeezer(seconds: float, rate: float = 60.0, gap: float = 0.006) -> tuple[Vertices, Faces, Path]:
    """Make a torso with two arms for a `shirt`, one surface, and the motion that shuts one of the arms.

    The arm begins to turn after a quarter of the time, is shut from half to three quarters, and opens again.

    Args:
        seconds: how long the motion takes [s].
        rate: frames of it a second [1/s].
        gap: what is left between torso and arm [m].

    Returns:
        Vertices and faces, about 10,000 triangles, turned outwards; and the places of the vertices.
    """
    torso, torso_faces = closed(_torso())
    right, arm_faces = closed(_rod(*ARM))
    left = right * [-1.0, 1.0, 1.0]
    first, second = len(torso), len(torso) + len(right)
    faces = np.concatenate([torso_faces, arm_faces + first, arm_faces[:, ::-1] + second])
    time = np.linspace(0, 1, round(seconds * rate) + 1)
    part = np.interp(time, [0.25, 0.5, 0.75, 1.0], [0.0, 1.0, 1.0, 0.0])
    part = part * part * (3 - 2 * part)
    # It turns until it is upright; where the shoulder goes meanwhile sets what is left between.
    shoulder = np.array(ARM[0])
    widest = float(torso[torso[:, 2] < shoulder[2], 0].max())
    aside = widest + ARM[2] + gap - shoulder[0]
    frames = []
    for one in part:
        angle = np.radians(_upright() * one)
        turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        moved = shoulder + (right - shoulder) @ turn.T + [aside * one, 0, 0]
        frames.append(np.concatenate([torso, moved, left]))
    return np.concatenate([torso, right, left]), faces, np.array(frames)


def closed(rings: Path) -> tuple[Vertices, Faces]:
    """Make a closed surface of rings, each of as many points, counter-clockwise seen from the last one.

    Args:
        rings: places [m], shape (rings, points, 3); both ends are closed by a point in their middle.

    Returns:
        Vertices and faces, turned outwards.
    """
    count, around = rings.shape[:2]
    places = np.concatenate([rings.reshape(-1, 3), rings[[0, -1]].mean(axis=1)])
    number = np.arange(count * around).reshape(count, around)
    ahead = np.roll(number, -1, axis=1)
    a, b, c, d = number[:-1], ahead[:-1], ahead[1:], number[1:]
    start, end = np.full(around, count * around), np.full(around, count * around + 1)
    faces = [
        np.stack([a, b, c], axis=-1).reshape(-1, 3),
        np.stack([a, c, d], axis=-1).reshape(-1, 3),
        np.stack([start, ahead[0], number[0]], axis=-1),
        np.stack([end, number[-1], ahead[-1]], axis=-1),
    ]
    return places, np.concatenate(faces)


def _upright() -> float:
    """How far an arm turns until it hangs upright [degrees]."""
    way = np.subtract(ARM[1], ARM[0])
    return float(np.degrees(np.arctan2(way[0], -way[2])))


def _torso(around: int = 64, count: int = 48) -> Path:
    """Rings of a torso, elliptical, closed smoothly at both ends."""
    part = np.linspace(0, np.pi, count + 2)[1:-1]
    height = 0.32 - 0.29 * np.cos(part)
    round_off = np.sin(part) ** 0.4
    angle = np.arange(around) * 2 * np.pi / around
    width, depth = 0.13 * round_off, 0.075 * round_off
    return np.stack(
        [
            width[:, None] * np.cos(angle),
            depth[:, None] * np.sin(angle),
            np.broadcast_to(height[:, None], (count, around)),
        ],
        axis=-1,
    )


def _rod(start: ArrayLike, end: ArrayLike, radius: float, around: int = 32, count: int = 32) -> Path:
    """Rings of a rod with round ends; the line between them lies in the plane y = 0."""
    start, end = np.asarray(start, np.float64), np.asarray(end, np.float64)
    along = (end - start) / np.linalg.norm(end - start)
    quarter = np.linspace(0, np.pi / 2, 9)[1:]
    cap, straight = radius * np.stack([np.cos(quarter), np.sin(quarter)]), np.zeros(count - 16)
    depth = np.concatenate([-cap[0], straight, cap[0, ::-1]])
    size = np.concatenate([cap[1], straight + radius, cap[1, ::-1]])
    between = np.concatenate([np.zeros(8), np.linspace(0, 1, count - 14)[1:-1], np.ones(8)])
    angle = np.arange(around) * 2 * np.pi / around
    across = np.array([0.0, 1.0, 0.0])
    side = np.cross(across, along)
    ring = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * across
    middle = start + between[:, None] * (end - start) + depth[:, None] * along
    # side x across = along turned back: the other way round would face inwards.
    ring = ring if np.cross(side, across) @ along > 0 else ring[::-1]
    return np.asarray(middle[:, None] + size[:, None, None] * ring)
