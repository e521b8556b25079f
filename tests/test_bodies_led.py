"""Bodies whose poses and vertices are told while a simulation runs."""

import pickle
from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation

BALL = {"name": "ball", "sphere": {"center": [0, 0, -0.3], "radius": 0.2}}
BOX = {"name": "box", "box": {"center": [0, 0, -0.3], "size": [0.4, 0.2, 0.2]}}
FLOOR = {"name": "floor", "plane": {"point": [0, 0, -0.5], "normal": [0, 0, 1]}}
TURNING = BOX | {"turn": {"axis": [0, 0, 1], "point": [1, 0, 0], "angle": [[1.0, 90.0]]}}


def simulation(*bodies: dict[str, Any], height: float = 0.0) -> Simulation:
    grid = {"size": [1, 1], "cells": [12, 12], "origin": [-0.5, -0.5, height], "axes": ["x", "y"]}
    pins = [{"corner": at} for at in ("top-left", "top-right", "bottom-left", "bottom-right")]
    cloth = {"grid": grid, "thickness": 0.004, "pins": pins}
    return Simulation(Scene({"fps": 60, "body": list(bodies), "cloth": [cloth]}), threads=1)


def test_a_box_turns_about_its_middle() -> None:
    turned = simulation(BOX, height=1.0)
    start = turned.bodies["box"].positions.copy()
    turned.pose_body("box", (0, 0, 0.1), (0, 0, np.pi / 2))
    middle, quarter = np.array([0, 0, -0.3]), np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    expected = (start - middle) @ quarter.T + middle + [0, 0, 0.1]
    np.testing.assert_allclose(turned.bodies["box"].positions, expected, atol=1e-12)
    np.testing.assert_allclose(turned.body_offset("box"), [0, 0, 0.1], atol=1e-12)
    # Half of the way back, evenly; shifted, it stays turned.
    turned.pose_body("box", (0, 0, 0), (0, 0, 0), over=0.5)
    turned.run(15)
    half = np.array([[1, -1, 0], [1, 1, 0], [0, 0, 2**0.5]]) / 2**0.5
    expected = (start - middle) @ half.T + middle + [0, 0, 0.05]
    np.testing.assert_allclose(turned.bodies["box"].positions, expected, atol=1e-6)
    turned.shift_body("box", (0, 0, 0))
    np.testing.assert_allclose(turned.bodies["box"].positions, (start - middle) @ half.T + middle, atol=1e-6)


def test_a_plane_turns_about_its_point() -> None:
    turned = simulation(FLOOR, height=1.0)
    turned.pose_body("floor", (0, 0, 0), (np.pi / 2, 0, 0))
    np.testing.assert_allclose(turned.bodies["floor"].positions, [[0, 0, -0.5], [0, -1, -0.5]], atol=1e-12)


def test_a_pose_comes_on_top_of_the_path_of_the_scene() -> None:
    alone, posed = simulation(TURNING, height=1.0), simulation(TURNING, height=1.0)
    posed.pose_body("box", (0.1, 0, 0), (0, 0, np.pi))
    alone.run(30)
    posed.run(30)
    expected = alone.bodies["box"].positions
    expected = 2 * expected.mean(axis=0) * [1, 1, 0] + expected * [-1, -1, 1] + [0.1, 0, 0]
    np.testing.assert_allclose(posed.bodies["box"].positions, expected, atol=1e-9)


@pytest.mark.parametrize("way", ["pose", "vertices"])
def test_a_body_that_is_led_lifts_the_cloth_and_crosses_nothing(way: str) -> None:
    lifted = simulation(BOX)
    start = lifted.bodies["box"].positions.copy()
    for frame in range(1, 41):
        turn, rise = 0.02 * frame, np.array([0, 0, 0.01 * frame])
        if way == "pose":
            lifted.pose_body("box", rise, (turn, 0, 0), over=1 / 60)
        else:
            lifted.set_body_vertices("box", start * (1 + 0.005 * frame) + rise, over=1 / 60)
        lifted.run(1)
        assert not lifted.intersections()
    assert lifted.positions[:, 2].max() > 0.1
    assert lifted.contacts.forces.sum() > 0


