"""A child of a process has none of its threads: what it inherits gets new ones, or says why not."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")

PATIENCE = 60
"""A child that waits for threads that are not there would wait for ever [s]."""

BEFORE = """
import gc, multiprocessing, os, threading, time, warnings
from taut import Scene, Simulation, SimulationError

warnings.simplefilter("ignore", DeprecationWarning)
grid = {"size": [1.5, 1.0], "cells": [60, 40], "axes": ["x", "z"]}
scene = Scene({"cloth": [{"grid": grid, "fabric": "nylon", "pins": [{"edge": "left"}]}]})
simulation = Simulation(scene, threads=2)
simulation.step(2)

def child(work):
    number = os.fork()
    if number == 0:
        try:
            work()
            os._exit(0)
        except BaseException as error:
            print(type(error).__name__, error, flush=True)
            os._exit(1)
    return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
"""


def forked(script: str) -> str:
    """What a Python of its own prints that forks."""
    done = subprocess.run(
        [sys.executable, "-c", BEFORE + script],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_child_goes_on_with_what_it_inherits_as_its_parent_does() -> None:
    script = """
def work():
    assert simulation.threads == 2
    simulation.step(3)
    print(simulation.state_hash, flush=True)
    assert child(lambda: print(simulation.step(3).steps, simulation.state_hash, flush=True)) == 0

assert child(work) == 0
simulation.step(3)
print(simulation.state_hash)
simulation.step(3)
print(simulation.state_hash)
"""
    in_child, in_its_child, in_parent, later = forked(script).splitlines()
    assert in_child == in_parent
    assert in_its_child == f"3 {later}"


def test_a_child_makes_simulations_and_drops_those_it_inherits() -> None:
    script = """
def work():
    global simulation
    other = Simulation(scene, threads=2)
    other.step(5)
    del simulation
    gc.collect()
    print(other.state_hash, flush=True)

assert child(work) == 0
simulation.step(3)
print(simulation.state_hash)
"""
    in_child, in_parent = forked(script).splitlines()
    assert in_child == in_parent


def test_workers_that_are_forked_step() -> None:
    script = """
def work(steps):
    simulation.step(steps)
    return simulation.state_hash

with multiprocessing.get_context("fork").Pool(2) as workers:
    print(*workers.map(work, [3, 3], chunksize=1))
simulation.step(3)
print(simulation.state_hash)
"""
    in_workers, in_parent = forked(script).splitlines()
    assert in_parent in in_workers.split()


def test_a_simulation_that_another_thread_steps_during_the_fork_is_lost_and_it_is_said() -> None:
    script = """
stepping = threading.Thread(target=lambda: simulation.step(10**7))
stepping.start()
time.sleep(0.5)
for use in (lambda: simulation.step(), lambda: simulation.state_hash):
    assert child(use) == 1
assert child(lambda: Simulation(scene, threads=2).step(2)) == 0
os._exit(0)
"""
    said = forked(script).splitlines()
    assert len(said) == 2
    for line in said:
        assert line.startswith(
            "SimulationError this process was forked while another thread used the simulation"
        )
        assert "make another one" in line
