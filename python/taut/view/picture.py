"""What a page draws: the topology once, then pictures, each with the numbers that belong to it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.bodies import Body
from taut.view.solids import Solids
from taut.view.wire import finite, pack

_TYPE2 = 2
"""Kind of the springs that no limit holds."""


@dataclass(frozen=True)
class Mesh:
    """What does not change of a cloth that is shown."""

    rest: NDArray[np.float32]
    """Positions at the start [m], shape (vertices, 3)."""
    faces: NDArray[np.int32]
    springs: NDArray[np.int32]
    spring_kind: NDArray[np.uint8]
    rest_length: NDArray[np.float32]
    pins: Sequence[NDArray[np.int32]]
    """Vertices of each pin group."""
    first_vertices: Sequence[int]
    """Of each cloth."""
    solids: Solids
    """The bodies beside it."""
    bodies: Mapping[str, Body]
    """Where they are at the start."""
    ball_faces: NDArray[np.int32]
    """Triangles of the ball that can be thrown, if any, shape (faces, 3)."""


def pack_layout(meshes: Sequence[Mesh], scene: Mapping[str, Any], live: bool) -> bytes:
    """The message with which a page begins.

    Args:
        meshes: what is shown side by side; a single one stands for several panels with the same topology.
        scene: the resolved scene, for the axis that points up.
        live: whether it runs, or is a recording.
    """
    arrays: dict[str, NDArray[Any]] = {}
    described = []
    for index, mesh in enumerate(meshes):
        limited = mesh.spring_kind != _TYPE2
        arrays[f"rest{index}"] = mesh.rest
        arrays[f"faces{index}"] = mesh.faces
        arrays[f"springs{index}"] = mesh.springs[limited]
        arrays[f"lengths{index}"] = mesh.rest_length[limited]
        arrays[f"solid_faces{index}"] = mesh.solids.faces
        arrays[f"square_faces{index}"] = mesh.solids.square_faces
        arrays[f"ball_faces{index}"] = mesh.ball_faces
        arrays |= mesh.solids.arrays(mesh.bodies, index)
        pins = [group.tolist() for group in mesh.pins if len(group)]
        described.append(
            {
                "pins": pins,
                "first_vertices": list(mesh.first_vertices),
                "floor": mesh.solids.floor,
                "parts": mesh.solids.parts,
                "square_parts": mesh.solids.square_parts,
            }
        )
    header = {"type": "layout", "live": live, "up": up_of(scene), "meshes": described}
    return pack(header, arrays)


def up_of(scene: Mapping[str, Any]) -> int:
    """Index of the axis that points up in a resolved scene: 2 (z) or 1 (y)."""
    return 1 if scene.get("up") == "y" else 2


@dataclass(frozen=True)
class Panel:
    """A cloth in a picture, and its numbers."""

    mesh: int
    """Which mesh of the layout it is."""
    name: str
    positions: NDArray[np.float32]
    """[m], shape (vertices, 3)."""
    limits: Sequence[float]
    """Largest stretch allowed in each cloth [1]."""
    limited: bool
    """Whether a filter keeps them."""
    worst: float
    """Largest stretch [1]."""
    energies: Sequence[float]
    """Kinetic, elastic, potential [J]."""
    ms: float
    """Cost of a frame [ms]."""
    solids: Solids
    """The bodies beside it."""
    bodies: Mapping[str, Body] | None
    """Where they are; nothing where they are as they were at the start."""
    contacts: float
    """Pairs that were near, in a step [1]."""
    closest: float
    """Least distance between what touches [m]; infinite where nothing was near."""
    ball: NDArray[np.float32] | None = None
    """Corners of the triangles of a ball that was thrown [m], shape (points, 3)."""
    touches: NDArray[np.float32] | None = None
    """Where cloth touches something [m], and how hard it is pushed there [N], shape (n, 4)."""

    def describe(self) -> dict[str, Any]:
        """Its numbers as JSON values."""
        return {
            "mesh": self.mesh,
            "name": self.name,
            "limits": [finite(limit) for limit in self.limits],
            "limited": self.limited,
            "worst": finite(self.worst),
            "energies": [finite(energy) for energy in self.energies],
            "ms": finite(self.ms),
            "contacts": finite(self.contacts),
            "closest": finite(self.closest),
        }


def pack_picture(number: int, header: Mapping[str, Any], panels: Sequence[Panel]) -> bytes:
    """A picture.

    Args:
        number: by which the page says that it has drawn it.
        header: time [s], frame, wind [m/s] and the like.
        panels: what is shown side by side.
    """
    described = [panel.describe() for panel in panels]
    arrays = {f"positions{index}": panel.positions for index, panel in enumerate(panels)}
    for index, panel in enumerate(panels):
        if panel.bodies is not None:
            arrays |= panel.solids.arrays(panel.bodies, index)
        if panel.ball is not None:
            arrays[f"ball{index}"] = panel.ball
        if panel.touches is not None:
            arrays[f"touches{index}"] = panel.touches
    return pack({"type": "picture", "number": number, **header, "panels": described}, arrays)
