"""A strip of stills: a row for each simulation, a column for each moment."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taut.bodies import Body
from taut.frames import Frames, bodies_of
from taut.render.options import RenderError, RenderOptions
from taut.render.rendering import render_still


def render_strip(
    rows: Sequence[Frames], times: Sequence[float], out: str | Path, options: RenderOptions | None = None
) -> None:
    """Render one or more simulations at several moments, in one picture with one camera and one scale.

    Args:
        rows: the simulations, each with a frame or more; each gets a row.
        times: the moments [s]; each gets a column. A simulation that ended before shows its last frame.
        out: the picture to make, see :func:`taut.render.render_still`.
        options: how it looks; `columns` and `frame` are chosen here.

    Raises:
        RenderError: see :func:`taut.render.render_still`; also where there are no times.
    """
    if not times:
        raise RenderError("there is nothing to render: name a moment or more")
    panels = [_Moment.of(row, time) for row in rows for time in times]
    render_still(panels, out, replace(options or RenderOptions(), columns=len(times), frame=None))


@dataclass(frozen=True)
class _Moment:
    """One frame of a simulation, as a simulation of one frame."""

    whole: Frames
    shown: int

    @classmethod
    def of(cls, whole: Frames, time: float) -> "_Moment":
        return cls(whole, int(np.argmin(np.abs(whole.time - time))) if whole.frames else 0)

    @property
    def frames(self) -> int:
        return min(1, self.whole.frames)

    @property
    def title(self) -> str:
        return self.whole.title

    @property
    def time(self) -> NDArray[np.float64]:
        return self.whole.time[self.shown : self.shown + 1]

    @property
    def faces(self) -> NDArray[np.int32]:
        return self.whole.faces

    @property
    def springs(self) -> NDArray[np.int32]:
        return self.whole.springs

    @property
    def rest_length(self) -> NDArray[np.float32]:
        return self.whole.rest_length

    @property
    def strain_limit(self) -> NDArray[np.float32]:
        return self.whole.strain_limit

    @property
    def scene(self) -> Mapping[str, Any]:
        return self.whole.scene

    @property
    def pins(self) -> NDArray[np.int32]:
        pins: NDArray[np.int32] = np.asarray(getattr(self.whole, "pins", ()), dtype=np.int32)
        return pins

    def positions(self, _frame: int) -> NDArray[np.float32]:
        return self.whole.positions(self.shown)

    def velocities(self, _frame: int) -> NDArray[np.float32]:
        return self.whole.velocities(self.shown)

    def bodies(self, _frame: int) -> Mapping[str, Body]:
        return {body.name: body for body in bodies_of(self.whole, self.shown)}

    def stretch(self, _frame: int) -> NDArray[np.float32]:
        return self.whole.stretch(self.shown)
