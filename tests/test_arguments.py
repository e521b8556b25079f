"""Numbers and arrays that a simulation is given: what is wrong is named, with what is allowed."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation

from tests.attack.leaks import leak

TIP = 34
ZEROS = np.zeros((35, 3), np.float32)


class Odd:
    def __repr__(self) -> str:
        raise RuntimeError("not to be shown")


def but(values: list[Any], *allowed: Any) -> list[Any]:
    return [
        value for value in values if not any(type(value) is type(one) and value == one for one in allowed)
    ]


NO_NUMBERS = [
    None,
    "x",
    "\ud800",
    b"x",
    [],
    {},
    {"a": 1},
    Odd(),
    object,
    slice(3),
    set(),
    [None] * 3,
    ["\ud800"] * 3,
]
NO_NUMBERS += [
    [1j, 0, 0],
    [[0, 0], [0]],
    np.zeros(3, complex),
    np.array("2020", dtype="M8[D]"),
    np.zeros((2, 2)),
]
NO_REALS = [*NO_NUMBERS, float("nan"), 10**400, -(10**5000), -1, -1e300]
NO_INTEGERS = [*NO_NUMBERS, 1.5, float("nan"), np.float32(1), -1, 2**64, 10**5000]
NO_TRIPLES = [*NO_NUMBERS, 1.0, [0, 0], [1, 2, 3, 4], [[0, 0, 0]], [0, 0, float("nan")], [10**400, 0, 0]]
NO_TRIPLES += [[float("inf"), 0, 0], [1e300, 0, 0], ["a", "b", "c"], np.zeros((35, 3)), np.zeros(3, bool)]
NO_STATES = [
    *NO_TRIPLES[:-2],
    np.zeros(3, bool),
    np.zeros((34, 3), np.float32),
    np.full((35, 3), np.inf),
    np.zeros((35, 3), int),
]

WRONG: dict[str, tuple[Callable[[Simulation, Any], object], list[Any]]] = {
    "positions": (lambda s, value: setattr(s, "positions", value), NO_STATES),
    "velocities": (lambda s, value: setattr(s, "velocities", value), NO_STATES),
    "gravity": (lambda s, value: setattr(s, "gravity", value), NO_TRIPLES),
    "wind": (lambda s, value: setattr(s, "wind", value), but(NO_TRIPLES, None, {})),
    "vertex": (lambda s, value: s.lead(value, (0, 0, 0), 1), [*NO_INTEGERS, 35]),
    "target": (lambda s, value: s.lead(TIP, value, 1), NO_TRIPLES),
    "speed": (lambda s, value: s.lead(TIP, (0, 0, 0), value), [*NO_REALS, 0, 1e-50]),
    "vert": (lambda s, value: s.hold(value, [(0, 0, 0)]), but(NO_INTEGERS, [])),
    "targets": (lambda s, value: s.hold([TIP], value), but(NO_TRIPLES, [[0, 0, 0]])),
    "over": (lambda s, value: s.hold(TIP, (0, 0, 0), value), [*NO_REALS, float("inf")]),
    "vert of release": (lambda s, value: s.release(value), but(NO_INTEGERS, [])),
    "group": (lambda s, value: s.shift_pins(value, (0, 0, 0), 1), [*NO_INTEGERS, 1]),
    "offset": (lambda s, value: s.shift_pins(0, value, 1), NO_TRIPLES),
    "speed of pins": (lambda s, value: s.shift_pins(0, (0, 0, 0), value), [*NO_REALS, 0, 1e-50]),
    "group of pin_offset": (lambda s, value: s.pin_offset(value), [*NO_INTEGERS, 1]),
    "n": (lambda s, value: s.step(value), [*NO_INTEGERS, 0]),
    "dt": (lambda s, value: s.step(1, value), but([*NO_REALS, 0.0, 1e-50, 1e308], None)),
    "frames": (lambda s, value: s.run(value), NO_INTEGERS),
    "on_frame": (lambda s, value: s.run(1, value), ["x", 1, []]),
    "repeats": (lambda s, value: s.yardstick(value), [*NO_INTEGERS, 0]),
    "snapshot": (lambda s, value: s.restore(value), [*NO_NUMBERS, 1]),
    "steps": (lambda s, value: s.set_state(ZEROS, ZEROS, value), [*NO_INTEGERS, 2**63, 2**64 - 1]),
    "past": (lambda s, value: s.set_state(ZEROS, ZEROS, 0, value), but(NO_STATES, None)),
    "origins": (lambda s, value: s.set_state(ZEROS, ZEROS, 0, None, value), but(NO_STATES, None)),
    "threads": (lambda s, value: Simulation(s.scene, value), but([*NO_INTEGERS, 0, 1025], None)),
}


@pytest.fixture
def simulation(flag: dict[str, Any]) -> Simulation:
    return Simulation(Scene(flag), threads=1)


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_and_nothing_changes(simulation: Simulation, name: str) -> None:
    use, values = WRONG[name]
    before = simulation.snapshot(), simulation.gravity, simulation.wind, simulation.report
    for number, value in enumerate(values):
        with pytest.raises((TypeError, ValueError, IndexError)) as error:
            use(simulation, value)
        said = str(error.value)
        where = f"{number}: {said}"
        assert leak(error.value) is None, where
        assert name.split()[0] in said, where
        assert any(word in said for word in ("must", "there are", "not a taut snapshot", "allowed")), where
    assert (simulation.snapshot(), simulation.gravity, simulation.wind, simulation.report) == before


def test_a_short_target_is_shown_with_its_shape(simulation: Simulation) -> None:
    with pytest.raises(
        ValueError, match=r"target = \[0, 0\]: has shape \(2,\), must be three finite numbers"
    ):
        simulation.lead(3, [0, 0], 1)


def test_the_number_of_steps_that_can_be_set_is_bounded(simulation: Simulation) -> None:
    simulation.set_state(ZEROS + simulation.positions, ZEROS, 2**52)
    simulation.step(2)
    assert simulation.steps == 2**52 + 2
    with pytest.raises(ValueError, match="steps = .*must be a whole number from 0 to 4503599627370496"):
        simulation.set_state(ZEROS, ZEROS, 2**52 + 1)


def test_views_cannot_be_made_writable(simulation: Simulation) -> None:
    names = [
        "positions",
        "velocities",
        "faces",
        "springs",
        "spring_kind",
        "rest_length",
        "strain_limit",
        "mass",
        "pinned",
    ]
    for array in [*(getattr(simulation, name) for name in names), *simulation.pin_groups]:
        before = array.copy()
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.setflags(write=True)
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
        assert np.array_equal(array, before)


def test_even_views_without_elements_are_read_only() -> None:
    from taut.arrays import read_only

    for shape in ((0, 3), (0,), (2, 3)):
        array = np.zeros(shape, np.int32)
        assert (read_only(array).shape, read_only(array).dtype) == (array.shape, array.dtype)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))])
def test_copies_go_on_by_themselves(flag: dict[str, Any], copied: Callable[[Simulation], Simulation]) -> None:
    flag["gravity_keyframes"] = [[0.5, [0.0, 5.0, 0.0]]]
    simulation = Simulation(Scene(flag), threads=2)
    simulation.wind = [0.0, 9.0, 0.0]
    simulation.hold(TIP, simulation.positions[TIP] + np.float32([0.0, 0.1, 0.0]), over=0.5)
    simulation.step(7)
    other = copied(simulation)
    assert (other.state_hash, other.steps, other.threads) == (simulation.state_hash, 7, 2)
    assert (other.wind, other.gravity) == (simulation.wind, simulation.gravity)
    np.testing.assert_array_equal(other.positions, simulation.positions)
    before = simulation.state_hash
    other.step(30)
    assert simulation.state_hash == before
    assert not np.array_equal(other.positions, simulation.positions)
    simulation.step(30)
    assert other.state_hash == simulation.state_hash
    other.gravity = (0.0, 0.0, 1.0)
    again = copied(other)
    assert again.gravity == (0, 0, 1) != simulation.gravity
