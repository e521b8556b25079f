"""Parts of `taut compare --contact`, against analytic answers and the IPC Toolkit."""

import ipctk
import numpy as np
import pytest
from taut.compare.contact import built_in
from taut.compare.contact.boxes import overlapping
from taut.compare.contact.bridson import bridson, repel
from taut.compare.contact.continuous import bernstein, first_hits, roots
from taut.compare.contact.distance import between, closest
from taut.compare.contact.filtered import Filtered
from taut.compare.contact.impulses import batches
from taut.compare.contact.judge import Judge, count_crossings, winding
from taut.compare.contact.penalty import penalty
from taut.compare.contact.provot import provot
from taut.compare.contact.step import Outcome, Step
from taut.compare.contact.surfaces import icosphere
from taut.compare.contact.world import World, components
from taut.compare.contact.zones import rigid_motion

METHODS = {"bridson": bridson, "provot": provot, "penalty": penalty}


def random_pairs(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners of pairs near each other, shape (n, 4, 3), and whether they are edges."""
    random = np.random.default_rng(seed)
    return random.uniform(-1, 1, (count, 4, 3)), random.random(count) < 0.5


def sheets(gap: float, n: int = 5, thickness: float = 0.02, friction: float = 0.0, seed: int = 3) -> Step:
    """Two irregular sheets above each other that come together, with masses that differ."""
    random = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.arange(n), np.arange(n), [0]), axis=-1).reshape(-1, 3) * 0.1
    flat = [grid + random.uniform(-0.02, 0.02, grid.shape) * [1, 1, 0.1] for _ in range(2)]
    places = np.concatenate([flat[0], flat[1] + [0.013, 0.017, gap]])
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    half = np.stack([[corner, corner + 1, corner + n], [corner + 1, corner + n + 1, corner + n]])
    faces = half.transpose(0, 2, 1).reshape(-1, 3)
    faces = np.concatenate([faces, faces + n * n])
    light = 1.0 / random.uniform(0.5, 2.0, 2 * n * n)
    count = 2 * n * n
    world = World(faces, light, np.full(count, thickness / 2), np.full(count, friction), count)
    velocities = random.uniform(-0.3, 0.3, places.shape)
    velocities[n * n :, 2] -= 2.0
    velocities[: n * n, 2] += 1.0
    dt = 0.01
    return Step(world, places, places + dt * velocities, dt, np.inf)


def momenta(step: Step, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Momentum, and angular momentum about the places at the start."""
    impulses = (end - step.start) / step.dt / step.world.light[:, None]
    return impulses.sum(axis=0), np.cross(step.start, impulses).sum(axis=0)


# Detection.


def test_distances_are_those_of_the_toolkit() -> None:
    places, edges = random_pairs(400, 1)
    weights = closest(places, edges)
    np.testing.assert_allclose(weights.sum(axis=1), 0.0, atol=1e-12)
    squared = (between(weights, places) ** 2).sum(axis=1)
    for found, corners, edge in zip(squared, places, edges, strict=True):
        told = (ipctk.edge_edge_distance if edge else ipctk.point_triangle_distance)(*corners)
        assert found == pytest.approx(told, rel=1e-9, abs=1e-12)


def test_a_point_falls_through_a_triangle_when_it_must() -> None:
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    start = np.concatenate([[[0.2, 0.3, 0.7]], triangle])[None]
    end = start.copy()
    end[0, 0] = [0.2, 0.3, -0.3]
    hits = first_hits(start, end, np.array([False]))
    assert hits.time == pytest.approx([0.7], abs=1e-12)
    np.testing.assert_allclose(hits.weights[0], [1, -0.5, -0.2, -0.3], atol=1e-9)
    np.testing.assert_allclose(np.abs(hits.normal[0]), [0, 0, 1], atol=1e-12)
    end[0, 0] = [0.2, 0.3, 1e-6]  # stops above
    assert not len(first_hits(start, end, np.array([False])).rows)
    end[0, 0] = [2.0, 2.0, -0.3]  # passes beside
    assert not len(first_hits(start, end, np.array([False])).rows)


def test_edges_meet_when_they_must() -> None:
    start = np.array([[[-1, 0, 0.6], [1, 0, 0.6], [0, -1, 0], [0, 1, 0]]], float)
    end = start.copy()
    end[0, :2, 2] = -0.4
    hits = first_hits(start, end, np.array([True]))
    assert hits.time == pytest.approx([0.6], abs=1e-12)
    np.testing.assert_allclose(hits.weights[0], [0.5, 0.5, -0.5, -0.5], atol=1e-9)


def test_a_turning_triangle_passes_a_point_and_comes_back() -> None:
    """Cubic with more than one root: the first one is told."""
    wanted = np.array([[0.2, 0.5, 0.9], [0.3, -1.0, 2.0], [1.5, 2.0, 3.0]])
    power = np.array([np.poly(row)[::-1] for row in wanted])
    to_bernstein = np.array([[1, 0, 0, 0], [1, 1 / 3, 0, 0], [1, 2 / 3, 1 / 3, 0], [1, 1, 1, 1]])
    found = np.sort(roots(power @ to_bernstein.T), axis=1)
    np.testing.assert_allclose(found[0, :3], wanted[0], atol=1e-12)
    assert found[1, 0] == pytest.approx(0.3) and np.isinf(found[1, 1:]).all()
    assert np.isinf(found[2]).all()
    double = np.array([np.poly([0.4, 0.4, 3.0])[::-1]]) @ to_bernstein.T
    assert np.min(roots(double)) == pytest.approx(0.4, abs=1e-6)


def test_the_cubic_is_the_volume_on_the_way() -> None:
    start, _ = random_pairs(50, 2)
    end, _ = random_pairs(50, 3)
    for t in (0.0, 0.3, 1.0):
        at = start + t * (end - start)
        volume = np.linalg.det(at[:, 1:] - at[:, :1])
        b = bernstein(start, end).T
        value = sum(k * (1 - t) ** (3 - i) * t**i * b[i] for i, k in enumerate((1, 3, 3, 1)))
        np.testing.assert_allclose(value, volume, atol=1e-12)


def test_collisions_are_those_of_the_toolkit() -> None:
    start, edges = random_pairs(3000, 4)
    end = start + np.random.default_rng(5).normal(0, 0.5, start.shape)
    hits = first_hits(start, end, edges)
    found = np.zeros(len(start), bool)
    found[hits.rows] = True
    times = np.full(len(start), np.nan)
    times[hits.rows] = hits.time
    ccd = ipctk.TightInclusionCCD(tolerance=1e-9)
    told = 0
    for row in range(len(start)):
        look = ccd.edge_edge_ccd if edges[row] else ccd.point_triangle_ccd
        hit, toi = look(*start[row], *end[row])
        assert hit == found[row], row
        if hit:
            told += 1
            assert toi - 1e-4 < times[row] < toi + 0.01  # the toolkit stops a little before
    assert 150 < told < 2700


def test_boxes_that_overlap() -> None:
    random = np.random.default_rng(6)
    for shift in (0.0, 0.9, 5.0):
        low, other = random.uniform(0, 1, (80, 3)), random.uniform(0, 1, (60, 3)) + shift
        first = low, low + random.uniform(0, 0.2, low.shape)
        second = other, other + random.exponential(0.2, other.shape)
        below = (first[0][:, None] <= second[1]).all(axis=2) & (second[0] <= first[1][:, None]).all(axis=2)
        found = list(zip(*(side.tolist() for side in overlapping(first, second)), strict=True))
        assert len(found) == len(set(found)) and set(found) == set(zip(*np.nonzero(below), strict=True))


def test_components_and_batches() -> None:
    labels = components(8, np.array([[7, 3], [3, 5], [1, 2], [5, 6]]))
    assert labels.tolist() == [0, 1, 1, 3, 4, 3, 3, 3]
    corners = np.random.default_rng(7).integers(0, 30, (200, 4))
    moved = np.arange(30) < 25
    seen = []
    for batch in batches(corners, moved):
        assert len(batch)
        used = [set(row[moved[row]].tolist()) for row in corners[batch]]
        assert sum(map(len, used)) == len(set().union(*used))
        seen += batch.tolist()
    assert sorted(seen) == list(range(200))


# The judge.


def test_the_judge_sees_what_the_toolkit_sees() -> None:
    agreed = 0
    for seed in range(40):
        step = sheets(gap=0.0 if seed % 2 else 0.05, seed=seed)
        places = step.start + np.random.default_rng(seed).normal(0, 0.004 * (seed % 5), step.start.shape)
        faces = step.world.faces.astype(np.int32)
        mesh = ipctk.CollisionMesh(places, ipctk.edges(faces), faces)
        told = ipctk.has_intersections(mesh, places)
        assert told == (count_crossings(step.world, places) > 0), seed
        agreed += told
    assert 5 < agreed < 35


def test_winding_and_the_icosphere() -> None:
    corners, faces = icosphere(2)
    assert len(corners) == 162 and len(faces) == 320
    np.testing.assert_allclose(np.linalg.norm(corners, axis=1), 1.0)
    volume = np.linalg.det(corners[faces]).sum() / 6
    assert 0.95 * 4 / 3 * np.pi < volume < 4 / 3 * np.pi
    assert winding(np.array([0.1, -0.2, 0.5]), corners[faces]) == pytest.approx(1.0)
    assert winding(np.array([0.9, 0.9, 0.0]), corners[faces]) == pytest.approx(0.0, abs=1e-12)


def test_the_judge_knows_what_is_inside() -> None:
    scene = built_in(["ball"], ["cloth[0].grid.cells=[5,5]", "cloth[0].grid.size=[0.1,0.1]"])["ball"]
    simulation = Filtered(scene, lambda step: Outcome(step.proposed), 1)
    judge = Judge(simulation.world, simulation.guide)
    places = simulation.places.copy()
    cloth = len(simulation.mass)
    middle = places[:cloth].mean(axis=0)
    for centre, inside in (([0, 0, 0.3], 1), ([0, 0, -0.2], cloth), ([0, 0.5, 0.3], 0)):
        places[:cloth] = simulation.places[:cloth] - middle + centre
        seen = judge.look(places)
        assert (seen.crossings, seen.inside, seen.intersects) == (0, inside, inside > 0)
    places[:cloth] = simulation.places[:cloth] - middle + [0, 0, 0.504]
    assert 0.2 < judge.look(places).closest < 1.0


# The methods.


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("gap", [0.012, 0.03])
def test_momentum_is_kept(name: str, gap: float) -> None:
    step = sheets(gap, friction=0.4)
    outcome = METHODS[name](step)
    if name == "penalty" and gap > 0.02:
        np.testing.assert_array_equal(outcome.end, step.proposed)  # sees nothing of the way
        return
    assert np.abs(outcome.end - step.proposed).max() > 1e-3
    before, after = momenta(step, step.proposed), momenta(step, outcome.end)
    np.testing.assert_allclose(after[0], before[0], atol=1e-9 * len(step.start))


def test_repulsions_keep_angular_momentum_without_friction() -> None:
    """They act along the line between the closest places."""
    step = sheets(0.012)
    velocities = (step.proposed - step.start) / step.dt
    repel(step, step.world.pairs(0.0, step.start), velocities)
    before, after = momenta(step, step.proposed), momenta(step, step.start + step.dt * velocities)
    np.testing.assert_allclose(after[1], before[1], atol=1e-10)


@pytest.mark.parametrize("name", ["bridson", "provot"])
@pytest.mark.parametrize("seed", range(4))
def test_nothing_crosses_on_the_way(name: str, seed: int) -> None:
    step = sheets(0.005 + 0.005 * seed, seed=seed, friction=0.3)
    faces = step.world.faces.astype(np.int32)
    mesh = ipctk.CollisionMesh(step.start, ipctk.edges(faces), faces)
    assert not ipctk.is_step_collision_free(mesh, step.start, step.proposed)
    outcome = METHODS[name](step)
    assert outcome.clear
    assert ipctk.is_step_collision_free(mesh, step.start, outcome.end)
    assert count_crossings(step.world, outcome.end) == 0


def plank(angle: float, friction: float, gap: float) -> Step:
    """A triangle that lies on a slope, as a step of gravity proposes it; along x it goes down."""
    down, up = np.array([np.cos(angle), 0, -np.sin(angle)]), np.array([np.sin(angle), 0, np.cos(angle)])
    side = np.array([0, 1, 0])
    cloth = np.array([0.1 * a * down + 0.1 * b * side + gap * up for a, b in ((0, 0), (1, 0), (0, 1))])
    slope = np.array([a * down + b * side for a, b in ((-9, -9), (9, -9), (0, 9))])
    world = World(
        np.array([[0, 1, 2], [3, 4, 5]]),
        np.array([1.0] * 3 + [0] * 3),
        np.full(6, 0.01),
        np.full(6, friction),
        3,
    )
    start = np.concatenate([cloth, slope])
    proposed = start.copy()
    proposed[:3] += [0, 0, -9.81 * 0.01**2]
    return Step(world, start, proposed, 0.01, np.inf)


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("angle", [0.2, 0.4, 0.8])
def test_friction_on_a_slope_is_coulombs(name: str, angle: float) -> None:
    """What slides down has lost mu g cos(angle) of g sin(angle); below the angle of friction it stays."""
    mu = 0.5
    # Repulsions stop what is just within the thickness, collisions what meets the slope on its way; a spring
    # that is compressed by that way pushes by some of it.
    way = 9.81 * np.cos(angle) * 0.01**2
    gap = {"bridson": 0.02 - 1e-12, "provot": 1e-6, "penalty": 0.02 - 0.9 * way}[name]
    step = plank(angle, mu, gap)
    outcome = METHODS[name](step)
    moved = (outcome.end - step.start)[:3]
    down, up = np.array([np.cos(angle), 0, -np.sin(angle)]), np.array([np.sin(angle), 0, np.cos(angle)])
    along, pushed = moved @ down, (outcome.end - step.proposed)[:3] @ up
    expected = np.maximum(9.81 * 0.01**2 * np.sin(angle) - mu * pushed, 0.0)
    np.testing.assert_allclose(along, expected, atol=1e-12)
    assert (pushed > 0).all()
    if name != "penalty":
        np.testing.assert_allclose(pushed, 9.81 * 0.01**2 * np.cos(angle), rtol=1e-6)
        assert (along[0] == pytest.approx(0.0, abs=1e-12)) == (np.tan(angle) <= mu)


def test_repulsion_takes_a_tenth_of_the_overlap() -> None:
    """At rest, d = 10 mm too near: apart by 0.1 d in the step [Bridson02], by less if springs are soft."""
    step = plank(0.0, 0.0, 0.01)
    still = Step(step.world, step.start, step.start.copy(), step.dt, np.inf)
    rise = (bridson(still).end - still.start)[:3, 2]
    np.testing.assert_allclose(rise, 0.001, rtol=1e-9)
    soft = Step(step.world, step.start, step.start.copy(), step.dt, 2.0)
    weak = (bridson(soft).end - soft.start)[:3, 2]
    np.testing.assert_allclose(weak, 0.01**2 * 2.0 * 0.01, rtol=1e-6)  # dt^2 k d / m


# Zones.


def test_a_zone_keeps_momentum_and_angular_momentum() -> None:
    random = np.random.default_rng(8)
    start, velocities = random.normal(size=(9, 3)), random.normal(size=(9, 3))
    light = 1.0 / random.uniform(0.5, 2, 9)
    labels = np.array([0] * 5 + [5] * 3 + [8])
    mass, dt = 1 / light[:, None], 1e-6
    for advance in ("rotate", "linear"):
        end = rigid_motion(light, labels, start, velocities, dt, advance)
        new = (end - start) / dt
        for zone in (slice(0, 5), slice(5, 8), slice(8, 9)):
            old_p, new_p = (mass * v for v in (velocities, new))
            np.testing.assert_allclose(new_p[zone].sum(axis=0), old_p[zone].sum(axis=0), atol=1e-8)
            turns = [np.cross(start, p)[zone].sum(axis=0) for p in (old_p, new_p)]
            np.testing.assert_allclose(turns[1], turns[0], atol=2e-5)


def test_a_zone_is_rigid_and_leaves_rigid_motion_alone() -> None:
    random = np.random.default_rng(9)
    start, light = random.normal(size=(6, 3)), 1.0 / random.uniform(0.5, 2, 6)
    labels, dt, omega = np.zeros(6, int), 0.4, np.array([0.3, -1.1, 2.0])
    gaps = np.linalg.norm(start[:, None] - start, axis=2)
    turned = rigid_motion(light, labels, start, random.normal(size=(6, 3)), dt, "rotate")
    np.testing.assert_allclose(np.linalg.norm(turned[:, None] - turned, axis=2), gaps, atol=1e-12)
    velocities = np.cross(omega, start) + [1, 2, 3]
    linear = rigid_motion(light, labels, start, velocities, dt, "linear")
    np.testing.assert_allclose(linear, start + dt * velocities, atol=1e-12)
    # By the velocity a zone grows while it turns, by the rotation it does not.
    assert (np.linalg.norm(linear[:, None] - linear, axis=2) >= gaps - 1e-12).all()


def test_bodies_lead_zones() -> None:
    start = np.array([[0, 0, 0.1], [1, 0, 0], [0, 1, 0], [0, 0, 0]], float)
    light = np.array([1.0, 0, 0, 0])
    velocities = np.array([[3, 2, 1], [0, 0, 1], [0, 0, 1], [0, 0, 1]], float)
    end = rigid_motion(light, np.zeros(4, int), start, velocities, 0.5, "rotate")
    np.testing.assert_allclose(end, start + [0, 0, 0.5], atol=1e-12)


def test_pinched_cloth_becomes_a_zone() -> None:
    """Crumpled by so much that a round of impulses does not do; rounds and repulsions do [Bridson02]."""
    step = sheets(0.012, seed=0)
    crumpled = step.proposed + np.random.default_rng(0).normal(0, 0.1, step.start.shape)
    step = Step(step.world, step.start, crumpled, step.dt, np.inf)
    assert count_crossings(step.world, crumpled) > 20
    outcomes = [method(step) for method in (provot, bridson)]
    for outcome in outcomes:
        assert outcome.clear and count_crossings(step.world, outcome.end) == 0
    assert outcomes[0].rigid > 20 > outcomes[1].rigid
