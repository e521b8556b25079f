"""What comes with a step: wind, gravity, held vertices, its length; and what is left after a failure."""

import signal
import struct
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Scene, SceneError, Simulation, SimulationError, _taut

from tests.attack.leaks import leak

TIP = 34


@pytest.fixture
def scene() -> dict[str, Any]:
    return {
        "fps": 60.0,
        "cloth": [
            {
                "grid": {"size": [0.6, 0.4], "cells": [6, 4], "axes": ["x", "z"]},
                "density": 0.2,
                "pins": [{"edge": "left"}],
            }
        ],
    }


@pytest.fixture
def simulation(scene: dict[str, Any]) -> Simulation:
    return Simulation(Scene(scene), threads=1)


def test_wind_comes_and_goes_as_if_the_scene_had_said_so(scene: dict[str, Any]) -> None:
    gusty = {"velocity": [3.0, 1.0, 0.0], "gust": {"seed": 7}}
    given, told = Simulation(Scene({**scene, "wind": gusty})), Simulation(Scene(scene))
    assert told.wind is None
    told.wind = gusty
    assert told.wind == given.wind
    given.step(20)
    told.step(20)
    assert told.state_hash == given.state_hash
    push = told.external_forces()[:, 1].sum()
    told.wind = [0.0, 9.0, 0.0]
    assert told.external_forces()[:, 1].sum() > push
    assert told.wind is not None
    assert told.wind["velocity"] == [0, 9, 0]
    assert told.wind["gust"]["seed"] == 7, "what else there is of the wind stays"
    told.step(30)
    told.wind = None
    assert told.wind is None
    told.step(30)


def test_gravity_turns(simulation: Simulation) -> None:
    assert simulation.gravity == (0, 0, -9.81)
    simulation.gravity = (0.0, 4.0, 0.0)
    assert simulation.gravity == (0, 4, 0)
    simulation.step(5)
    assert simulation.velocities[TIP, 1] > 0.1
    assert abs(simulation.velocities[TIP, 2]) < 0.01


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("wind", [1.0, 2.0], ["wind", "three finite numbers"]),
        ("wind", [1.0, np.nan, 0.0], ["wind", "finite"]),
        ("wind", {"velocity": [1e9, 0, 0]}, ["wind.velocity", "1e4|10000"]),
        ("wind", {"speed": 3}, ["speed", "wind"]),
        ("wind", {"gust": {"period": -1.0}}, ["wind.gust.period = -1"]),
        ("gravity", [0.0, 0.0], ["gravity", "three finite numbers"]),
        ("gravity", [0.0, 0.0, np.inf], ["gravity", "finite"]),
        ("gravity", [0.0, 0.0, 1e9], ["gravity"]),
    ],
)
def test_what_is_no_wind_or_gravity_is_refused(
    simulation: Simulation, name: str, value: Any, words: list[str]
) -> None:
    before = simulation.wind, simulation.gravity
    for word in words:
        with pytest.raises((ValueError, SceneError), match=word):
            setattr(simulation, name, value)
    assert (simulation.wind, simulation.gravity) == before


def test_held_vertices_go_where_they_are_told_and_fall_when_let_go(simulation: Simulation) -> None:
    corners = [6, TIP]
    start = simulation.positions[corners].copy()
    simulation.hold(corners, start)
    assert simulation.held.tolist() == corners
    simulation.step(60)
    np.testing.assert_array_equal(simulation.positions[corners], start)
    simulation.hold(TIP, start[1] + [0.0, 0.1, 0.0], over=10 * simulation.step_length)
    simulation.step(5)
    np.testing.assert_allclose(simulation.positions[TIP], start[1] + [0.0, 0.05, 0.0], atol=1e-6)
    simulation.step(5)
    np.testing.assert_allclose(simulation.positions[TIP], start[1] + [0.0, 0.1, 0.0], atol=1e-6)
    simulation.release(corners)
    assert simulation.held.tolist() == []
    simulation.step(30)
    assert simulation.positions[TIP, 2] < start[1, 2] - 0.05


