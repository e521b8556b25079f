"""The benchmarks measure what they say; nothing here depends on how long it takes."""

import csv
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation
from taut.bench import (
    COLUMNS,
    Case,
    History,
    Window,
    irregular_square,
    measure,
    measure_in_turn,
    this_machine,
)

ROOT = Path(__file__).resolve().parent.parent
Command = Callable[..., Any]


def spring_forces(simulation: Simulation, stiffness: np.ndarray) -> np.ndarray:
    """Hooke's law over the list of springs, in double precision."""
    x = simulation.positions.astype(np.float64)
    u, v = simulation.springs.T
    arm = x[v] - x[u]
    length = np.linalg.norm(arm, axis=1)
    pull = (stiffness * (1 - simulation.rest_length / length))[:, None] * arm
    forces = np.zeros_like(x)
    np.add.at(forces, u, pull)
    np.add.at(forces, v, -pull)
    return forces


def shaken(simulation: Simulation) -> Simulation:
    """Moved away from rest at random, so that no force is zero."""
    random = np.random.default_rng(1)
    simulation.positions = simulation.positions + random.normal(0, 0.01, simulation.positions.shape)
    return simulation


@pytest.mark.parametrize("cells", [[3, 4], [17, 2], [18, 5], [70, 20]])
def test_the_yardstick_computes_the_spring_forces_of_a_grid(cells: list[int]) -> None:
    nx, ny = cells
    cloth = {
        "grid": {"size": [0.1 * nx, 0.1 * ny], "cells": cells},
        "stiffness": 20.0,
        "shear_stiffness": 6.0,
    }
    simulation = shaken(Simulation(Scene({"cloth": [cloth]})))
    column, row = (
        part[simulation.springs] for part in np.divmod(np.arange(len(simulation.mass)), nx + 1)[::-1]
    )
    on_border = np.zeros(len(simulation.springs), bool)
    for line, last in ((column, nx), (row, ny)):
        on_border |= (line == 0).all(axis=1) | (line == last).all(axis=1)
    shear = simulation.spring_kind == 1
    stiffness = np.where(shear, 3.0, np.where(on_border, 10.0, 20.0))
    seconds, forces = simulation.yardstick(3)
    assert seconds.shape == (3,)
    assert (seconds > 0).all()
    np.testing.assert_allclose(forces, spring_forces(simulation, stiffness), rtol=1e-3, atol=1e-5)


def test_the_yardstick_computes_the_spring_forces_of_a_network() -> None:
    random = np.random.default_rng(2)
    points = random.uniform(size=(40, 3))
    links = [[i, j] for i in range(40) for j in range(i) if random.uniform() < 0.2]
    cloth = {"network": {"mass": 0.1, "points": points, "links": links}, "stiffness": 30.0}
    simulation = shaken(Simulation(Scene({"cloth": [cloth]})))
    before = simulation.state_hash
    _, forces = simulation.yardstick()
    np.testing.assert_allclose(
        forces, spring_forces(simulation, np.full(len(links), 30.0)), rtol=1e-3, atol=1e-5
    )
    assert simulation.state_hash == before


def test_the_yardstick_needs_a_pass() -> None:
    with pytest.raises(ValueError, match="repeats = 0"):
        Case("one-corner", 4, 0.1).simulation().yardstick(0)


def test_the_irregular_square_is_a_whole_square() -> None:
    vertices, faces = irregular_square(20)
    assert vertices.shape == (441, 3)
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(1.0)
    assert set(faces.ravel()) == set(range(441))
    edges = np.linalg.norm(b - a, axis=1)
    assert edges.max() > 1.3 * edges.min()  # irregular
    np.testing.assert_array_equal(irregular_square(20)[0], vertices)


def test_the_mesh_weighs_what_the_grid_weighs() -> None:
    mesh, grid = Case("mesh", 12, 0.1).simulation(), Case("one-corner", 12, 0.1).simulation()
    assert len(mesh.mass) == len(grid.mass)
    assert mesh.mass.sum() == pytest.approx(grid.mass.sum(), rel=1e-5)
    np.testing.assert_allclose(mesh.positions[mesh.pinned], grid.positions[grid.pinned])


def test_a_row_says_what_happened_in_its_window() -> None:
    row = measure(Case("one-corner", 8, 0.05), Window(frames=40, seconds=100.0, repeats=2))
    simulation = Case("one-corner", 8, 0.05).simulation()
    reports = [simulation.step(simulation.substeps) for _ in range(40)]
    assert row.worst_stretch == max(report.worst_stretch_in_steps for report in reports)
    assert row.cycles_per_frame == sum(report.sweeps for report in reports) / 40
    assert (row.frames, row.repeats, row.vertices, row.window) == (40, 2, 81, 40 / 60)
    assert row.ratio == pytest.approx(row.ms_per_frame / row.yardstick_ms)
    per_step = row.ms_per_frame * 1e6 / 81 / simulation.substeps
    assert row.ns_per_particle_step == pytest.approx(per_step)
    assert row.ms_median <= row.ms_worst


