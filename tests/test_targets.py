"""The measuring itself: meshes are what they say, figures are computed right, a missed target is an error."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from taut.bench import Spread, Window, runs_in_turn
from taut.bench.meshes import cape, irregular_sheet, skirt, weighted_net
from taut.bench.shirt import shirt, shoulders
from taut.bench.trials import TRIALS, Trial

from tools.targets.converged import ALL, FILE, SOLVER, converged
from tools.targets.grids import HELD, SEEDS, Chance
from tools.targets.hand import Pulled
from tools.targets.mesh import evenness
from tools.targets.record import Motion, rms
from tools.targets.reference import path
from tools.targets.rest import Finding, judge
from tools.targets.settled import compared, period


def edges_of(faces: np.ndarray) -> np.ndarray:
    """Directed edges, face after face."""
    corners = faces.shape[1]
    return np.concatenate([faces[:, [a, (a + 1) % corners]] for a in range(corners)])


def assert_manifold(vertices: np.ndarray, faces: np.ndarray, euler: int, borders: int) -> None:
    directed = edges_of(faces)
    assert len(np.unique(directed, axis=0)) == len(directed)  # all faces are turned the same way
    edges, count = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    assert count.max() == 2
    assert set(faces.ravel()) == set(range(len(vertices)))
    assert len(vertices) - len(edges) + len(faces) == euler
    border = edges[count == 1]
    names = {vertex: vertex for vertex in border.ravel()}
    for _ in range(len(border)):
        for a, b in border:
            names[a] = names[b] = min(names[a], names[b])
        if len(set(names.values())) == borders:
            break
    assert len(set(names.values())) == borders
    assert (np.bincount(border.ravel())[list(names)] == 2).all()
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    assert (np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0).all()
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    assert lengths.max() > 2 * lengths.min()  # uneven


@pytest.mark.parametrize("size", [0.1, 1.0, 20.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_sheet_is_a_whole_rectangle(size: float, seed: int) -> None:
    vertices, faces = irregular_sheet((20, 12), (2 * size, size), seed)
    assert_manifold(vertices, faces, euler=1, borders=1)
    assert (vertices.shape, faces.shape) == ((273, 3), (480, 3))
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(2 * size**2)
    assert ((vertices[:, 1] == 0).sum(), (vertices[:, 0] == 0).sum()) == (21, 13)
    np.testing.assert_allclose(vertices.max(axis=0), [2 * size, size, 0])
    again, _ = irregular_sheet((20, 12), (2 * size, size), seed)
    np.testing.assert_array_equal(again, vertices)
    assert (np.abs(np.diff(vertices[:, 0])) > 0.2 * size).any()  # neighbours have no neighbouring numbers


def test_quadrilaterals_are_convex() -> None:
    vertices, faces = irregular_sheet((20, 20), quads=True)
    assert faces.shape == (400, 4)
    assert_manifold(vertices, faces, euler=1, borders=1)
    for corner in range(4):
        a, b, c = (vertices[faces[:, (corner + step) % 4]] for step in range(3))
        assert (np.cross(b - a, c - b)[:, 2] > 0).all()


def test_diagonals_are_random() -> None:
    _, faces = irregular_sheet((20, 20))
    sixes = np.bincount(np.bincount(faces.ravel()))
    assert (sixes[4:9] > 5).all()  # triangles of a vertex; on a grid it would be six inside


@pytest.mark.parametrize("count", [64, 500, 2584])
@pytest.mark.parametrize("size", [0.1, 20.0])
def test_garments_have_the_vertices_asked_for(count: int, size: float) -> None:
    vertices, faces = skirt(count, size)
    assert len(vertices) == count
    assert_manifold(vertices, faces, euler=0, borders=2)
    waist = vertices[vertices[:, 2] == 0]
    np.testing.assert_allclose(np.linalg.norm(waist[:, :2], axis=1), 0.12 * size)
    outward = np.einsum("fc,fc->f", normals(vertices, faces)[:, :2], vertices[faces[:, 0], :2])
    assert (outward > 0).all()
    vertices, faces = cape(count, size)
    assert len(vertices) == count
    assert_manifold(vertices, faces, euler=1, borders=1)
    with pytest.raises(ValueError, match="vertices = 20"):
        skirt(20)


def normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


@pytest.mark.parametrize(("count", "size", "seed"), [(600, 1.0, 1), (6400, 1.0, 2), (1500, 20.0, 3)])
def test_a_shirt_has_a_neck_cuffs_and_a_hem(count: int, size: float, seed: int) -> None:
    vertices, faces = shirt(count, size, seed)
    assert len(vertices) == pytest.approx(count, rel=0.1)
    assert_manifold(vertices, faces, euler=-2, borders=4)
    front = vertices[faces].mean(axis=1)[:, 1] < -0.05 * size
    assert (normals(vertices, faces)[front, 1] < 0).all()
    for low, high in shoulders(size):
        assert ((vertices >= low) & (vertices <= high)).all(axis=1).any()


def test_a_net_has_heavy_knots() -> None:
    net = weighted_net(12, 2.0)
    mass = np.array(net["mass"])
    assert len(net["points"]) == len(mass) == 144
    assert mass.max() > 9 * np.median(mass)
    links = np.sort(net["links"], axis=1)
    assert len(np.unique(links, axis=0)) == len(links) > 264
    assert links.max() == 143


@pytest.mark.parametrize("scene", TRIALS)
@pytest.mark.parametrize("shape", ["grid", "mesh", "quads"])
def test_trials_are_held_where_they_should_be(scene: str, shape: Any) -> None:
    trial = Trial(scene, 400, 0.05, shape, size=0.5)
    if shape == "grid" and scene in ("shirt", "net"):
        with pytest.raises(ValueError, match="grid of"):
            trial.simulation()
        return
    simulation = trial.simulation()
    assert len(simulation.mass) == pytest.approx(400, rel=0.1)
    held = {"one-corner": 1, "two-corners": 2, "net": 2}.get(scene)
    assert simulation.pinned.sum() == held if held else 2 <= simulation.pinned.sum() <= 30
    assert simulation.warnings == []
    assert simulation.positions[simulation.pinned].shape[0] < 40
    if trial.scene in ("pendulum", "skirt", "cape"):
        assert (simulation.positions[simulation.pinned][:, 2] == 0).all()


def test_meshes_and_grids_of_a_trial_are_the_same_cloth() -> None:
    for scene in ("one-corner", "flag", "pendulum"):
        mesh, grid = (Trial(scene, 400, 0.05, shape).simulation() for shape in ("mesh", "grid"))
        assert len(mesh.mass) == len(grid.mass)
        assert mesh.mass.sum() == pytest.approx(grid.mass.sum(), rel=1e-5)
        for end in (np.min, np.max):
            np.testing.assert_allclose(end(mesh.positions, axis=0), end(grid.positions, axis=0), atol=1e-6)
        assert mesh.pinned.sum() == grid.pinned.sum()


def test_scenes_of_chance_are_held_as_they_say_beside_powers_of_two() -> None:
    all_of_them = [Chance.of(seed) for seed in SEEDS]
    assert {chance.held for chance in all_of_them} == set(HELD)
    assert sum(chance.in_powers() == chance for chance in all_of_them) < 3
    for seed in SEEDS[:8]:
        chance = Chance.of(seed, divide=8)
        beside = chance.in_powers()
        assert all(cells & (cells - 1) == 0 for cells in (beside.columns, beside.rows))
        one, other = chance.simulation(), beside.simulation()
        held = {"left edge": chance.rows + 1, "patches": 18}.get(chance.held, 1 + HELD.index(chance.held))
        assert one.pinned.sum() == held
        assert one.mass.sum() == pytest.approx(other.mass.sum(), rel=1e-5)
        np.testing.assert_allclose(np.ptp(one.positions, axis=0), np.ptp(other.positions, axis=0), atol=1e-6)


def test_the_spread_is_the_median_and_the_ends() -> None:
    spread = Spread.of([3.0, 1.0, 2.0, 10.0, 2.5])
    assert spread == Spread(2.5, 1.0, 10.0, 5)
    assert spread.text(1, " ms") == "2.5 ms (1.0 – 10.0, 5 runs)"
    with pytest.raises(ValueError, match="one at least"):
        Spread.of([])


def test_runs_in_turn_are_pairs() -> None:
    cases = [Trial("one-corner", 64, 0.05), Trial("one-corner", 64, 0.05, "grid")]
    runs = runs_in_turn(cases, Window(frames=10, seconds=100.0, repeats=5))
    assert [one.ms.shape for one in runs] == [(5,), (5,)]
    assert [one.cycles.shape for one in runs] == [(10,), (10,)]
    assert Spread.of(runs[0].ms).median == pytest.approx(runs[0].row.ms_per_frame, rel=0.5)
    assert all(
        one.cycles.sum() * one.row.steps_per_frame == pytest.approx(10 * one.row.cycles_per_frame)
        for one in runs
    )


def test_evenness_compares_hard_frames_with_others() -> None:
    assert evenness(np.full(100, 4.0)) == 1
    assert evenness(np.where(np.arange(100) % 10 == 0, 12.0, 4.0)) == 3
    assert evenness(np.zeros(10)) == 0


def motion_of(
    place: Callable[[np.ndarray], np.ndarray], velocity: Callable[[np.ndarray], np.ndarray]
) -> Motion:
    """A second of two vertices that move alike along x, at 60 frames a second."""
    time = np.arange(63) / 60
    positions, velocities = np.zeros((63, 2, 3)), np.zeros((63, 2, 3))
    positions[..., 0], velocities[..., 0] = place(time)[:, None], velocity(time)[:, None]
    kinetic = 0.5 * 0.2 * velocity(time) ** 2
    return Motion(positions, velocities, kinetic, np.ones(62), np.full(2, 0.1), 60.0)


def test_second_differences_of_known_motions() -> None:
    falling = motion_of(lambda t: -0.5 * 9.81 * t**2, lambda t: -9.81 * t)
    np.testing.assert_allclose(falling.shaking(), 9.81 / 3600)
    np.testing.assert_allclose(falling.trembling(), 0, atol=1e-12)
    assert falling.mismatch() < 1e-12
    trembling = motion_of(lambda t: 1e-3 * np.cos(60 * np.pi * t), np.zeros_like)
    np.testing.assert_allclose(trembling.shaking(), 4e-3)  # there and back again
    np.testing.assert_allclose(trembling.trembling(), 4e-3)
    assert rms(trembling.shaking()) == pytest.approx(4e-3)
    swinging = motion_of(lambda t: 0.1 * np.sin(4 * t), lambda t: 0.4 * np.cos(4 * t))
    assert swinging.trembling().max() < 1e-5 < swinging.shaking().max()
    assert swinging.mismatch() < 1e-3
    fast = motion_of(lambda t: 0.1 * np.sin(4 * t), lambda t: 0.42 * np.cos(4 * t))
    assert fast.mismatch() == pytest.approx(0.05, rel=0.05)
    assert fast.mismatch(0.3) == pytest.approx(0.05, rel=0.05)
    assert fast.mismatch(0.5) == 0  # never as fast
    np.testing.assert_allclose(swinging.kinetic_of_motion(), swinging.kinetic[1:-1], rtol=1e-2)
    np.testing.assert_allclose(swinging.centre()[:, 0], swinging.positions[:, 0, 0])


def test_rest_is_judged_by_its_limits() -> None:
    still, shaking = Finding("still", True, False), Finding("shaking", True, False)
    judge(still, motion_of(lambda t: 1e-6 * np.cos(60 * np.pi * t), np.zeros_like), 1.0)
    assert still.missed == []
    judge(shaking, motion_of(lambda t: 1e-5 * np.cos(60 * np.pi * t), lambda t: 0.01 + 0 * t), 1.0)
    assert shaking.missed == ["shaking", "speed", "kinetic energy"]
    swinging = Finding("swinging", False, False)
    judge(swinging, motion_of(lambda t: 0.1 * np.sin(4 * t), lambda t: 0.4 * np.cos(4 * t)), 1.0)
    assert swinging.missed == []


def test_motions_are_compared_by_peak_and_path() -> None:
    path = np.zeros((3, 3))
    off = compared((path + [0.02, 0, 0], np.array([0.0, 1.1, 1.0])), (path, np.array([0.0, 1.0, 0.5])), 2.0)
    assert (off.speed, off.path) == (pytest.approx(0.1), 0.01)
    assert off.worst == pytest.approx(0.1)


def test_the_period_is_found_between_frames() -> None:
    time = np.arange(300) / 60
    assert period(np.cos(2 * np.pi * time / 1.7), 60.0) == pytest.approx(1.7, rel=1e-3)
    assert period(np.ones(10), 60.0) == np.inf


def test_all_converged_motions_are_kept() -> None:
    assert set(json.loads(FILE.read_text())) == set(ALL)
    for name, one in ALL.items():
        places, speeds = converged(name)
        assert (len(places), len(speeds)) == (one.frames + 1, one.frames + 1)
        assert 0.1 < speeds.max() < 20


def test_the_converged_motion_is_that_of_its_trial() -> None:
    name = "two-corners 10 %, 33²"
    places, speeds = converged(name)
    settings = SOLVER | {"substeps": 60}
    found = path(ALL[name].trial.simulation(settings), 12)
    off = compared(found, (places[:13], speeds[:13]), 1.0)
    assert off.worst < 0.01


def test_a_hand_pulls_the_middle_of_the_flag() -> None:
    pulled = Pulled(Trial("flag", 100, 0.05), (-0.3, -0.5, 0.2), 0.3)
    simulation = pulled.simulation()
    vertex = int(np.argmax(simulation.mass))
    start = simulation.positions[vertex].copy()
    simulation.run(60)
    assert np.linalg.norm(simulation.positions[vertex] - start) > 0.3
    assert (pulled.cells, pulled.strain_limit) == (9, 0.05)
