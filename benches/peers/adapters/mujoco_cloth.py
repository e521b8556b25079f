"""MuJoCo's 2D flex with its elasticity integrated implicitly.

settings: steps (a frame), young [Pa] at a thickness of 1 mm. MuJoCo spreads the mass evenly over vertices.
"""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness import FPS, GRAVITY, Job, serve

MODEL = """
<mujoco>
  <option timestep="{step:.12g}" gravity="0 0 -{gravity}" integrator="discrete"
          solver="CG" iterations="20" ls_iterations="10" tolerance="1e-6" jacobian="sparse">
    <flag contact="disable"/>
  </option>
  <size memory="8G"/>
  <worldbody>
    <flexcomp name="sheet" type="direct" dim="2" radius="0.001" mass="{mass}" point="{points}"
              element="{triangles}">
      <contact contype="0" conaffinity="0" selfcollide="none"/>
      <edge damping="0"/>
      <elasticity young="{young}" poisson="0" thickness="1e-3" damping="0" elastic2d="stretch"/>
      <pin id="{pins}"/>
    </flexcomp>
  </worldbody>
</mujoco>
"""


class Flex:
    """The sheet as a flex."""

    def __init__(self, job: Job) -> None:
        """Compile the model."""
        self._steps = int(job.settings["steps"])
        text = MODEL.format(
            step=1 / (FPS * self._steps),
            gravity=GRAVITY,
            mass=job.masses.sum(),
            points=_numbers(job.positions),
            triangles=_numbers(job.triangles),
            young=job.settings["young"],
            pins=_numbers(job.pins),
        )
        self._model = mujoco.MjModel.from_xml_string(text)
        self._data = mujoco.MjData(self._model)

    def frame(self) -> None:
        """Advance by 1/60 s."""
        mujoco.mj_step(self._model, self._data, self._steps)

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        return np.array(self._data.flexvert_xpos)


def _numbers(values: ArrayLike) -> str:
    return " ".join(f"{value:.9g}" for value in np.asarray(values).ravel())


if __name__ == "__main__":
    serve(Flex)