def test_cases_in_turn_simulate_the_same_frames() -> None:
    cases = [Case("one-corner", 8, 0.05), Case("one-corner", 6, 0.01)]
    rows = measure_in_turn(cases, Window(frames=20, seconds=100.0, repeats=3))
    assert [(row.cells, row.strain_limit, row.frames, row.repeats) for row in rows] == [
        (8, 0.05, 20, 3),
        (6, 0.01, 20, 3),
    ]
    for row, case in zip(rows, cases, strict=True):
        alone = measure(case, Window(frames=20))
        assert (row.cycles_per_frame, row.worst_stretch) == (alone.cycles_per_frame, alone.worst_stretch)
    short = measure_in_turn(cases, Window(frames=20, seconds=1e-9, repeats=3))
    assert [(row.frames, row.repeats) for row in short] == [(1, 1), (1, 1)]
    with pytest.raises(ValueError, match="at least one"):
        measure_in_turn([], Window())


def test_a_row_ends_when_its_time_is_up() -> None:
    row = measure(Case("one-corner", 8, 0.05), Window(frames=40, seconds=1e-9, repeats=2))
    assert replace(row, ms_per_frame=2.0, cpu_ms_per_frame=1.0).disturbed
    assert not replace(row, ms_per_frame=2.0, cpu_ms_per_frame=1.95).disturbed
    assert (row.frames, row.repeats) == (1, 1)
    with pytest.raises(ValueError, match="frames"):
        measure(Case("one-corner", 8, 0.05), Window(frames=0))


def test_bench_prints_rows_and_keeps_them(taut: Command, tmp_path: Path) -> None:
    options = ["--sizes", 8, "--mesh-sizes", 6, "--limits", "5", "--threads", "1,2", "--frames", 5]
    files = ["--csv", tmp_path / "rows.csv", "--history", tmp_path / "history"]
    done = taut("bench", *options, *files)
    assert done.status == 0
    with (tmp_path / "rows.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert set(COLUMNS) < set(rows[0])
    expected = [(scene, "8") for scene in ("one-corner", "two-corners", "flag")]
    expected += [("mesh", "6"), ("one-corner", "6")]
    found = [(row["scene"], row["cells"], row["threads"]) for row in rows]
    assert found == [(*kind, count) for kind in expected for count in ("1", "2")]
    assert all(float(row["strain_limit"]) == 0.05 and row["frames"] == "5" for row in rows)
    assert all(float(row["worst_stretch"]) <= 0.05 + 1e-5 for row in rows)
    kept = list((tmp_path / "history").iterdir())
    assert [path.name for path in kept] == [f"{this_machine().name}.csv"]
    assert kept[0].read_text() == (tmp_path / "rows.csv").read_text()


def test_the_columns_are_explained() -> None:
    explained = (ROOT / "benches" / "history" / "README.md").read_text()
    assert [column for column in COLUMNS if f"`{column}`" not in explained] == []


def test_bench_compares_with_the_last_run(taut: Command, tmp_path: Path) -> None:
    options = ["--scenes", "one-corner", "--sizes", 8, "--limits", "5", "--threads", 1, "--frames", 5]
    options += ["--history", tmp_path]
    taut("bench", *options)
    kept = next(tmp_path.iterdir())
    head, row = kept.read_text().splitlines()
    kept.write_text(f"{head}\n{row.rsplit(',', 1)[0]},1234.5\n")
    assert "1234.5" not in taut("bench", *options).out
    kept.write_text(f"{head}\n{row.rsplit(',', 1)[0]},1234.5\n")
    assert "1234.5" in taut("bench", *options, "--compare").out
    other = measure(Case("one-corner", 8, 0.01), Window(5))
    assert History(kept).last_ratio(other) is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--sizes", "a"], "--sizes a: must be numbers"),
        (["--sizes", "0"], "scene.cloth[0].grid.cells[0] = 0"),
        (["--threads", "0"], "--threads 0: must be 1 to"),
        (["--limits", "0"], "strain_limit = 0"),
        (["--scenes", "sail"], "--scenes sail: there is no such scene"),
    ],
)
def test_bad_options_are_one_red_line(taut: Command, options: list[str], message: str) -> None:
    done = taut("bench", *options)
    assert done.status == 2
    assert message in done.err
    assert done.err.count("\n") == 1


def test_the_machine_is_named_without_its_host() -> None:
    import platform

    machine = this_machine()
    assert machine.name.endswith(f"-{machine.cores}-cores")
    assert platform.node() == "" or platform.node() not in f"{machine} {machine.name}"


CONTACT = ("drapes", "heaps", "pulled", "shots", "random", "garments", "friction", "speed")


@pytest.mark.slow
def test_every_target_can_be_measured() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tools.targets", "--quick"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    rows = [line.split(" | ") for line in done.stdout.splitlines() if line.startswith("| ")][1:]
    assert all(len(row) == 7 for row in rows)
    met = {row[6].strip("` |"): row[2] for row in rows}
    assert met["bound"] == met["momentum"] == "yes"
    assert {
        "cycles",
        "far",
        "hand",
        "held",
        "mesh-growth",
        "mesh-motion",
        "mesh-threads",
        "rest",
        "scales",
        "swing",
        "taut-sheet",
        "tips",
        "growth",
        "one-thread",
        "two-threads",
        "tight",
        "peak-speed",
        "path",
        "tip",
        "chain",
        "mesh",
        "cuts",
        *(f"contact-{name}" for name in CONTACT),
    } <= set(met)
