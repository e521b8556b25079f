"""MuJoCo's 2D flex among bodies, with native contacts or with its `ipc` mode, its elasticity implicit.

settings: mode ("ipc" or "native"), steps (a frame), young [Pa] at a thickness of 1 mm, iterations of the
solver. MuJoCo spreads the mass evenly over vertices.
"""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness import FPS, GRAVITY, Job, serve

MODEL = """
<mujoco>
  <option timestep="{step:.12g}" gravity="0 0 -{gravity}" integrator="discrete"
          solver="CG" iterations="{iterations}" ls_iterations="10" tolerance="1e-6" jacobian="sparse">
    <flag {flags}/>
  </option>
  <size memory="4G"/>
  <worldbody>
    {bodies}
    <flexcomp name="sheet" type="direct" dim="2" radius="{radius}" mass="{mass}" point="{points}"
              element="{triangles}">
      <contact selfcollide="auto" friction="{friction} 0.005 0.0001"/>
      <edge damping="0"/>
      <elasticity young="{young}" poisson="0" thickness="1e-3" damping="0" elastic2d="stretch"/>
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
            iterations=int(job.settings["iterations"]),
            flags='ipc="enable"' if job.settings["mode"] == "ipc" else 'contact="enable"',
            bodies="\n".join(_geom(body, job.friction) for body in job.bodies),
            radius=job.thickness / 2,
            mass=job.masses.sum(),
            points=_numbers(job.positions),
            triangles=_numbers(job.triangles),
            friction=job.friction,
            young=job.settings["young"],
        )
        self._model = mujoco.MjModel.from_xml_string(text)
        self._data = mujoco.MjData(self._model)

    def frame(self) -> None:
        """Advance by 1/60 s."""
        mujoco.mj_step(self._model, self._data, self._steps)

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (particles, 3)."""
        return np.array(self._data.flexvert_xpos)


def _geom(body: dict[str, Any], friction: float) -> str:
    common = f'friction="{friction} 0.005 0.0001"'
    if body["kind"] == "floor":
        return f'<geom type="plane" size="5 5 0.1" pos="0 0 {body["height"]}" {common}/>'
    place = f'pos="{_numbers(body["centre"])}"'
    if body["kind"] == "ball":
        return f'<geom type="sphere" size="{body["radius"]}" {place} {common}/>'
    turned = f'quat="{_numbers(body["quaternion"])}"'
    return f'<geom type="box" size="{_numbers(body["half"])}" {place} {turned} {common}/>'


def _numbers(values: ArrayLike) -> str:
    return " ".join(f"{value:.9g}" for value in np.asarray(values).ravel())


if __name__ == "__main__":
    serve(Flex)