def test_a_pinned_vertex_leaves_its_path_while_it_is_held(simulation: Simulation) -> None:
    home = simulation.positions[0].copy()
    simulation.hold([0], [home + [0.02, 0.0, 0.02]])
    simulation.step(3)
    np.testing.assert_allclose(simulation.positions[0], home + [0.02, 0.0, 0.02], atol=1e-6)
    simulation.release(0)
    simulation.step(3)
    np.testing.assert_array_equal(simulation.positions[0], home)


def test_a_snapshot_has_what_is_held(simulation: Simulation, scene: dict[str, Any]) -> None:
    simulation.hold([TIP, 10], simulation.positions[[TIP, 10]] + np.float32([0.0, 0.05, 0.0]), over=0.4)
    simulation.lead(20, (0.3, 0.2, 0.2), speed=1.0)
    simulation.shift_pins(0, (0.0, 0.0, 0.3), speed=0.5)
    simulation.step(7)
    snapshot = simulation.snapshot()
    simulation.step(40)
    other = Simulation(Scene(scene), threads=2)
    other.restore(snapshot)
    assert other.held.tolist() == [10, TIP]
    other.step(40)
    assert other.state_hash == simulation.state_hash
    np.testing.assert_array_equal(other.pin_offset(0), simulation.pin_offset(0))


@pytest.mark.parametrize(
    ("vertices", "targets", "error", "words"),
    [
        ([35], [[0, 0, 0]], IndexError, "vertex = 35: there are 35"),
        ([-1], [[0, 0, 0]], IndexError, "vertex = -1"),
        ([0.5], [[0, 0, 0]], TypeError, "must be integers"),
        ([1, 2], [[0, 0, 0]], ValueError, r"targets has shape \(1, 3\): must be \(2, 3\)"),
        ([1], [[0, 0, np.nan]], ValueError, r"targets\[0\] is not finite"),
        ([[1, 2]], [[0, 0, 0]], ValueError, "vertices has shape"),
    ],
)
def test_what_cannot_be_held_is_refused(
    simulation: Simulation, vertices: Any, targets: Any, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        simulation.hold(vertices, targets)
    assert simulation.held.tolist() == []
    with pytest.raises(ValueError, match="over = -1"):
        simulation.hold(0, (0, 0, 0), over=-1.0)


def test_steps_have_any_length_that_springs_bear(simulation: Simulation) -> None:
    simulation.step(3, dt=0.002)
    simulation.step(2, dt=0.011)
    simulation.step(1)
    assert simulation.time == pytest.approx(0.006 + 0.022 + simulation.step_length, abs=1e-15)
    assert simulation.steps == 6
    for dt in (0.0, -0.1, 1e-50, float("nan"), float("inf"), 1e9):
        with pytest.raises(ValueError, match="dt = .*must be 1e-12 s or more.* and at most"):
            simulation.step(1, dt=dt)
    assert simulation.steps == 6


def test_nothing_of_a_failed_step_is_left(simulation: Simulation) -> None:
    simulation.step(10)
    snapshot = simulation.snapshot()
    simulation.step(10)
    expected = simulation.state_hash
    for speed in (1e22, 1e26, 1e30):
        simulation.restore(snapshot)
        simulation.velocities = np.full_like(simulation.velocities, speed)
        with pytest.raises(SimulationError):
            simulation.step()
        simulation.restore(snapshot)
        simulation.step(10)
        assert simulation.state_hash == expected


def test_a_long_call_answers_ctrl_c_and_leaves_the_state_before_it(simulation: Simulation) -> None:
    # What starts tests in the background may have it ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    simulation.step(10)
    before = simulation.state_hash, simulation.time
    interrupt = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    interrupt.start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        simulation.step(10**7)
    assert time.monotonic() - start < 0.3 + 0.5
    interrupt.join()
    assert (simulation.state_hash, simulation.time) == before
    simulation.step()


@pytest.mark.parametrize("threads", [1, 3])
def test_a_panic_in_the_engine_is_an_error_and_the_simulation_goes_on(
    scene: dict[str, Any], threads: int
) -> None:
    simulation, other = (Simulation(Scene(scene), threads=threads) for _ in range(2))
    simulation.step(5)
    snapshot, before = simulation.snapshot(), simulation.state_hash
    simulation.step(5)
    expected = simulation.state_hash
    simulation.restore(snapshot)
    _taut.break_next_step()
    with pytest.raises(SimulationError, match=r"broke down \(broken for a test\).* can go on"):
        simulation.step(5)
    assert simulation.state_hash == before
    simulation.step(5)
    other.step(10)
    assert simulation.state_hash == other.state_hash == expected


def test_what_rounding_takes_from_the_momentum_is_told(scene: dict[str, Any]) -> None:
    (cloth,) = scene["cloth"]
    free = Simulation(
        Scene({**scene, "gravity": [0, 0, 0], "cloth": [{**cloth, "pins": [], "air_drag": 0.0}]})
    )
    free.velocities = np.random.default_rng(1).normal(size=free.velocities.shape).astype(np.float32)
    told = np.array([free.step(60).repaired_momentum, free.step(60).repaired_momentum])
    size = free.mass @ np.abs(free.velocities)
    assert np.all(np.abs(told) < 1e-5 * size) and np.any(told != 0)


def test_a_signal_handler_that_would_wait_for_ever_is_told_so(simulation: Simulation) -> None:
    before = simulation.steps

    def look(*_: object) -> None:
        _ = simulation.steps

    usual = signal.signal(signal.SIGINT, look)
    interrupt = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])
    interrupt.start()
    try:
        with pytest.raises(BaseException, match="signal handler must not use"):
            simulation.step(10**7)
    finally:
        signal.signal(signal.SIGINT, usual)
        interrupt.join()
    assert simulation.steps == before


