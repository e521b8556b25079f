"""Where everything lies still nothing is computed, until something from outside changes."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation
from taut.bench.meshes import irregular_sheet

Fields = dict[str, Any]
FLOOR: Fields = {"name": "floor", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}, "friction": 0.4}
BALL: Fields = {"name": "ball", "sphere": {"center": [0, 0, 0.3], "radius": 0.2}, "friction": 0.4}
FAR: Fields = {"name": "far", "sphere": {"center": [3, 0, 0.5], "radius": 0.2}}
CLOTH: Fields = {"mesh": "sheet", "thickness": 0.003, "friction": 0.4, "bending": "fabric", "air_drag": 1.5}
LATEST = 8 * 60
"""Everything below lies still by then [frames]."""


def simulation(
    threads: int = 1, cloth: Fields | None = None, sleep: bool = True, **document: Any
) -> Simulation:
    """A sheet of 0.6 m that falls on a ball and the floor."""
    vertices, faces = irregular_sheet((24, 24), (0.6, 0.6), 1)
    placed = vertices - [0.3, 0.3, -0.55]
    given = {"fps": 60, "body": [FLOOR, BALL, FAR], "solver": {"sleep": sleep}}
    given["cloth"] = [CLOTH | (cloth or {})]
    return Simulation(Scene(given | document, {"sheet": (placed, faces)}), threads)


def falls_asleep(made: Simulation) -> int:
    """The frame in which it does."""
    for frame in range(LATEST):
        if made.run(1).asleep:
            return frame
    raise AssertionError("it does not fall asleep")


@pytest.fixture(scope="module")
def asleep() -> Simulation:
    """One that sleeps."""
    made = simulation()
    falls_asleep(made)
    return made


def test_what_sleeps_does_not_move_and_takes_no_cycles(asleep: Simulation) -> None:
    made = asleep.clone()
    before, since = made.exact_positions, made.time
    report = made.run(120)
    assert report.asleep and report.sweeps == report.evaluations == 0
    np.testing.assert_array_equal(made.exact_positions, before)
    assert not made.velocities.any() and report.kinetic_energy == 0.0
    assert made.time == pytest.approx(since + 2.0) and report.worst_stretch <= 0.05 + 1e-5
    assert not made.intersections()


def test_it_lies_where_it_would_lie_without_sleep(asleep: Simulation) -> None:
    awake = simulation(sleep=False)
    awake.run(asleep.steps // asleep.substeps)
    assert not awake.run(300).asleep, "only if it is asked for"
    apart = np.linalg.norm(awake.exact_positions - asleep.exact_positions, axis=1)
    assert apart.max() < 2e-3 and np.sqrt((apart**2).mean()) < 2e-4


def moves(made: Simulation, frames: int = 20) -> float:
    """How far it goes on the mean [m]."""
    before = made.exact_positions
    for _ in range(frames):
        assert not made.run(1).asleep
    return float(np.linalg.norm(made.exact_positions - before, axis=1).mean())


def blows(made: Simulation) -> None:
    made.wind = (0.0, 0.0, 8.0)


def tilts(made: Simulation) -> None:
    made.gravity = (6.0, 0.0, -7.8)


def shifts(made: Simulation) -> None:
    made.shift_body("ball", (0.1, 0.0, 0.0), over=0.2)


def poses(made: Simulation) -> None:
    made.shift_body("ball", (0.0, 0.0, -0.1), over=0.2)


def pulls(made: Simulation) -> None:
    made.lead(0, (-0.3, -0.3, 0.8), 2.0)


def holds(made: Simulation) -> None:
    made.hold([0], made.exact_positions[[0]] + [0.0, 0.0, 0.2], over=0.2)


def pushes(made: Simulation) -> None:
    made.velocities = made.velocities + np.float32([0.0, 0.0, 2.0])


def carries(made: Simulation) -> None:
    made.translate((0.0, 0.0, 0.1))


@pytest.mark.parametrize("wake", [blows, tilts, shifts, poses, pulls, holds, pushes, carries])
def test_whatever_changes_wakes_it(asleep: Simulation, wake: Callable[[Simulation], None]) -> None:
    made = asleep.clone()
    made.run(10)
    wake(made)
    assert moves(made) > 1e-3


def test_what_is_as_it_was_does_not(asleep: Simulation) -> None:
    made = asleep.clone()
    made.gravity = made.gravity
    assert made.run(1).asleep


SLOW = 4e-4
"""Slower than what counts as still [m/s]."""


def holds_slowly(made: Simulation) -> None:
    made.hold([0], made.exact_positions[[0]] + [0.0, 0.0, 100 * SLOW], over=100.0)


def leads_slowly(made: Simulation) -> None:
    made.lead(0, made.exact_positions[0] + [0.0, 0.0, 1.0], SLOW)


def shifts_slowly(made: Simulation) -> None:
    made.shift_body("ball", (0.0, 0.0, 100 * SLOW), over=100.0)


def moves_pins_slowly(made: Simulation) -> None:
    made.shift_pins(0, (0.0, 0.0, 0.1), SLOW)


@pytest.mark.parametrize("slowly", [holds_slowly, leads_slowly, shifts_slowly, moves_pins_slowly])
def test_what_is_moved_hardly_faster_than_nothing_goes_all_of_its_way(
    slowly: Callable[[Simulation], None],
) -> None:
    vertices, faces = irregular_sheet((8, 8), (0.3, 0.3), 1)
    cloth = CLOTH | {"pins": [{"vertices": [8]}]}
    given = {"fps": 60, "body": [FLOOR, FAR | {"name": "ball"}], "cloth": [cloth], "solver": {"sleep": True}}
    made = Simulation(Scene(given, {"sheet": (vertices + [0.0, 0.0, 0.0035], faces)}), 1)
    falls_asleep(made)
    before = [made.exact_positions, made.bodies["ball"].positions.copy()]
    slowly(made)
    for _ in range(240):
        assert not made.run(1).asleep
    gone = [made.exact_positions - before[0], made.bodies["ball"].positions - before[1]]
    assert max(np.abs(way).max() for way in gone) == pytest.approx(4 * SLOW, rel=0.05)


def test_it_sleeps_again_in_its_new_place(asleep: Simulation) -> None:
    made = asleep.clone()
    shifts(made)
    assert moves(made) > 1e-3
    falls_asleep(made)


def test_what_changes_later_wakes_it_then() -> None:
    turn = {"axis": [0, 0, 1], "point": [0, 0, 0], "angle": [[12, 0], [13, 90]]}
    made = simulation(body=[FLOOR, BALL | {"turn": turn}])
    falls_asleep(made)
    while made.time < 12.0 - 1.5 / 60:
        assert made.run(1).asleep
    made.run(1)
    before = made.exact_positions
    assert not made.run(2).asleep
    made.run(30)
    assert np.linalg.norm(made.exact_positions - before, axis=1).mean() > 0.01


def test_gusts_keep_it_awake() -> None:
    made = simulation(wind={"velocity": [0.2, 0, 0], "gust": {"strength": 0.3}})
    assert not any(made.run(1).asleep for _ in range(LATEST))
    made.wind = {"velocity": [0.2, 0.0, 0.0]}
    falls_asleep(made)


def test_hooks_keep_it_awake(asleep: Simulation) -> None:
    made = asleep.clone()
    called = 0

    def hook(_positions: object, _velocities: object, _step: float) -> None:
        nonlocal called
        called += 1

    assert not made.step(4, hook=hook).asleep
    assert called >= 4


def test_what_drifts_in_empty_space_goes_on() -> None:
    made = simulation(gravity=[0, 0, 0], body=[FAR], cloth={"air_drag": 0.0})
    made.velocities = np.full_like(made.velocities, 1e-4)
    start = made.exact_positions
    made.run(600)
    np.testing.assert_allclose(made.exact_positions - start, 1e-3, rtol=0.01)


@pytest.mark.parametrize("steep", [1.05, 1.01])
def test_what_begins_to_slide_is_not_held(steep: float) -> None:
    angle = float(np.arctan(0.4 * steep))
    down = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    slope = {"name": "slope", "plane": {"point": [0, 0, 0], "normal": normal.tolist()}, "friction": 0.4}
    vertices, faces = irregular_sheet((8, 8), (0.3, 0.3), 1)
    across = np.array([0.0, 1.0, 0.0])
    placed = np.outer(vertices[:, 0], down) + np.outer(vertices[:, 1], across) + 0.0031 * normal
    cloth = CLOTH | {"air_drag": 0.0, "drag_coefficient": 0.0}
    given = {"fps": 60, "body": [slope], "cloth": [cloth], "solver": {"sleep": True}}
    made = Simulation(Scene(given, {"sheet": (placed, faces)}), 1)
    made.run(60)
    before = (made.velocities @ down).mean()
    made.run(120)
    gained = (made.velocities @ down).mean() - before
    assert gained == pytest.approx(2 * 9.81 * (np.sin(angle) - 0.4 * np.cos(angle)), rel=0.03)


def test_it_goes_on_from_a_snapshot_and_on_any_number_of_threads() -> None:
    one, two = simulation(threads=1), simulation(threads=2)
    frame = falls_asleep(one)
    two.run(frame - 10)
    again = simulation()
    again.restore(two.snapshot())
    told = simulation()
    told.set_state(two.local_positions, two.velocities, two.steps, past=two.past, origins=two.origins)
    for other in (two, again, told):
        assert not other.run(10).asleep
        assert other.run(1).asleep
        assert other.state_hash == one.state_hash
    one.run(30)
    again.restore(one.snapshot())
    assert again.run(1).asleep
    one.run(1)
    assert again.state_hash == one.state_hash
