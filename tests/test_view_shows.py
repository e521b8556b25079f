"""The viewer's shows: a scene that runs and is changed meanwhile, recordings in lock-step."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from taut import Cache, Scene, Simulation, record
from taut.view import wire
from taut.view.controls import controls
from taut.view.live import LiveShow
from taut.view.playback import PlaybackShow
from viewing import order, picture, settle, status, unpack, value

HOLD = 20
"""A free vertex of the flag."""


def test_a_show_runs_like_the_simulation_of_its_scene(show: LiveShow, flag: dict[str, Any]) -> None:
    simulation = Simulation(Scene(flag))
    settle(show, 9)
    simulation.step(10 * simulation.substeps)
    header, arrays = picture(show)
    assert np.array_equal(arrays["positions0"], simulation.positions)
    assert header["frame"] == 10 and header["time"] == pytest.approx(simulation.time)
    assert header["panels"][0]["worst"] == simulation.report.worst_stretch
    layout, fixed = unpack(show.board.layout)
    assert np.array_equal(fixed["faces0"], simulation.faces)
    assert np.array_equal(fixed["springs0"], simulation.springs[simulation.spring_kind < 2])
    assert [vertex for group in layout["meshes"][0]["pins"] for vertex in group] == np.flatnonzero(
        simulation.pinned
    ).tolist()


def test_time_stands_still_steps_and_starts_again(show: LiveShow) -> None:
    settle(show, 4)
    order(show, {"type": "play", "on": False})
    settle(show, 3)
    assert picture(show)[0]["frame"] == 5
    order(show, {"type": "step"})
    settle(show, 3)
    assert picture(show)[0]["frame"] == 6
    order(show, {"type": "reset"})
    settle(show)
    header, arrays = picture(show)
    assert header["frame"] == 0 and header["time"] == 0
    assert np.array_equal(arrays["positions0"], unpack(show.board.layout)[1]["rest0"])


def test_what_is_changed_goes_on_from_the_same_state(show: LiveShow) -> None:
    settle(show, 20)
    order(show, {"type": "play", "on": False})
    settle(show)
    before = show.simulations[0]
    positions, velocities = before.positions.copy(), before.velocities.copy()
    order(show, {"type": "set", "control": "wind_speed", "value": 3})
    order(show, {"type": "set", "control": "fabric", "value": "wool"})
    settle(show)
    after = show.simulations[0]
    assert after is not before and after.time == pytest.approx(before.time)
    assert np.array_equal(after.positions, positions) and np.array_equal(after.velocities, velocities)
    document = after.scene.document
    assert np.linalg.norm(document["wind"]["velocity"]) == pytest.approx(3)
    assert document["cloth"][0]["fabric"] == "wool" and document["cloth"][0]["density"] == 0.25


def test_every_control_goes_from_end_to_end_and_nothing_stops(show: LiveShow) -> None:
    for name, control in controls().items():
        for at in control.choices or (control.low, control.high, 0.5 * (control.low + control.high)):
            order(show, {"type": "set", "control": name, "value": at})
            frame = picture(show)[0]["frame"]
            settle(show, 2)
            assert picture(show)[0]["frame"] > frame, f"{name} = {at}: {status(show)['note']}"
            assert np.isfinite(picture(show)[1]["positions0"]).all()


def test_a_control_refuses_what_it_cannot_be(show: LiveShow) -> None:
    for name, wrong in {
        "limit": 0,
        "filter": "wishes",
        "gravity": "heavy",
        "luck": 1,
        "wind_speed": 1e6,
    }.items():
        order(show, {"type": "set", "control": name, "value": wrong})
        settle(show)
        assert name in status(show)["note"][1] and "must be" in status(show)["note"][1]


def test_a_scene_that_cannot_be_built_is_refused_and_the_old_one_goes_on(show: LiveShow) -> None:
    order(show, {"type": "set", "control": "filter", "value": "none"})
    settle(show)
    order(show, {"type": "set", "control": "substeps", "value": 1})
    settle(show, 3)
    assert "solver.substeps" in status(show)["note"][1]
    assert value(show, "substeps") == 0 and value(show, "filter") == "none"
    assert show.simulations[0].substeps > 1


def test_a_tighter_limit_holds_at_once_and_the_cloth_moves_on(show: LiveShow) -> None:
    order(show, {"type": "set", "control": "filter", "value": "none"})
    order(show, {"type": "set", "control": "wind_speed", "value": 40})
    settle(show, 60)
    assert picture(show)[0]["panels"][0]["worst"] > 0.2
    for limit in (10, 1):
        order(show, {"type": "set", "control": "filter", "value": "coarse_to_fine"})
        order(show, {"type": "set", "control": "limit", "value": limit})
        settle(show)
        before = picture(show)[1]["positions0"]
        for _ in range(20):
            show.turn()
            assert picture(show)[0]["panels"][0]["worst"] <= 0.01 * limit * (1 + 1e-4)
        assert np.abs(picture(show)[1]["positions0"] - before).max() > 0.01
    assert value(show, "limit") == pytest.approx(1)


def test_a_hand_leads_a_vertex_within_the_limit_and_lets_it_go(show: LiveShow) -> None:
    settle(show, 5)
    start = show.simulations[0].positions[HOLD].astype(float)
    near = start + [-0.2, -0.3, 0.2]
    order(show, {"type": "grab", "vertex": HOLD, "target": near.tolist()})
    settle(show, 40)
    assert np.linalg.norm(show.simulations[0].positions[HOLD] - near) < 0.01
    assert picture(show)[0]["held"] == [HOLD]
    rng = np.random.default_rng(3)
    for _ in range(60):
        far = (start + rng.uniform(-4, 4, 3)).tolist()
        order(show, {"type": "grab", "vertex": HOLD, "target": far})
        show.turn()
        assert picture(show)[0]["panels"][0]["worst"] <= 0.04 * (1 + 1e-4)
    order(show, {"type": "release"})
    settle(show, 5)
    assert picture(show)[0]["held"] == []
    assert show.simulations[0].scene.document["cloth"][0].get("weights", []) == []


def test_hands_do_not_add_up(show: LiveShow) -> None:
    own = show.simulations[0].mass.sum()
    for _ in range(3):
        order(show, {"type": "grab", "vertex": HOLD, "target": [1, 0, 1]})
        order(show, {"type": "grab", "vertex": HOLD - 1, "target": [1, 0, 1]}, client=2)
        settle(show)
        assert show.simulations[0].mass.sum() == pytest.approx(2 * own)
        order(show, {"type": "release"})
        settle(show)
    assert show.simulations[0].mass.sum() == pytest.approx(1.5 * own)


def test_a_pin_is_moved_and_comes_back_with_a_reset(show: LiveShow) -> None:
    group = show.simulations[0].pin_groups[0]
    start = show.simulations[0].positions[group].copy()
    order(show, {"type": "pin", "group": 0, "target": (start[0] + [0, 0.3, 0.2]).tolist()})
    settle(show, 60)
    assert show.simulations[0].positions[group] == pytest.approx(start + np.float32([0, 0.3, 0.2]), abs=1e-5)
    order(show, {"type": "pin", "group": 0, "target": (start[0] + [0, -0.3, 0]).tolist()})
    order(show, {"type": "set", "control": "gravity", "value": 5})
    settle(show, 60)
    assert show.simulations[0].positions[group] == pytest.approx(start + np.float32([0, -0.3, 0]), abs=1e-5)
    order(show, {"type": "reset"})
    settle(show, 3)
    assert show.simulations[0].positions[group] == pytest.approx(start, abs=1e-6)


@pytest.mark.parametrize(
    "wrong",
    [
        {"type": "grab", "vertex": 10**6, "target": [0, 0, 0]},
        {"type": "grab", "vertex": 0, "target": [0, 0, 0]},
        {"type": "pin", "group": 5, "target": [0, 0, 0]},
        {"type": "seek", "frame": 3},
        {"type": "loop", "on": True},
    ],
)
def test_orders_for_what_is_not_there_are_refused(show: LiveShow, wrong: dict[str, Any]) -> None:
    order(show, wrong)
    settle(show, 2)
    assert status(show)["note"][1] and picture(show)[0]["frame"] == 3


def test_side_by_side_the_bare_cloth_stretches_further(show: LiveShow) -> None:
    order(show, {"type": "set", "control": "wind_speed", "value": 30})
    order(show, {"type": "compare", "on": True})
    settle(show, 40)
    with_limit, bare = picture(show)[0]["panels"]
    assert with_limit["limited"] and not bare["limited"]
    assert with_limit["worst"] <= 0.04 * (1 + 1e-4) < 0.1 < bare["worst"]
    assert picture(show)[1].keys() == {"positions0", "positions1"}
    order(show, {"type": "compare", "on": False})
    settle(show)
    assert len(picture(show)[0]["panels"]) == 1


@pytest.mark.parametrize("up", ["y", "z"])
def test_the_wind_blows_where_its_controls_say(flag: dict[str, Any], up: str) -> None:
    flag |= {"up": up, "wind": {"velocity": [0, 0, 0]}}
    document = Scene(flag).document
    scene = Scene(flag)
    for name, at in {"wind_speed": 10, "wind_heading": 90, "wind_climb": 30}.items():
        scene = scene.with_settings(controls()[name].write(scene.document, at))
    horizontal, vertical = 10 * np.cos(np.radians(30)), 5.0
    expected = [0, horizontal, vertical] if up == "z" else [0, vertical, -horizontal]
    assert scene.document["wind"]["velocity"] == pytest.approx(expected, abs=1e-9)
    for name, at in {"wind_speed": 10, "wind_heading": 90, "wind_climb": 30}.items():
        assert controls()[name].read(scene.document) == pytest.approx(at)
    assert controls()["wind_speed"].read(document) == 0


NUMBERS = st.floats(-30, 30, allow_nan=False)
PLACES = st.tuples(NUMBERS, NUMBERS, NUMBERS)
VALUES = st.sampled_from(
    [
        wire.Set(control.name, at)
        for control in controls().values()
        for at in (*control.choices, control.low, control.high, "?", 0.3 * control.low + 0.7 * control.high)
    ]
)
ORDERS = st.one_of(
    VALUES,
    st.builds(wire.Grab, st.integers(0, 40), PLACES),
    st.builds(wire.Pin, st.integers(0, 3), PLACES),
    st.builds(wire.Compare, st.booleans()),
    st.sampled_from([wire.Release(), wire.Reset(), wire.Step(), wire.Play(True), wire.Seek(3)]),
)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.integers(1, 2), ORDERS), max_size=12))
def test_whatever_pages_order_the_show_goes_on(
    flag: dict[str, Any], orders: list[tuple[int, wire.Order]]
) -> None:
    flag["cloth"][0]["pins"] = [{"corner": "top-left"}, {"corner": "bottom-left"}, {"nearest": [0.7, 0, 1.5]}]
    show = LiveShow(Scene(flag), threads=1)
    for client, one in orders:
        show.mail.put(client, one)
        show.turn()
        show.turn()
    show.mail.put(1, wire.Play(True))
    settle(show)
    frame = picture(show)[0]["frame"]
    show.turn()
    header, arrays = picture(show)
    assert header["frame"] == frame + 1 and np.isfinite(arrays["positions0"]).all()
    if header["panels"][0]["name"] == "coarse_to_fine":
        limit = header["panels"][0]["limits"][0]
        assert header["panels"][0]["worst"] <= limit + 1e-4 * (1 + limit)


# Recordings.


@pytest.fixture
def pair(flag: dict[str, Any], recorded: Path, tmp_path: Path) -> PlaybackShow:
    """The recorded flag (30 frames) and its first 10 frames without a limit."""
    flag["solver"] = {"filter": "none"}
    record(Simulation(Scene(flag)), tmp_path / "bare.zarr", 10)
    return PlaybackShow([Cache.open(recorded), Cache.open(tmp_path / "bare.zarr")])


def test_recordings_play_in_lock_step(pair: PlaybackShow) -> None:
    frames = [cache.frames for cache in pair._caches]
    assert frames == [30, 10] and status(pair)["frames"] == 30
    order(pair, {"type": "seek", "frame": 7})
    pair.turn(0.0)
    pair.turn(0.0)
    header, arrays = picture(pair)
    assert header["frame"] == 7
    for index, cache in enumerate(pair._caches):
        assert np.array_equal(arrays[f"positions{index}"], cache.positions(7))
    pair.turn(1.02 * 10 / 60)
    header, arrays = picture(pair)
    assert header["frame"] == 17
    assert np.array_equal(arrays["positions1"], pair._caches[1].positions(9)), (
        "the shorter one waits at its end"
    )


def test_recordings_loop_stop_and_go_slower(pair: PlaybackShow) -> None:
    order(pair, {"type": "seek", "frame": 28})
    pair.turn(5.0)
    pair.turn(5.0 + 2.5 / 60)
    assert picture(pair)[0]["frame"] == 0 and status(pair)["playing"]
    order(pair, {"type": "loop", "on": False})
    order(pair, {"type": "seek", "frame": 28})
    pair.turn(6.0)
    pair.turn(7.0)
    assert picture(pair)[0]["frame"] == 29 and not status(pair)["playing"]
    order(pair, {"type": "play", "on": True})
    order(pair, {"type": "speed", "value": 0.25})
    pair.turn(8.0)
    pair.turn(8.0 + 4.1 * 4 / 60)
    assert picture(pair)[0]["frame"] == 4
    order(pair, {"type": "grab", "vertex": 1, "target": [0, 0, 0]})
    pair.turn(9.0)
    assert "recording" in status(pair)["note"][1]


def test_a_damaged_frame_is_named_and_the_others_are_shown(copied: Path) -> None:
    (copied / "positions" / "c.5.0.0").unlink()
    playback = PlaybackShow([Cache.open(copied)])
    order(playback, {"type": "seek", "frame": 5})
    playback.turn(0.0)
    assert "frame 5" in status(playback)["note"][1] and not status(playback)["playing"]
    order(playback, {"type": "seek", "frame": 6})
    playback.turn(0.0)
    assert picture(playback)[0]["frame"] == 6