def test_simulations_of_one_process_share_their_threads(scene: dict[str, Any]) -> None:
    def threads() -> int:
        with open("/proc/self/status") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("Threads:"))

    try:
        before = threads()
    except FileNotFoundError:
        pytest.skip("threads can be counted on Linux only")
    simulations = [Simulation(Scene(scene), threads=3) for _ in range(10)]
    assert threads() <= before + 3
    # All of them at once, each with the bits that it has alone.
    runners = [threading.Thread(target=simulation.step, args=[50]) for simulation in simulations]
    for runner in runners:
        runner.start()
    for runner in runners:
        runner.join()
    alone = Simulation(Scene(scene), threads=1)
    alone.step(50)
    assert {simulation.state_hash for simulation in simulations} == {alone.state_hash}


def places(frames: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The left edge of the cloth, row by row, raised by 1 cm a frame and leaning over."""
    edge = np.array([[0.0, 0.0, 0.1 * row] for row in range(5)])
    ways = np.array([[0.005 * frame, 0.0, 0.01 * frame] for frame in range(frames)])
    return edge[None] + ways[:, None]


@pytest.mark.parametrize("kind", ["array", "npy", "pc2"])
def test_pins_follow_an_array(scene: dict[str, Any], kind: str, tmp_path: Path) -> None:
    path = places(7)
    name = f"path.{'npy' if kind == 'array' else kind}"
    scene["cloth"][0]["pins"] = [{"edge": "left", "follow": name}]
    given = None
    if kind == "array":
        given = {name: path}
    elif kind == "npy":
        np.save(tmp_path / name, path)
    else:
        head = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, 5, 0.0, 1.0, 7)
        (tmp_path / name).write_bytes(head + path.astype("<f4").tobytes())
    simulation = Simulation(Scene(scene, folder=tmp_path, paths=given), threads=1)
    pins = simulation.pin_groups[0]
    for frame in range(1, 10):
        simulation.run(1)
        np.testing.assert_allclose(simulation.positions[pins], path[min(frame, 6)], atol=1e-6)
    assert simulation.paths[name][0].shape == (7, 5, 3)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("path.npy", None, "there is no file"),
        ("path.txt", b"1 2 3", "must be an .npy or .pc2 file"),
        ("path.npy", b"nonsense", "is cut short, damaged, or holds objects; write it again"),
        ("path.npy", b"\x93NUMPY\x01\x00v\x00{'descr': '<f8'", "is cut short, damaged, or holds objects"),
        (
            "path.npy",
            np.full((3, 5, 3), 1e300),
            r"at \[1e300, .*\] in frame 0; .* within 1e9 m of the origin",
        ),
        ("path.npy", np.full((3, 5, 3), np.nan), r"at \[NaN, .*finite numbers"),
        ("path.pc2", b"nonsense", "is not a PC2 file"),
        ("path.npy", np.zeros((3, 5)), r"has shape \(3, 5\)"),
        ("path.npy", np.zeros((3, 4, 3)), "places of 4 vertices, the pin holds 5"),
        ("path.npy", np.zeros((3, 5, 3)), "at time 0 a pin is where the cloth is"),
    ],
)
def test_paths_that_cannot_be_followed_are_refused(
    scene: dict[str, Any], name: str, content: Any, words: str, tmp_path: Path
) -> None:
    scene["cloth"][0]["pins"] = [{"edge": "left", "follow": name}]
    if isinstance(content, bytes):
        (tmp_path / name).write_bytes(content)
    elif content is not None:
        np.save(tmp_path / name, content)
    with pytest.raises(SceneError, match=words) as caught:
        Simulation(Scene(scene, folder=tmp_path))
    assert f"cloth[0].pins[0].follow = {name!r}" in str(caught.value).replace('"', "'")
    assert leak(caught.value) is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gravity_keyframes": [[0.0, [0, 0, 0]]]}, r"gravity_keyframes\[0\] = 0: times must be above 0"),
        ({"wind": {"keyframes": [[1, [1, 0, 0]], [1, [2, 0, 0]]]}}, r"wind.keyframes\[1\] = 1: times must"),
        ({"wind": {"keyframes": [[1, [1e9, 0, 0]]]}}, r"wind.keyframes\[0\]"),
    ],
)
def test_keyframes_out_of_order_are_refused(scene: dict[str, Any], change: Any, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        Scene({**scene, **change})


def test_a_strain_limit_that_tightens_is_kept(scene: dict[str, Any]) -> None:
    cloth = scene["cloth"][0]
    cloth |= {"strain_limit": 0.12, "strain_limit_keyframes": [[1.0, 0.02]], "stiffness": 2.0}
    simulation = Simulation(Scene(scene), threads=1)
    for frame in range(1, 90):
        limit = max(0.02, 0.12 - 0.1 * frame / 60)
        assert simulation.run(1).worst_stretch <= limit + 1e-4
    with pytest.raises(SceneError, match=r"strain_limit_keyframes\[0\] = 2"):
        Scene({**scene, "cloth": [{**cloth, "strain_limit_keyframes": [[1.0, 2.0]]}]})


def test_pins_of_a_scene_turn_about_a_line_and_then_move(scene: dict[str, Any]) -> None:
    turn = {"axis": [0, 0, 1], "point": [0, 0, 0], "angle": [[0, 0], [1, 90]]}
    scene["cloth"][0]["grid"]["origin"] = [0.5, 0.0, 0.0]
    scene["cloth"][0]["pins"] = [{"edge": "left", "turn": turn, "move": [[1, [0, 0, 0.2]]]}]
    made = Scene(scene)
    assert made.document["cloth"][0]["pins"][0]["turn"]["angle"] == [[0, 0], [1, 90]]
    assert Scene(made.document).document == made.document
    simulation = Simulation(made, threads=1)
    heights = simulation.positions[simulation.pinned, 2].astype(np.float64)
    for frame in range(1, 70):
        simulation.run(1)
        time = min(frame / 60, 1.0)
        angle = np.radians(90 * time)
        expected = np.stack(
            [0.5 * np.cos([angle] * 5), 0.5 * np.sin([angle] * 5), heights + 0.2 * time], axis=-1
        )
        np.testing.assert_allclose(simulation.positions[simulation.pinned], expected, atol=2e-7)
