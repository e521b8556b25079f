"""Bodies as Wavefront OBJ, beside the frames of the cloth."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.bodies import Body, Skin, quad_of
from taut.frames import Frames, bodies_of

_REACH = 1.5
"""Half the side of the square that stands for a plane, in diagonals of the cloth."""


class BodyFiles:
    """Writes ``bodies.obj`` once if no body ever moves, otherwise ``bodies_0000.obj`` .. with each frame.

    Each body is an object of its name. Surfaces keep their vertices and triangles in their order; spheres and
    capsules become triangles, and planes a square round the cloth.
    """

    def __init__(self, frames: Frames) -> None:
        """Look at the bodies at the start."""
        self._frames = frames
        first = bodies_of(frames, 0) if frames.frames else []
        self._moves = any(body.moves for body in first)
        rest = frames.positions(0) if first else np.zeros((1, 3))
        low, high = rest.min(axis=0), rest.max(axis=0)
        self._middle, self._reach = (low + high) / 2, _REACH * max(float(np.linalg.norm(high - low)), 0.1)
        self._skins = {body.name: Skin(body) for body in first if body.shape in ("sphere", "capsule")}
        self._is_empty = not first

    def write(self, stem: Path, frame: int) -> None:
        """Write those of a frame, if there is something to write.

        Args:
            stem: path of the frame's cloth, less its suffix.
            frame: its number.

        Raises:
            OSError: the file cannot be written.
        """
        if self._is_empty or (frame > 0 and not self._moves):
            return
        name = stem.name.replace("frame", "bodies") if self._moves else "bodies"
        parts, first = [], 1
        for body in bodies_of(self._frames, frame):
            points, faces = self._mesh(body)
            parts.append(f"o {' '.join(body.name.split()) or 'body'}\n")
            parts.append(("v %.9g %.9g %.9g\n" * len(points)) % tuple(points.ravel().tolist()))
            parts += [f"f {' '.join(map(str, row))}\n" for row in (np.asarray(faces) + first).tolist()]
            first += len(points)
        with (stem.parent / f"{name}.obj").open("w", encoding="utf-8", newline="\n") as file:
            file.write("".join(parts))

    def _mesh(self, body: Body) -> tuple[NDArray[np.floating], NDArray[np.int32] | Sequence[list[int]]]:
        if body.shape == "surface":
            return body.positions, body.triangles
        if body.shape == "plane":
            return quad_of(body, self._middle, self._reach), [[0, 1, 2, 3]]
        skin = self._skins[body.name]
        return skin.points(body), skin.faces
