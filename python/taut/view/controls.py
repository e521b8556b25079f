"""What can be changed while a scene runs, and which fields of the scene that means."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from taut import _taut
from taut.view.wire import OrderError

Document = Mapping[str, Any]
Value = float | str


@dataclass(frozen=True)
class Control:
    """A slider or a choice of the page."""

    name: str
    label: str
    group: str
    read: Callable[[Document], Value]
    """Its value in a resolved scene."""
    write: Callable[[Document, Any], list[str]]
    """The settings, as for ``--set``, that give it a value."""
    low: float = 0.0
    high: float = 0.0
    step: float = 0.0
    unit: str = ""
    choices: tuple[str, ...] = field(default=())
    """Of a choice; a slider has none."""

    def check(self, value: Value) -> Value:
        """The value as it may be written.

        Raises:
            OrderError: it is none of the choices, no number, or out of range.
        """
        if self.choices:
            if value not in self.choices:
                raise OrderError(f"{self.name} = {value!r}: must be one of {', '.join(self.choices)}")
        elif isinstance(value, str) or not self.low <= value <= self.high:
            raise OrderError(f"{self.name} = {value!r}: must be a number from {self.low:g} to {self.high:g}")
        return value

    def describe(self, document: Document) -> dict[str, Any]:
        """What the page needs to draw it."""
        shown = ("name", "label", "group", "low", "high", "step", "unit", "choices")
        return {name: getattr(self, name) for name in shown} | {"value": self.read(document)}


@cache
def controls() -> Mapping[str, Control]:
    """All controls by name, in the order in which they are shown."""
    wind, cloth, solver = "Wind and gravity", "Cloth", "Solver"
    listed = [
        Control("limit", "Limit λ", cloth, _limit, _write_limit, 1, 50, 0.5, "%"),
        Control("fabric", "Fabric", cloth, _fabric, _write_fabric, choices=_names("Fabric")),
        Control("wind_speed", "Wind", wind, lambda d: _polar(d)[0], _write_wind(0), 0, 40, 0.5, "m/s"),
        Control("wind_heading", "Direction", wind, lambda d: _polar(d)[1], _write_wind(1), -180, 180, 5, "°"),
        Control("wind_climb", "Upwards", wind, lambda d: _polar(d)[2], _write_wind(2), -90, 90, 5, "°"),
        Control("gust", "Gusts", wind, _gust("strength"), _write_gust("strength", 0.01), 0, 150, 5, "%"),
        Control(
            "gust_period", "Gust period", wind, _gust("period"), _write_gust("period", 1), 0.2, 8, 0.1, "s"
        ),
        Control("gravity", "Gravity", wind, _gravity, _write_gravity, 0, 30, 0.1, "m/s²"),
        Control("filter", "Filter", solver, _filter, _write_filter, choices=_names("FilterKind")),
        Control("substeps", "Steps a frame", solver, _substeps, _write_substeps, 0, 200, 1, "0: auto"),
    ]
    return {control.name: control for control in listed}


def check(name: str, value: Value) -> Value:
    """The value that a control may be given.

    Raises:
        OrderError: there is no such control, or the value is not allowed.
    """
    if name not in controls():
        raise OrderError(f"control = {name!r}: must be one of {', '.join(controls())}")
    return controls()[name].check(value)


def inline(value: Any) -> str:
    """A value as TOML writes it on one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {inline(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(value)


def _names(kind: str) -> tuple[str, ...]:
    """The words that a field may have, from the schema."""
    definition = json.loads(_taut.scene_schema())["$defs"][kind]
    options = definition.get("oneOf") or [{"enum": definition["enum"]}]
    return tuple(word for option in options for word in option.get("enum", [option.get("const")]) if word)


def _every_cloth(document: Document, name: str, value: Any) -> list[str]:
    return [f"cloth[{index}].{name}={inline(value)}" for index in range(len(document["cloth"]))]


def _limit(document: Document) -> float:
    return 100 * min(float(cloth["strain_limit"]) for cloth in document["cloth"])


def _write_limit(document: Document, per_cent: float) -> list[str]:
    return _every_cloth(document, "strain_limit", per_cent / 100)


def _fabric(document: Document) -> str:
    return str(document["cloth"][0]["fabric"])


def _write_fabric(document: Document, name: str) -> list[str]:
    return _every_cloth(document, "fabric", name)


def _up(document: Document) -> int:
    return 1 if document.get("up") == "y" else 2


def _polar(document: Document) -> tuple[float, float, float]:
    """Speed [m/s], heading and climb [degrees] of the mean wind."""
    velocity = [float(part) for part in (document.get("wind") or {}).get("velocity", (0, 0, 0))]
    up = _up(document)
    east, north, climb = velocity[0], velocity[3 - up] * (1 if up == 2 else -1), velocity[up]
    across = math.hypot(east, north)
    heading = math.degrees(math.atan2(north, east))
    return math.hypot(across, climb), heading, math.degrees(math.atan2(climb, across))


def _write_wind(changed: int) -> Callable[[Document, float], list[str]]:
    def write(document: Document, value: float) -> list[str]:
        polar = list(_polar(document))
        polar[changed] = value
        # Air at rest has no direction; a hundredth of a millimetre a second keeps the one that was set.
        speed, heading, climb = max(polar[0], 1e-5), *map(math.radians, polar[1:])
        up, across = _up(document), speed * math.cos(climb)
        velocity = [across * math.cos(heading), 0.0, 0.0]
        velocity[3 - up] = across * math.sin(heading) * (1 if up == 2 else -1)
        velocity[up] = speed * math.sin(climb)
        return [f"wind.velocity={inline(velocity)}"]

    return write


def _gust(name: str) -> Callable[[Document], float]:
    unused = {"strength": 0.0, "period": 2.0}
    scale = {"strength": 100.0, "period": 1.0}[name]

    def read(document: Document) -> float:
        gust = (document.get("wind") or {}).get("gust") or unused
        return scale * float(gust[name])

    return read


def _write_gust(name: str, scale: float) -> Callable[[Document, float], list[str]]:
    def write(document: Document, value: float) -> list[str]:
        calm = [] if (document.get("wind") or {}).get("gust") else ["wind.gust.strength=0.0"]
        return [*calm, f"wind.gust.{name}={inline(scale * value)}"]

    return write


def _gravity(document: Document) -> float:
    vector = document.get("gravity")
    return 9.81 if vector is None else math.hypot(*map(float, vector))


def _write_gravity(document: Document, value: float) -> list[str]:
    vector = [0.0, 0.0, 0.0]
    vector[_up(document)] = -value
    return [f"gravity={inline(vector)}"]


def _filter(document: Document) -> str:
    return str(document["solver"]["filter"])


def _write_filter(document: Document, name: str) -> list[str]:
    return [f"solver.filter={name}"]


def _substeps(document: Document) -> float:
    substeps = document["solver"]["substeps"]
    return 0.0 if substeps == "auto" else float(substeps)


def _write_substeps(document: Document, value: float) -> list[str]:
    return ["solver.substeps=" + ("auto" if value < 1 else str(round(value)))]
