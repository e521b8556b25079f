"""Many worlds on one pool of threads."""

import os
import signal
import threading
from typing import Any

import numpy as np
import pytest
from taut import Batch, Scene, Simulation, SimulationError


@pytest.mark.parametrize("threads", [1, 3])
def test_worlds_move_as_they_would_alone(flag: dict[str, Any], threads: int) -> None:
    scenes = [Scene(flag).with_settings([f"wind.velocity=[{2 * world}, 1, 0]"]) for world in range(5)]
    batch = Batch(scenes, threads)
    positions, velocities = batch.positions, batch.velocities
    assert (len(batch), positions.shape, positions.dtype) == (5, (5, 35, 3), np.float32)
    batch[2].gravity = (0, 0, -1.6)
    batch[3].hold(34, batch[3].positions[34])
    reports = batch.step(12)
    batch[1].step(2)
    batch.step(3, dt=1 / 500)
    for world, (scene, mine) in enumerate(zip(scenes, batch, strict=True)):
        alone = Simulation(scene, threads=2)
        if world == 2:
            alone.gravity = (0, 0, -1.6)
        if world == 3:
            alone.hold(34, alone.positions[34])
        report = alone.step(12)
        assert (report.worst_stretch, report.time) == (reports[world].worst_stretch, reports[world].time)
        if world == 1:
            alone.step(2)
        alone.step(3, dt=1 / 500)
        assert mine.state_hash == alone.state_hash
        np.testing.assert_array_equal(positions[world], alone.positions)
        np.testing.assert_array_equal(velocities[world], alone.velocities)
        assert np.shares_memory(positions[world], mine.positions)
    with pytest.raises(ValueError, match="read-only"):
        positions[0] = 0


def test_what_one_world_cannot_do_none_has_done(flag: dict[str, Any]) -> None:
    batch = Batch([Scene(flag)] * 4, threads=2)
    batch.step(3)
    wild = np.array(batch[2].velocities)
    wild[20] = 3e38
    batch[2].velocities = wild
    before, positions = [world.state_hash for world in batch], batch.positions.copy()
    with pytest.raises(SimulationError, match="world 2: cloth .flag., vertex"):
        batch.step(50)
    assert [world.state_hash for world in batch] == before
    np.testing.assert_array_equal(batch.positions, positions)
    with pytest.raises(ValueError, match="world [0-3]: .*-1"):
        batch.step(1, dt=-1.0)
    batch[2].restore(batch[0].snapshot())
    batch.step(3)
    assert len({world.state_hash for world in batch}) == 1


def test_ctrl_c_ends_a_batch_without_a_trace(flag: dict[str, Any]) -> None:
    # What starts tests in the background may have it ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    batch = Batch([Scene(flag)] * 3, threads=2)
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        batch.step(10_000_000)
    timer.join()
    assert [world.steps for world in batch] == [0, 0, 0]


def test_bad_batches_are_refused(flag: dict[str, Any]) -> None:
    scene = Scene(flag)
    other = scene.with_settings(["cloth.flag.grid.cells=[3, 3]"])
    wrong: list[tuple[tuple[Any, ...], type[Exception], str]] = [
        (([],), ValueError, "scenes is empty"),
        ((scene,), TypeError, "single Scene"),
        (([scene, other],), ValueError, r"scenes\[1\] has 16 vertices, scenes\[0\] 35"),
        (([scene, 3],), TypeError, "scene is a int"),
        (([scene], 0), ValueError, "threads = 0"),
    ]
    for arguments, error, words in wrong:
        with pytest.raises(error, match=words):
            Batch(*arguments)
    with pytest.raises(ValueError, match="n = 0"):
        Batch([scene]).step(0)
