"""Nothing passes through anything: frames and the ways between them, judged by the IPC Toolkit and NumPy."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation, SimulationError
from taut.scene import find_scene

from tools.targets.contact.drapes import stage, turned
from tools.targets.contact.friction import let_go, pinched, slides, slope, strip
from tools.targets.contact.heaps import THICKNESS, on_its_edge
from tools.targets.contact.judge import Oracle, distance
from tools.targets.contact.scenes import Stage, ball, sheet
from tools.targets.rest import CALMING
from tools.targets.table import FULL


def watched(scene: dict[str, Any] | Scene, steps: int, after: int = 0) -> Simulation:
    """A simulation in which every step after so many others has been looked at."""
    simulation = Simulation(scene if isinstance(scene, Scene) else Scene(scene))
    if after:
        simulation.step(after)
    limit = simulation.strain_limit.max()
    oracle = Oracle(simulation)
    for _ in range(steps):
        report = simulation.step()
        assert report.worst_stretch <= limit * (1 + 1e-5)
        seen = oracle.look(simulation)
        assert seen.clean, seen
    return simulation


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ball", "box-corner", "table-cloth", "stack", "net-ball"])
def test_every_step_of_a_shipped_scene_is_free_of_crossings(name: str) -> None:
    watched(Scene.load(find_scene(name)), 90)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "start"), [("twist", 2.5), ("skirt-walk", 0.8)])
def test_what_is_led_goes_through_no_cloth_and_is_not_held_up_by_it(name: str, start: float) -> None:
    """A second in which the strip becomes a rope, and one in which knees strike the skirt."""
    simulation = Simulation(Scene.load(find_scene(name)))
    before, steps = (round(seconds / simulation.step_length) for seconds in (start, 1.0))
    simulation = watched(Scene.load(find_scene(name)), steps, after=before)
    assert simulation.report.contacts > 0
    assert not any(simulation.pin_offset(group).any() for group in range(len(simulation.pin_groups)))
    # Parts of a step end at its end but for rounding.
    assert all(np.abs(simulation.body_offset(name)).max() < 1e-12 for name in simulation.bodies)


CLOTH: dict[str, Any] = {
    "grid": {"size": [0.5, 0.5], "cells": [14, 14], "axes": ["x", "z"], "origin": [-0.25, 0, 0.05]},
    "strain_limit": 0.05,
    "thickness": 0.004,
}
FLOOR = {"name": "floor", "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}


def test_cloth_that_falls_on_its_edge_heaps_without_crossings() -> None:
    wavy = {**CLOTH, "rotate": [4.0, 3.0, 0.0]}
    wavy["translate"] = [0.0, 0.0, 0.03]
    simulation = watched({"cloth": [wavy], "body": [FLOOR]}, 70)
    assert simulation.positions[:, 2].max() < 0.3


def test_what_a_fold_pressed_together_comes_apart() -> None:
    """Where it is struck it may be much nearer for a while than a tenth of the thickness."""

    def closest(across: int) -> float:
        simulation = on_its_edge(across, mesh=True).simulation()
        simulation.run(100)
        return min(simulation.run(1).closest for _ in range(100))

    # One of them may be struck just then.
    assert np.median([closest(across) for across in (24, 25, 26)]) > 0.09 * THICKNESS


def test_a_thrown_box_sweeps_two_cloths_along() -> None:
    pins = [{"box": [[-1, -1, 0.549], [1, 1, 0.6]]}]
    behind = {**CLOTH, "grid": {**CLOTH["grid"], "origin": [-0.25, 0.03, 0.05]}, "pins": pins}
    box = {
        "name": "box",
        "box": {"center": [0.02, -0.3, 0.3], "size": [0.12, 0.12, 0.12], "rotate": [20, 30, 10]},
        "move": [[0.1, [0, 0, 0]], [0.3, [0, 0.45, 0]]],
        "turn": {"axis": [0, 1, 0], "point": [0, 0, 0.3], "angle": [[0.6, 60]]},
    }
    scene = {"cloth": [{**CLOTH, "pins": pins}, behind], "body": [box]}
    simulation = Simulation(Scene(scene))
    oracle = Oracle(simulation)
    for _ in range(40):
        simulation.step()
        seen = oracle.look(simulation)
        # Where a step is taken in parts, what comes between its ends is no straight way.
        assert not seen.intersects and not seen.inside
    assert simulation.positions[:, 1].max() > 0.15


def test_pins_that_a_body_holds_back_wait_and_come_back_little_by_little() -> None:
    size, cells = 0.3, 10
    pins = [{"edge": "top", "move": [[0.0, [0, 0, 0]], [0.3, [0, 0.3, 0]]]}]
    grid = {"size": [size, size], "cells": [cells, cells], "axes": ["x", "z"], "origin": [-0.15, 0, 0.5]}
    wall = {"name": "wall", "box": {"center": [0, 0.2, 0.7], "size": [1, 0.2, 1]}}
    cloth = {"grid": grid, "density": 0.2, "thickness": 0.004, "pins": pins}
    simulation = Simulation(Scene({"cloth": [cloth], "body": [wall]}))
    held = simulation.pin_groups[0]
    for _ in range(30):
        report = simulation.step(simulation.substeps)
        assert report.lost_motion < 0.01 and report.contact_cuts == 0, "the rest of the cloth goes on"
    assert np.all(np.abs(simulation.exact_positions[held, 1] - 0.1) < 0.002), "they are at the wall"
    simulation.shift_body("wall", [5, 0, 0])
    longest = 0.25 * np.sqrt(2) * size / cells * simulation.substeps
    for _ in range(60):
        before = simulation.exact_positions[held]
        simulation.step(simulation.substeps)
        ways = np.linalg.norm(simulation.exact_positions[held] - before, axis=1)
        assert ways.max() < longest
    assert np.all(np.abs(simulation.exact_positions[held, 1] - 0.3) < 1e-6), "they are back on their path"


def held_into_a_wall() -> tuple[Simulation, NDArray[np.intp], NDArray[np.float64]]:
    """A sheet whose upper edge a user leads into a wall 0.1 m away, and where that edge was."""
    grid = {"size": [0.3, 0.3], "cells": [10, 10], "axes": ["x", "z"], "origin": [-0.15, 0, 0.5]}
    wall = {"name": "wall", "box": {"center": [0, 0.2, 0.7], "size": [4, 0.2, 4]}, "friction": 0.2}
    cloth = {"grid": grid, "density": 0.2, "thickness": 0.004}
    simulation = Simulation(Scene({"cloth": [cloth], "body": [wall]}))
    places = simulation.exact_positions
    held = np.flatnonzero(places[:, 2] > places[:, 2].max() - 1e-9)
    return simulation, held, places[held]


def test_what_a_user_holds_stops_at_a_wall_goes_along_it_and_is_not_thrown() -> None:
    """It asked for all of its way in every step: the cloth lost its motion, and flew off at 30 m/s."""
    simulation, held, start = held_into_a_wall()
    target = start
    for frame in range(40):
        # Into the wall by 50 mm, and from then on along it.
        target = start + [max(0, frame - 15) * 0.004, min(0.01 * (frame + 1), 0.15), 0]
        simulation.hold(held, target)
        report = simulation.step(simulation.substeps)
        assert report.lost_motion < 0.01 and report.contact_cuts == 0
    at_wall = simulation.exact_positions[held]
    assert np.all(np.abs(at_wall[:, 1] - 0.1) < 0.002), "a little more than the wall's skin away"
    assert np.all(np.abs(at_wall[:, 0] - target[:, 0]) < 0.05), "it has gone along by 0.1 m"
    simulation.shift_body("wall", [0, 1, 0])
    for _ in range(40):
        simulation.step(simulation.substeps)
        assert np.linalg.norm(simulation.velocities, axis=1).max() < 5
    np.testing.assert_allclose(simulation.exact_positions[held], target, atol=1e-6)


@pytest.mark.parametrize("way", [[0.002, 0, 0], [0.001, 0, 0.001], [0, 0.001, -0.0002]])
def test_what_is_held_inside_of_a_body_goes_freely(way: list[float]) -> None:
    """So garments are fastened: an edge 2 mm inside of a rod goes along it, across it and deeper in."""
    rod = {"name": "rod", "capsule": {"from": [-1, 0, 0.3], "to": [1, 0, 0.3], "radius": 0.03}}
    grid = {"size": [0.3, 0.3], "cells": [10, 10], "axes": ["x", "z"], "origin": [-0.15, 0, -0.028]}
    cloth = {"grid": grid, "density": 0.2, "thickness": 0.004}
    simulation = Simulation(Scene({"cloth": [cloth], "body": [rod]}))
    places = simulation.exact_positions
    held = np.flatnonzero(places[:, 2] > places[:, 2].max() - 1e-9)
    for frame in range(20):
        target = places[held] + np.array(way) * (frame + 1)
        simulation.hold(held, target)
        simulation.step(simulation.substeps)
        np.testing.assert_allclose(simulation.exact_positions[held], target, atol=1e-6)


def test_what_is_held_and_behind_its_place_is_part_of_a_snapshot() -> None:
    simulation, held, start = held_into_a_wall()
    simulation.hold(held, start + [0, 0.2, 0], over=0.2)
    simulation.run(20)
    again = simulation.clone()
    restored, _, _ = held_into_a_wall()
    restored.restore(simulation.snapshot())
    for one in (simulation, again, restored):
        one.shift_body("wall", [0, 1, 0])
        one.run(2)
    assert simulation.state_hash == again.state_hash == restored.state_hash
    gone = simulation.exact_positions[held, 1]
    assert np.all((gone > 0.1) & (gone < 0.19)), "it is on its way"


@pytest.mark.parametrize(("on", "mesh"), [("cloth", False), ("cloth", True), ("box", True)])
def test_sliding_over_edges_of_what_is_flat_is_coulombs(on: str, mesh: bool) -> None:
    """At 1.05 of the tangent a hundredth of the friction is a fifth of the acceleration."""
    found = slides("slope", on, 0.35, mesh, FULL)
    assert found.met, found.figures


@pytest.mark.parametrize("mesh", [False, True])
def test_what_sticks_on_cloth_stays(mesh: bool) -> None:
    """A sheet at 0.95 of the tangent: what sweeps leave of each step does not add up."""
    simulation = slope("cloth", 1.0, 0.95, mesh)[0].simulation()
    own = slice(simulation.cloths[0].vertices)
    simulation.run(60)
    before = simulation.exact_positions[own]
    simulation.run(120)
    crept = np.linalg.norm(simulation.exact_positions[own] - before, axis=1)
    # It crept by 0.04 and 0.07 mm on the mean, and by 0.7 mm at most, in two seconds.
    assert crept.mean() < 2e-5
    assert crept.max() < 2.5e-4


def test_what_is_reported() -> None:
    scene = Scene(
        {
            "cloth": [{**CLOTH, "grid": {**CLOTH["grid"], "axes": ["x", "y"], "origin": [0, 0, 0.01]}}],
            "body": [FLOOR],
        }
    )
    simulation = Simulation(scene)
    first = simulation.step()
    assert (first.contacts, first.contact_cuts) == (0, 0)
    for _ in range(20):
        report = simulation.step()
    assert report.contacts == 225
    assert report.closest == pytest.approx(0.003, rel=0.05)
    lowest = simulation.positions[:, 2].min()
    assert lowest == pytest.approx(0.003, rel=0.05), "half of the thickness and the skin of the floor"


def test_a_trace_has_all_parts_of_all_steps() -> None:
    """A ball that goes further than a cell in a step, close beside a sheet."""
    sphere = {"center": [0.36, -0.2, 0.3], "radius": 0.1}
    ball = {"name": "ball", "sphere": sphere, "move": [[0.1, [0, 2, 0]]]}
    pins = [{"box": [[-1, -1, 0.549], [1, 1, 0.6]]}]
    simulation = Simulation(Scene({"cloth": [{**CLOTH, "pins": pins}], "body": [ball, FLOOR]}))
    assert simulation.trace is None
    simulation.keep_trace()
    assert simulation.trace == []
    simulation.step(3)
    trace = simulation.trace
    assert trace
    assert len(trace) >= 3 * 4
    now = np.concatenate([simulation.exact_positions, simulation.body_positions])
    np.testing.assert_array_equal(trace[-1], now)
    # The ball goes in even parts: its middle is the first vertex of the bodies.
    middles = [-0.2, *(moment[len(simulation.mass), 1] for moment in trace)]
    assert np.diff(middles).max() < 0.6 * 2 / 0.1 / 60
    simulation.keep_trace(False)
    assert simulation.trace is None


def test_distances_of_triangles_from_points_and_lines() -> None:
    corners = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    for point, expected in (
        ([0.2, 0.2, 0.5], 0.5),  # above the inside
        ([-0.3, 0.5, 0.4], 0.5),  # beside an edge
        ([1.3, 0.0, -0.4], 0.5),  # beyond a corner
    ):
        assert distance(corners, np.array([point])) == pytest.approx(expected)
    for line, expected in (
        ([[-1, 0.5, 0.3], [2, 0.5, 0.3]], 0.3),  # over it, along an edge
        ([[0.5, -1, 0.7], [0.5, -1, -0.7]], 1.0),  # across an edge, apart
        ([[3, 0, 0.2], [3, 1, 0.2]], np.hypot(2, 0.2)),
    ):
        assert distance(corners, np.array(line, float)) == pytest.approx(expected)
    assert distance(corners, np.array([[0.2, 0.2, 1.5]]), within=0.1) == np.inf


def test_what_is_wrong_is_seen() -> None:
    ball = {"name": "ball", "sphere": {"center": [0, 0, -0.2], "radius": 0.15}}
    rod = {"name": "rod", "capsule": {"from": [0.1, 0, -0.2], "to": [0.1, 0.1, -0.2], "radius": 0.1}}
    level = {**CLOTH, "grid": {**CLOTH["grid"], "axes": ["x", "y"], "origin": [-0.25, -0.25, 0.3]}}
    above = {**level, "translate": [0, 0, 0.1]}
    simulation = Simulation(Scene({"cloth": [level, above], "body": [FLOOR, ball, rod]}))
    oracle = Oracle(simulation)
    assert oracle.look(simulation).clean
    below = simulation.exact_positions
    for shift, expected in (
        (-0.25, (False, False, ())),
        (-0.4, (False, False, ("floor", "ball"))),
        (-0.55, (False, True, ("floor", "ball", "rod"))),
    ):
        simulation.positions = below + [0, 0, shift]
        seen = oracle.look(simulation)
        assert (seen.intersects, seen.crosses, seen.inside) == expected
    crossed = below.copy()
    crossed[: len(below) // 2, 2] = np.linspace(0.35, 0.45, len(below) // 2)
    simulation.positions = crossed
    assert oracle.look(simulation).intersects


def jerks(simulation: Simulation, vertices: slice = slice(None), frames: int = 30) -> float:
    """Second differences of some vertices from frame to frame, root mean square [m]."""
    places = []
    for _ in range(frames):
        simulation.step(simulation.substeps)
        places.append(simulation.exact_positions[vertices])
    return float(np.sqrt((np.linalg.norm(np.diff(places, 2, axis=0), axis=-1) ** 2).mean()))


@pytest.mark.parametrize("seed", [2, 3])
def test_cloth_on_a_corner_comes_to_rest_again_when_it_is_shaken(seed: int) -> None:
    simulation = stage("corner", 35, True).simulation(1)
    simulation.step(180 * simulation.substeps)
    shaken = np.random.default_rng(seed).normal(0, 0.2, simulation.velocities.shape)
    simulation.velocities = simulation.velocities + shaken.astype(np.float32)
    simulation.step(120 * simulation.substeps)
    assert jerks(simulation) < 2e-4


@pytest.mark.parametrize("mesh", [False, True])
@pytest.mark.parametrize(("gravity", "way"), [([1.7, 0.0, -9.66], 2.5e-3), ([0.17, 0.0, -9.808], 5e-4)])
def test_cloth_that_lies_still_follows_gravity_that_tilts(
    mesh: bool, gravity: list[float], way: float
) -> None:
    simulation = stage("ball", 25, mesh).simulation(1)
    simulation.step(240 * simulation.substeps)
    start = simulation.exact_positions
    simulation.gravity = gravity  # by 10 degrees, and by one
    simulation.step(30 * simulation.substeps)
    assert np.linalg.norm(simulation.exact_positions - start, axis=1).mean() > way
    simulation.step(120 * simulation.substeps)
    assert jerks(simulation) < 2e-5


def test_what_moves_elsewhere_does_not_shake_cloth_that_lies() -> None:
    def shaken(across: int) -> float:
        here = stage("corner", across, True)
        turn = {"axis": [0, 0, 1], "point": [3, 0, 0], "angle": [[0, 0], [100, 2000]]}
        here = here.body(ball([3, 0, 0.4], 0.3, friction=1.0, turn=turn))
        here = here.cloth("other", translate=[3, 0, 0.73], thickness=0.004, friction=1.0, **sheet(9, 0.4))
        simulation = here.simulation(1)
        simulation.step(330 * simulation.substeps)
        return jerks(simulation, slice(across**2))

    # One of them may slip just then.
    assert np.median([shaken(across) for across in (33, 34, 35)]) < 5e-5


@pytest.mark.parametrize(("on", "around", "speed"), [("corner", 35, 0.05), ("ball", 33, 0.3)])
def test_cloth_that_a_body_carries_along_lies_still_on_it(on: str, around: int, speed: float) -> None:
    def shaken(across: int) -> float:
        carried = stage(on, across, True)
        carried.document["body"][1]["move"] = [[3, [0, 0, 0]], [103, [0, 100 * speed, 0]]]
        simulation = carried.simulation(1)
        simulation.step(310 * simulation.substeps)
        before = simulation.exact_positions
        shaken = jerks(simulation)
        assert (simulation.exact_positions - before)[:, 1].mean() == pytest.approx(speed / 2, rel=0.01)
        return shaken

    # One of them may slip just then.
    assert np.median([shaken(across) for across in (around - 1, around, around + 1)]) < 5e-5


@pytest.mark.parametrize(("on", "mesh"), [("ball", True), ("ball", False), ("corner", True)])
def test_what_pushes_cloth_bears_its_weight(on: str, mesh: bool) -> None:
    simulation = stage(on, 33, mesh).simulation(1)
    simulation.step(240 * simulation.substeps)
    borne = []
    for _ in range(16):
        simulation.step(simulation.substeps)
        contacts = simulation.contacts
        borne.append((contacts.forces * contacts.normals[:, 2] + contacts.friction[:, 2]).sum())
    assert np.mean(borne) == pytest.approx(9.81 * simulation.mass.sum(), rel=0.1)


def test_a_ball_that_turns_takes_its_cloth_along() -> None:
    made = stage("spinning ball", 25, True)
    angles = [turned(made.simulation(1, solver={"substeps": substeps}), 150) for substeps in (1, 4)]
    assert angles[0] == pytest.approx(angles[1], rel=0.1)


@pytest.mark.parametrize(
    ("cells", "mesh", "room", "mu"), [(20, False, 0.9, 0.5), (20, True, 0.9, 0.1), (29, True, 0.5, 0.3)]
)
def test_what_two_bodies_grip_hangs_on_them_and_goes_with_them(
    cells: int, mesh: bool, room: float, mu: float
) -> None:
    simulation = pinched(cells, mesh, room, mu, up=0.2).simulation()
    between = let_go(simulation)
    before = simulation.exact_positions[between]
    simulation.run(30)
    assert np.abs(simulation.exact_positions[between] - before).max() < 1e-6
    simulation.run(65)
    assert np.abs(simulation.exact_positions[between] - before - [0, 0, 0.2]).max() < 1e-5


def test_what_has_no_friction_is_not_gripped() -> None:
    simulation = pinched(20, False, 0.9, 0.0).simulation()
    between = let_go(simulation)
    before = simulation.exact_positions[between]
    simulation.run(30)
    assert (simulation.exact_positions[between] - before)[:, 2].max() < -0.5


@pytest.mark.parametrize("cells", [6, 12])
def test_held_cloth_that_rises_lifts_other_cloth_at_its_thickness(cells: int) -> None:
    def square(name: str, across: int, size: float, height: float) -> dict[str, Any]:
        origin = [0.013 - size / 2, 0.013 - size / 2, height]
        grid = {"cells": [across, across], "size": [size, size], "origin": origin, "axes": ["x", "y"]}
        return {"name": name, "grid": grid, "density": 0.2, "strain_limit": 0.05, "thickness": 0.004}

    # Its two triangles are so large that each vertex of the other cloth has one row, with held ones alone.
    held = square("held", 1, 2.0, 0.0)
    held["pins"] = [{"box": [[-3, -3, -1], [3, 3, 1]], "move": [[0.0, [0, 0, 0]], [0.4, [0, 0, 0.5]]]}]
    simulation = Simulation(Scene({"cloth": [held, square("free", cells, 0.5, 0.01)]}))
    for _ in range(20):
        simulation.step()
        assert simulation.report.closest > 0.95 * 0.004
    heights = simulation.exact_positions[4:, 2] - simulation.exact_positions[0, 2]
    assert heights.min() < 1.05 * 0.004, "it has been lifted"


@pytest.mark.parametrize("mesh", [False, True])
def test_a_cloth_that_touches_but_itself_keeps_its_momentum(mesh: bool) -> None:
    fields = {"thickness": 0.01, "strain_limit": 0.01, "friction": 0.3, "air_drag": 0.0}
    scene = Stage({"fps": 60, "gravity": [0.0, 0.0, 0.0]}).cloth("sheet", **fields, **sheet(18, 0.5, mesh))
    simulation = scene.simulation()
    thrown = np.random.default_rng(5).normal([1.0, 2.0, 0.5], 0.5, simulation.positions.shape)
    simulation.set_state(simulation.exact_positions, thrown.astype(np.float32), 0)
    shares = simulation.mass / simulation.mass.sum()

    def gathers(positions: NDArray[np.float32], velocities: NDArray[np.float32], step: float) -> None:
        """Draws it together, without a momentum."""
        velocities += 2000.0 * step * (shares @ positions - positions)

    mean, contacts = shares @ simulation.velocities, 0
    for _ in range(45):
        contacts += simulation.step(simulation.substeps, hook=gathers).contacts
        np.testing.assert_allclose(shares @ simulation.velocities, mean, atol=1e-4)
    assert contacts > 10_000


@pytest.mark.parametrize("mesh", [False, True])
def test_weights_that_hang_over_a_rod_stop_bouncing(mesh: bool) -> None:
    """At 0.8 of the weight that slips; it bounced by 3 mm a frame, and slipped, in steps of one part."""
    simulation = strip(0.2, 0.077, mesh, CALMING).simulation()
    simulation.run(60)
    before = simulation.exact_positions
    for _ in range(30):
        simulation.run(1)
        moved = np.abs(simulation.exact_positions - before)[:, 2].max()
        before = simulation.exact_positions
        assert moved < 2e-4


@pytest.mark.parametrize("integrator", ["rk4", "verlet", "midpoint"])
def test_steps_that_blow_up_are_told_and_leave_no_trace(integrator: str) -> None:
    stiff = CLOTH | {"stiffness": 1e6, "name": "sheet"}
    solver = {"integrator": integrator, "substeps": 6, "force_step": True}
    simulation = Simulation(Scene({"cloth": [stiff], "body": [FLOOR], "solver": solver}))
    with pytest.raises(SimulationError, match='cloth "sheet".*no longer at a finite place'):
        simulation.run(60)
    assert np.isfinite(simulation.positions).all()