def test_a_ball_that_turns_carries_cloth_along_by_friction() -> None:
    def spun(rotation: float) -> float:
        grid = {"size": [0.2, 0.2], "cells": [8, 8], "origin": [-0.1, -0.1, 0.003], "axes": ["x", "y"]}
        cloth = {"grid": grid, "thickness": 0.004}
        ball = {"name": "ball", "sphere": {"center": [0, 0, -0.5], "radius": 0.5}, "friction": 0.5}
        spun = Simulation(Scene({"fps": 60, "body": [ball], "cloth": [cloth]}), threads=1)
        spun.run(10)
        spun.pose_body("ball", (0, 0, 0), (0, rotation, 0), over=0.25)
        spun.run(15)
        return float(spun.positions[:, 0].mean())

    assert spun(0.1) == pytest.approx(0.05, rel=0.2)
    assert abs(spun(0.0)) < 1e-3


def test_what_was_told_is_kept() -> None:
    led = simulation(BALL, BOX, height=1.0)
    target = led.bodies["box"].positions + [0.2, 0, 0]
    led.set_body_vertices("box", target, over=0.5)
    led.pose_body("ball", (0, 0, 0.1), (0, 0, 1.0), over=0.5)
    led.run(15)
    again, snapshot = pickle.loads(pickle.dumps(led)), led.snapshot()
    led.run(15)
    again.run(15)
    np.testing.assert_array_equal(led.body_positions, again.body_positions)
    np.testing.assert_allclose(led.bodies["box"].positions, target, atol=1e-12)
    led.restore(snapshot)
    np.testing.assert_allclose(led.bodies["box"].positions, target - [0.1, 0, 0], atol=1e-6)
    led.shift_body("box", (0, 0.3, 0))
    np.testing.assert_allclose(led.body_offset("box"), [0, 0.3, 0], atol=1e-9)
    # A state that is set knows nothing of ways: bodies are where they were to go.
    led.set_state(led.positions, led.velocities, 0)
    np.testing.assert_allclose(led.bodies["box"].positions, target + [0, 0.3, 0], atol=1e-9)
    np.testing.assert_allclose(led.bodies["ball"].positions, [[0, 0, -0.2]], atol=1e-9)


@pytest.mark.parametrize(
    ("method", "arguments", "error", "words"),
    [
        ("pose_body", ("box", (0, 0, 0), (0, 0, 0)), KeyError, "body = 'box': must be one of"),
        ("pose_body", ("ball", (0, 0), (0, 0, 0)), ValueError, "offset = .*three finite numbers"),
        ("pose_body", ("ball", (0, 0, 0), (0, np.nan, 0)), ValueError, "rotation = .*three finite numbers"),
        ("pose_body", ("ball", (0, 0, 0), 1.0), ValueError, "rotation = .*shape"),
        ("pose_body", ("ball", (0, 0, 0), (0, 0, 0), -1), ValueError, "over"),
        (
            "set_body_vertices",
            ("ball", [[0, 0, 0]] * 2),
            ValueError,
            r"positions has shape \(2, 3\): must be",
        ),
        ("set_body_vertices", ("ball", [[0, np.inf, 0]]), ValueError, r"positions\[0\] is not finite"),
        ("set_body_vertices", ("ball", [["x"] * 3]), TypeError, "positions = "),
        ("set_body_vertices", ("ball", [[0, 0, 0]], np.nan), ValueError, "over"),
    ],
)
def test_what_cannot_be_told_is_refused(
    method: str, arguments: Any, error: type[Exception], words: str
) -> None:
    asked = simulation(BALL, FLOOR)
    before = asked.body_positions
    with pytest.raises(error, match=words):
        getattr(asked, method)(*arguments)
    np.testing.assert_array_equal(asked.body_positions, before)
