"""The measuring about contact: bodies are what they say, and figures are computed right."""

from dataclasses import replace
from typing import Any

import ipctk
import numpy as np
import pytest
from taut import Scene, Simulation
from taut.bench.walker import SPEED, closed, squeezer, walk, walker

from tools.targets.contact import friction, pulled
from tools.targets.contact.chance import scene
from tools.targets.contact.heaps import LAYERS, THICKNESS, height, layers
from tools.targets.contact.judge import meets
from tools.targets.contact.scenes import Stage, sheet
from tools.targets.contact.shots import behind
from tools.targets.contact.travel import Travel
from tools.targets.contact.watch import Found, Watch, measured, row, said
from tools.targets.table import FULL, QUICK


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    return float(np.linalg.det(vertices[faces]).sum() / 6)


def assert_closed(vertices: np.ndarray, faces: np.ndarray) -> None:
    sides = np.concatenate([faces[:, [a, (a + 1) % 3]] for a in range(3)])
    assert {tuple(side) for side in sides.tolist()} == {tuple(side) for side in sides[:, ::-1].tolist()}
    assert len(np.unique(sides, axis=0)) == len(sides)


def test_closed_surfaces_are_turned_outwards() -> None:
    angle = np.arange(64) * 2 * np.pi / 64
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    vertices, faces = closed(np.stack([ring, ring + [0, 0, 2]]))
    assert_closed(vertices, faces)
    assert volume(vertices, faces) == pytest.approx(2 * np.pi, rel=0.01)
    vertices, faces = pulled.shell()
    assert_closed(vertices, faces)
    assert volume(vertices, faces) > 0


def test_the_squeezer_shuts_an_arm_and_never_meets_itself() -> None:
    vertices, faces, path = squeezer(2.0)
    assert_closed(vertices, faces)
    assert 8000 < len(faces) < 12000
    assert path.shape == (121, len(vertices), 3)
    np.testing.assert_allclose(path[0], vertices)
    np.testing.assert_allclose(path[-1], vertices)
    mesh = ipctk.CollisionMesh(vertices, ipctk.edges(faces.astype(np.int32)), faces.astype(np.int32))
    for places in path[::10]:
        assert not ipctk.has_intersections(mesh, places)
        assert volume(places, faces) == pytest.approx(volume(vertices, faces), rel=1e-6)
    turned = np.ptp(path, axis=0).max(axis=1) > 0
    torso = ~turned & (np.abs(vertices[:, 0]) < 0.14)
    shut = path[75]
    gap = shut[turned, 0].min() - shut[torso, 0].max()
    assert gap == pytest.approx(0.006, abs=2e-3)


@pytest.mark.parametrize("arms", ["none", "spread", "hanging"])
def test_a_walker_walks(arms: Any) -> None:
    simulation = Simulation(Scene({"body": walker(3.0, arms), "cloth": [{"grid": {"origin": [0, 0, 9]}}]}))
    travel = Travel(simulation)
    start, middle, end = (travel.at(time) for time in (0.0, 1.75, 3.0))
    assert len(start) == 2 * (6 if arms == "none" else 8)
    assert np.abs(travel.at(0.5) - start).max() < 1e-9
    assert (end - start)[0, 1] == pytest.approx(-SPEED * 2.25, rel=0.01)
    assert walk(3.0)[-1][1][1] == pytest.approx((end - start)[0, 1])
    feet = [simulation.body_ranges[number].first_vertex + 1 for number in (3, 5 if arms == "none" else 6)]
    assert abs(middle[feet[0], 1] - middle[feet[1], 1]) > 0.5, "legs are apart"


def test_bodies_are_where_the_scene_says() -> None:
    turn = {"axis": [0, 0, 1], "point": [1, 0, 0], "angle": [[1.0, 90.0]]}
    rod: dict[str, Any] = {"capsule": {"from": [0, 0, 0], "to": [0, 0, 1], "radius": 0.1}, "turn": turn}
    rod["move"] = [[0.5, [0, 0, 1]]]
    box = {"box": {"center": [3, 0, 0], "size": [1, 1, 1]}, "turn": turn}
    made = Stage({"fps": 60}).body({"name": "rod", **rod}, {"name": "box", **box})
    simulation = made.cloth("sheet", **sheet(3), translate=[0, 0, 9]).simulation()
    travel = Travel(simulation)
    np.testing.assert_allclose(travel.at(1.0)[:2], [[1, -1, 1], [1, -1, 2]], atol=1e-12)
    for _ in range(30):
        np.testing.assert_allclose(travel.at(simulation.time), simulation.body_positions, atol=1e-9)
        simulation.step()


