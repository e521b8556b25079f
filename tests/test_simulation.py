import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation, SimulationError


@pytest.fixture
def simulation(flag: dict[str, Any]) -> Simulation:
    return Simulation(Scene(flag), threads=1)


def test_arrays_have_the_shapes_that_are_promised(simulation: Simulation) -> None:
    vertices, springs = 7 * 5, len(simulation.springs)
    for array in (simulation.positions, simulation.velocities):
        assert (array.shape, array.dtype) == ((vertices, 3), np.float32)
        assert array.flags.c_contiguous
    assert simulation.faces.shape == (2 * 6 * 4, 3)
    assert simulation.springs.shape == (springs, 2)
    for array in (simulation.spring_kind, simulation.rest_length, simulation.strain_limit):
        assert array.shape == (springs,)
    assert simulation.mass.shape == simulation.pinned.shape == (vertices,)
    assert simulation.pinned.sum() == 5
    assert simulation.cloths == [("flag", 0, vertices)]
    assert simulation.step_length <= simulation.step_bound
    assert simulation.step_length * simulation.substeps == pytest.approx(1 / 60)


def test_weights_are_spread_over_what_they_name(flag: dict[str, Any]) -> None:
    bare = Simulation(Scene(flag)).mass.astype(np.float64)
    flag["cloth"][0]["weights"] = [{"edge": "right", "mass": 0.5}, {"corner": "top-right", "mass": 0.2}]
    weighted = Simulation(Scene(flag))
    extra = weighted.mass - bare
    expected = np.zeros((5, 7))
    expected[:, 6] = 0.1
    expected[4, 6] += 0.2
    np.testing.assert_allclose(extra, expected.ravel(), atol=1e-7)
    heights = weighted.positions[:, 2].astype(np.float64)
    potential = 9.81 * (weighted.mass * heights)[~weighted.pinned].sum()
    assert weighted.report.potential_energy == pytest.approx(potential, rel=1e-5)
    assert potential > 9.81 * (bare * heights).sum() + 1


