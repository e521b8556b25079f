"""What can be compared: the filters and integrators that the scene's schema names, and the dial of each."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

from taut import _taut
from taut.compare.names import chosen
from taut.scene import Scene


@dataclass(frozen=True, slots=True)
class Method:
    """A filter and an integrator."""

    filter: str
    """`solver.filter`."""
    integrator: str
    """`solver.integrator`."""

    def usual(self, scene: Scene) -> Scene:
        """The scene with this method as its author uses it: every other field of the solver at its default.

        Raises:
            SceneError: the method refuses the scene.
        """
        fields = f'filter = "{self.filter}", integrator = "{self.integrator}"'
        return scene.with_settings([f"solver={{ {fields} }}"])


@cache
def known(kind: Literal["FilterKind", "IntegratorKind"]) -> tuple[str, ...]:
    """The names that a scene allows, in the order of its schema."""
    choices = json.loads(_taut.scene_schema())["$defs"][kind]["oneOf"]
    return tuple(str(choice["const"]) for choice in choices)


def choose(filters: Sequence[str], integrators: Sequence[str]) -> list[Method]:
    """Every filter with every integrator, in the order given, each once.

    Args:
        filters: names that `solver.filter` allows, or `all`.
        integrators: names that `solver.integrator` allows, or `all`.

    Raises:
        CompareError: a name is unknown, or there is none.
    """
    kinds = chosen("filters", filters, known("FilterKind"))
    schemes = chosen("integrators", integrators, known("IntegratorKind"))
    return [Method(kind, scheme) for scheme in schemes for kind in kinds]


@dataclass(frozen=True, slots=True)
class Dial:
    """What is turned up until a method keeps the limit."""

    name: Literal["steps", "passes", "stiffness"]
    """Steps a frame, passes of the filter in a step, or the stiffness of the springs themselves."""

    def settings(self, scene: Scene, steps: int, factor: float, limit: float) -> list[str]:
        """The settings, for :meth:`taut.Scene.with_settings`, that turn the dial.

        Args:
            scene: the method with its usual settings.
            steps: steps a frame with those [1].
            factor: how far to turn: 2 is twice the usual amount [1].
            limit: the strain limit to be kept [1].
        """
        solver = scene.document["solver"]
        if self.name == "steps":
            return [f"solver.substeps={max(1, round(steps * factor))}"]
        if self.name == "stiffness":
            return [
                f"cloth[{index}].{field}={cloth[field] * factor!r}"
                for index, cloth in enumerate(scene.document["cloth"])
                for field in ("stiffness", "shear_stiffness")
                if cloth.get(field)
            ]
        # Passes end early once all springs are within the tolerance, which must not stand above the target.
        tolerance = min(float(solver["tolerance"]), 0.02 * limit)
        passes = max(1, round(int(solver["iterations"]) * factor))
        return [f"solver.iterations={passes}", f"solver.tolerance={tolerance!r}"]


_DIALS = {
    "none": Dial("stiffness"),
    "provot": Dial("passes"),
    "sweeps": Dial("passes"),
    "rods": Dial("passes"),
}


def dial_of(method: Method, scene: Scene) -> Dial:
    """The dial that brings a method nearer to the limit: of most, and of measured curves, the steps."""
    dial = _DIALS.get(method.filter, Dial("steps"))
    curved = not any(cloth.get("stiffness") for cloth in scene.document["cloth"])
    return Dial("steps") if dial.name == "stiffness" and curved else dial