def test_a_strip_over_a_rod_is_dragged_by_more() -> None:
    assert friction.pull(0.3, 2.0, 0.0) == pytest.approx(2 * np.exp(0.3 * np.pi), rel=1e-4)
    assert friction.pull(0.0, 2.0, 0.1) == pytest.approx(2.0, rel=1e-4), "as much of it goes up as down"
    assert friction.pull(0.3, 2.0, 0.1) > friction.pull(0.3, 2.0, 0.0)


def test_a_ball_behind_a_sheet_is_seen() -> None:
    for y, expected in ((-0.5, False), (0.5, True)):
        ball = {"name": "ball", "sphere": {"center": [0.02, y, 0.01], "radius": 0.1}}
        made = Stage({"fps": 60}).body(ball).cloth("sheet", **sheet(9), rotate=[90, 0, 0])
        simulation = made.simulation()
        corners = simulation.positions[simulation.faces]
        assert behind(corners, simulation.bodies["ball"].positions[0]) is expected


def test_a_stack_is_as_high_as_its_layers() -> None:
    simulation = layers(9, False).simulation()
    places = simulation.exact_positions
    for number, cloth in enumerate(simulation.cloths):
        places[cloth.first_vertex :][: cloth.vertices, 2] = 0.001 + THICKNESS * (number + 0.5)
    simulation.positions = places
    assert height(simulation) == pytest.approx(LAYERS * THICKNESS, rel=1e-4)


def test_what_stays_apart_by_a_tenth_of_a_millimetre_does_not_meet() -> None:
    # A vertex comes to 0.129 mm of a triangle: of cloth 1 mm thick that two bodies press together.
    before = np.array(
        [
            [0.0431922, -0.0306692, 0.0008827],
            [0.0431382, -0.0375961, 0.0091095],
            [0.043163, -0.0388251, -0.0058541],
            [0.0431658, -0.0284391, -0.0044547],
        ]
    )
    after = np.array(
        [
            [0.0462231, -0.0334286, -0.0045068],
            [0.0461955, -0.039784, 0.004365],
            [0.0462171, -0.0410719, -0.0109464],
            [0.0462258, -0.0306339, -0.0087313],
        ]
    )
    faces = np.array([[1, 2, 3]], np.int32)
    before, after = np.asfortranarray(before), np.asfortranarray(after)
    mesh = ipctk.CollisionMesh(before, ipctk.edges(faces), faces)
    assert not meets(mesh, before, after)
    after[0] = after[1:].mean(axis=0) - [1e-5, 0, 0]
    assert meets(mesh, before, after)


def test_what_a_watch_finds() -> None:
    held = {"thickness": 0.002, "pins": [{"edge": "left"}]}
    made = Stage({"fps": 60}).cloth("sheet", **sheet(5), **held)
    watch = Watch("sheet", made.simulation()).run(5, driven=True)
    found = watch.done(still=0)
    assert found.met
    assert (found.figures["frames"], found.figures["still"], found.figures["crossing"]) == (5, 0, 0)
    one, other = sheet(5), sheet(5, seed=2) | {"rotate": [90, 0, 0]}
    crossed = Stage({"fps": 60}).cloth("one", **one, thickness=0.002).cloth("other", **other, thickness=0.002)
    bad = Watch("crossed", crossed.simulation()).run(5).done()
    assert bad.failed.startswith("wrong at the start") and bad.figures["frames"] == 0


def test_cases_are_chosen_by_their_names(capsys: pytest.CaptureFixture[str]) -> None:
    def one(name: str, figure: float) -> Any:
        def measure() -> Found:
            found = Found(name)
            found.add("rest", figure, 1.0)
            return found

        return name, measure

    cases = [one("grid of 5²", 0.5), one("mesh of 5²", 2.0)]
    found = measured(cases, FULL)
    assert [one.met for one in found] == [True, False]
    assert "mesh of 5²: missed rest (rest 2)" in capsys.readouterr().err
    assert said(found[1], {"rest": ("jerks [mm]", 1e3)}) == "jerks [mm] 2e+03"
    made = row("to be still", found, {"rest": ("jerks [mm]", 1e3)})
    assert not made.met and "1 of 2 cases" in made.reached and "**2e+03**" in made.detail
    assert len(measured(cases, replace(FULL, case="mesh"))) == 1
    with pytest.raises(ValueError, match="no case"):
        measured(cases, replace(FULL, case="net"))


def test_chance_is_the_same_each_time() -> None:
    for seed in range(3):
        assert scene(seed, QUICK).document == scene(seed, QUICK).document
    assert scene(1, QUICK).document != scene(2, QUICK).document