def test_views_are_live_and_read_only(simulation: Simulation) -> None:
    positions, before = simulation.positions, simulation.positions.copy()
    report = simulation.step(3)
    assert positions is simulation.positions
    assert not np.array_equal(positions, before)
    assert (report.steps, simulation.steps) == (3, 3)
    assert report is simulation.report
    assert simulation.time == report.time == pytest.approx(3 * simulation.step_length)
    with pytest.raises(ValueError, match="read-only"):
        positions[0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        simulation.springs[0] = 0


def test_the_report_agrees_with_the_positions(simulation: Simulation) -> None:
    report = simulation.run(20)
    ends = simulation.positions.astype(np.float64)[simulation.springs]
    stretch = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / simulation.rest_length - 1
    assert report.worst_stretch == pytest.approx(stretch.max(), abs=1e-6)
    assert stretch[report.worst_spring] == pytest.approx(stretch.max(), abs=1e-6)
    speeds = simulation.velocities.astype(np.float64)
    kinetic = 0.5 * (simulation.mass * (speeds**2).sum(axis=1))[~simulation.pinned].sum()
    assert report.kinetic_energy == pytest.approx(kinetic, rel=1e-4)


def test_external_forces_are_weight_and_wind(flag: dict[str, Any]) -> None:
    flag["wind"] = {"velocity": [3.0, 4.0, 0.0], "density": 1.2}
    flag["cloth"][0] |= {"air_drag": 0.0, "drag_coefficient": 1.1}
    simulation = Simulation(Scene(flag))
    forces, free = simulation.external_forces(), ~simulation.pinned
    assert (forces.shape, forces.dtype) == ((35, 3), np.float32)
    assert not forces[~free].any()
    weight = 9.81 * simulation.mass[free].sum()
    assert forces[:, 2].sum() == pytest.approx(-weight, rel=1e-5)
    # A flat sheet across y: 1/2 rho C_d A |W| W_y, shared out like the mass.
    density = simulation.scene.document["cloth"][0]["density"]
    push = 0.5 * 1.2 * 1.1 * simulation.mass[free].sum() / density * 5.0 * 4.0
    assert forces[:, 1].sum() == pytest.approx(push, rel=1e-5)
    assert abs(forces[:, 0]).max() < 1e-6


def test_run_is_many_steps(simulation: Simulation, flag: dict[str, Any]) -> None:
    times: list[float] = []
    simulation.run(5, on_frame=lambda now: times.append(now.time))
    other = Simulation(Scene(flag))
    for _ in range(5 * other.substeps):
        other.step()
    assert simulation.state_hash == other.state_hash
    assert times == pytest.approx([1 / 60, 2 / 60, 3 / 60, 4 / 60, 5 / 60])


@pytest.mark.parametrize("threads", [1, 2, 3, 4])
def test_threads_do_not_change_a_bit(simulation: Simulation, flag: dict[str, Any], threads: int) -> None:
    other = Simulation(Scene(flag), threads=threads)
    assert other.threads == threads
    simulation.run(10)
    other.run(10)
    assert simulation.state_hash == other.state_hash


def test_a_snapshot_brings_the_state_back(simulation: Simulation, flag: dict[str, Any]) -> None:
    simulation.run(3)
    snapshot, hash_then = simulation.snapshot(), simulation.state_hash
    positions = simulation.positions.copy()
    simulation.run(3)
    hash_later = simulation.state_hash
    simulation.restore(snapshot)
    assert simulation.state_hash == hash_then
    assert simulation.steps == 3 * simulation.substeps
    np.testing.assert_array_equal(simulation.positions, positions)
    simulation.run(3)
    assert simulation.state_hash == hash_later
    other = Simulation(Scene(flag))
    other.restore(snapshot)
    other.run(3)
    assert other.state_hash == hash_later


def test_foreign_and_damaged_snapshots_are_refused(simulation: Simulation, flag: dict[str, Any]) -> None:
    snapshot = simulation.snapshot()
    before = simulation.state_hash
    for damaged in (b"", snapshot[:-1], snapshot + b"x", b"x" + snapshot[1:]):
        with pytest.raises(ValueError, match="snapshot"):
            simulation.restore(damaged)
    flag["cloth"][0]["grid"]["cells"] = [3, 3]
    with pytest.raises(ValueError, match="snapshot"):
        Simulation(Scene(flag)).restore(snapshot)
    assert simulation.state_hash == before


def test_the_state_can_be_set(simulation: Simulation) -> None:
    raised = simulation.positions.astype(np.float64) + [0, 0, 1]
    simulation.positions = raised
    np.testing.assert_array_equal(simulation.positions, raised.astype(np.float32))
    simulation.velocities = np.asfortranarray(np.ones((35, 3), np.float32))
    assert (simulation.velocities[~simulation.pinned] == 1).all()
    simulation.set_state(raised, np.zeros((35, 3)), steps=2)
    assert simulation.time == pytest.approx(2 * simulation.step_length)


@pytest.mark.parametrize("name", ["positions", "velocities"])
@pytest.mark.parametrize(
    ("array", "kind", "message"),
    [
        (np.zeros((34, 3)), ValueError, r"shape \(34, 3\): must be \(35, 3\)"),
        (np.zeros((35, 2)), ValueError, r"shape \(35, 2\)"),
        (np.zeros(105), ValueError, r"shape \(105,\)"),
        (0.0, ValueError, r"shape \(\)"),
        (np.zeros((35, 3), np.complex64), TypeError, "type complex64: must be float32 or float64"),
        (np.zeros((35, 3), np.int64), TypeError, "type int64"),
        (np.zeros((35, 3), bool), TypeError, "type bool"),
        (np.full((35, 3), None), TypeError, "type object"),
        (np.full((35, 3), "x"), TypeError, "type <U1"),
        (np.full((35, 3), np.nan), ValueError, r"\[0, 0\] = nan: must be finite"),
        (np.full((35, 3), 1e300), ValueError, r"\[0, 0\] = 1e\+300: must be finite in float32"),
    ],
)
def test_bad_states_are_refused(
    simulation: Simulation, name: str, array: Any, kind: type[Exception], message: str
) -> None:
    before = simulation.state_hash
    with pytest.raises(kind, match=f"{name}.*{message}"):
        setattr(simulation, name, array)
    assert simulation.state_hash == before


def test_bad_arguments_are_refused(simulation: Simulation, flag: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="n = 0: must be 1 or more"):
        simulation.step(0)
    with pytest.raises(TypeError):
        simulation.step(1.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="frames = -1"):
        simulation.run(-1)
    for threads in (0, 100_000):
        with pytest.raises(ValueError, match=f"threads = {threads}: must be 1 to 1024"):
            Simulation(Scene(flag), threads=threads)
    with pytest.raises(TypeError, match="must be a taut.Scene"):
        Simulation("flag.toml")  # type: ignore[arg-type]


def test_a_hand_leads_a_vertex_until_it_lets_go(simulation: Simulation) -> None:
    tip = len(simulation.positions) - 1
    target = simulation.positions[tip] + np.float32([-0.3, 0.2, 0.1])
    assert not simulation.pinned[tip]
    for _ in range(3):
        simulation.lead(tip, target, speed=10.0)
        simulation.step(30)
    led = np.linalg.norm(simulation.positions[tip] - target)
    simulation.release(tip)
    simulation.step(60)
    assert led < 0.25 < np.linalg.norm(simulation.positions[tip] - target)


def test_pins_are_moved_off_their_paths(simulation: Simulation) -> None:
    (group,) = simulation.pin_groups
    assert np.array_equal(group, np.flatnonzero(simulation.pinned))
    start = simulation.positions[group].copy()
    simulation.shift_pins(0, [0.0, 0.3, 0.0], speed=1.0)
    simulation.step(simulation.substeps * 6)
    assert simulation.pin_offset(0) == pytest.approx([0, 0.1, 0], abs=1e-6)
    simulation.step(simulation.substeps * 30)
    assert simulation.positions[group] == pytest.approx(start + np.float32([0, 0.3, 0]), abs=1e-6)


def test_a_pin_that_creeps_away_never_tears_the_limit() -> None:
    # So many steps a frame that a pin that is held back moves by less than rounding in each of them.
    grid = {"size": [1.5, 1.0], "cells": [6, 4], "origin": [0, 0, 1], "axes": ["x", "z"]}
    pins = [{"corner": "top-left"}, {"corner": "bottom-left"}, {"nearest": [0.7, 0, 1.5]}]
    cloth = {"grid": grid, "fabric": "nylon", "pins": pins}
    simulation = Simulation(Scene({"cloth": [cloth], "solver": {"substeps": 200}}))
    simulation.shift_pins(1, (0.0, 0.0, -1.0), speed=7.2)
    simulation.step(1500)
    assert simulation.report.worst_stretch <= 0.04 * (1 + 1e-5) + 1e-7
    assert simulation.report.held_back_pins > 0


def test_a_state_over_the_limit_is_admitted(simulation: Simulation) -> None:
    wide = simulation.positions * np.float32([2, 1, 1])
    simulation.positions = wide
    assert simulation.report.worst_stretch > 0.9
    simulation.admit()
    assert simulation.report.worst_stretch <= 0.04 * (1 + 1e-5)
    assert np.array_equal(simulation.positions[simulation.pinned], wide[simulation.pinned])


@pytest.mark.parametrize(
    "wrong",
    [
        lambda simulation: simulation.lead(35, (0, 0, 0), 1),
        lambda simulation: simulation.release(35),
        lambda simulation: simulation.shift_pins(1, (0, 0, 0), 1),
        lambda simulation: simulation.pin_offset(1),
    ],
)
def test_hands_on_what_is_not_there_are_refused(simulation: Simulation, wrong: Callable[..., None]) -> None:
    with pytest.raises(IndexError, match="counted from 0"):
        wrong(simulation)


@pytest.mark.parametrize(
    ("target", "speed"), [((0, np.nan, 0), 1), ((0, 0, 0), 0), ((0, 0, 0), np.nan), ((0, 0), 1)]
)
def test_hands_need_numbers(simulation: Simulation, target: tuple[float, ...], speed: float) -> None:
    for hold in (simulation.lead, simulation.shift_pins):
        with pytest.raises(ValueError):
            hold(0, target, speed)


def test_a_blow_up_keeps_the_state_before_it(flag: dict[str, Any]) -> None:
    flag["solver"] = {"substeps": 1, "force_step": True, "filter": "none"}
    flag["cloth"][0]["stiffness"] = 1e6
    simulation = Simulation(Scene(flag))
    with pytest.raises(SimulationError, match="vertex"):
        simulation.run(200)
    assert np.isfinite(simulation.positions).all()
    assert simulation.time == pytest.approx(simulation.steps * simulation.step_length)


def test_other_threads_run_meanwhile(flag: dict[str, Any]) -> None:
    flag["cloth"][0]["grid"]["cells"] = [60, 40]
    simulation = Simulation(Scene(flag), threads=1)
    stepping, counted = threading.Event(), 0
    worker = threading.Thread(target=lambda: (stepping.set(), simulation.step(300)))
    worker.start()
    stepping.wait()
    while worker.is_alive() and counted < 1000:
        counted += 1
        worker.join(timeout=1e-4)
    worker.join()
    # Were the lock of Python held, this thread would wake up once before the call and once after it.
    assert counted > 10


def test_several_threads_may_step_one_simulation(flag: dict[str, Any]) -> None:
    flag["cloth"][0]["grid"]["cells"] = [200, 200]
    simulation, failures = Simulation(Scene(flag), threads=1), list[Exception]()

    def step() -> None:
        try:
            for _ in range(20):
                simulation.step()
        except Exception as error:
            failures.append(error)

    workers = [threading.Thread(target=step) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert not failures
    assert simulation.steps == 80


def test_cloth_without_pins_holds_none_back(flag: dict[str, Any]) -> None:
    flag["cloth"][0]["pins"] = []
    simulation = Simulation(Scene({"cloth": flag["cloth"], "gravity": [0.0, 0.0, 0.0]}), threads=1)
    noise = np.random.default_rng(1).normal(size=simulation.velocities.shape)
    simulation.velocities = (1e9 * noise).astype(np.float32)
    report = simulation.step()
    assert report.lost_motion == 1.0, "the last resort of the certificate is meant"
    assert report.cuts > 0
    assert report.held_back_pins == 0


@pytest.mark.parametrize(("hole", "pins"), [(0, 3), (0, 8), (5, 3), (5, 8)])
def test_a_round_cloth_in_rings_comes_to_rest(hole: int, pins: int) -> None:
    """Whole, it is fine in the middle: with masses scaled alike everywhere its outer rings trembled for ever.

    Without its inner rings it went to and fro beside its pins, by up to 4 cm, where nothing braked it.
    """
    rings, around = 12, 48
    angles = np.linspace(0, 2 * np.pi, around, endpoint=False)
    rim = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    positions = np.concatenate([[[0, 0, 0]], *[0.5 * ring / rings * rim for ring in range(1, rings + 1)]])
    number = 1 + np.arange(rings * around).reshape(rings, around)
    after = np.roll(number, -1, axis=1)
    corners = [(number[:-1], number[1:], after[1:]), (number[:-1], after[1:], after[:-1])]
    outer = [np.stack(corner, axis=-1)[hole:].reshape(-1, 3) for corner in corners]
    inner = [] if hole else [np.stack([0 * number[0], number[0], after[0]], axis=1)]
    left, faces = np.unique(np.concatenate([*inner, *outer]), return_inverse=True)
    held = np.searchsorted(left, number[-1, :: around // pins])
    scene = Scene.from_arrays(positions[left], faces.reshape(-1, 3), pins=held, fabric="denim", air_drag=0.5)
    simulation = Simulation(scene)
    simulation.run(frames=540)
    assert simulation.report.worst_stretch <= 0.03 + 1e-5
    seen = []
    for _ in range(32):
        simulation.run(frames=1)
        assert simulation.report.mean_lost_motion < 0.01
        seen.append(np.array(simulation.exact_positions))
    jerks = np.linalg.norm(np.diff(seen, 2, axis=0), axis=-1)
    assert jerks.max() < 1e-4
