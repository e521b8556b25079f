import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation

import taut_contact
from contact import report
from contact.choose import LIMIT, Verdict, best, judge
from contact.contenders import CONTENDERS, FINE, OURS, Contender
from contact.oracle import INSET, Oracle, Touch, depth, icosphere, surface
from contact.results import Outcome, Results
from contact.scenes import CONTACT_SCENES, FRAMES, FRICTION, THICKNESS, Ball, Box, ContactSheet, Floor
from contact.session import ContactSession, fair_share
from harness import Job, serve
from search import MOTION
from store import WARM_UP, Case

EDGE = np.array([[0, 1]])


def segment(*ends: Any) -> NDArray[np.float64]:
    return np.array(ends, np.float64)


class TestScenes:
    @pytest.mark.parametrize("scene", CONTACT_SCENES)
    @pytest.mark.parametrize("size", [5, 8])
    def test_the_sheet_starts_unstretched_and_clear_of_everything(self, scene: str, size: int) -> None:
        sheet = ContactSheet(scene, size)
        for edges in (sheet.structural, sheet.diagonal, sheet.other_diagonal):
            now, rest = (
                np.linalg.norm(np.subtract(*places[edges.T]), axis=1)
                for places in (sheet.positions, sheet.flat)
            )
            assert np.allclose(now, rest)
        oracle = Oracle(sheet)
        assert not oracle.crosses_itself(sheet.positions)
        assert not oracle.crosses_bodies(sheet.positions)
        # Room for the thickness, and more.
        lower = sheet.positions - [0, 0, 0.02]
        assert max(depth(lower, sheet.structural, body) for body in sheet.bodies) == 0

    @pytest.mark.parametrize("scene", CONTACT_SCENES)
    def test_it_is_the_scene_that_taut_makes(self, scene: str) -> None:
        sheet = ContactSheet(scene, 6)
        job = sheet.as_job()
        grid = {"size": [1, 1], "cells": [5, 5], "origin": job["grid"]["origin"], "axes": ["x", "y"]}
        turned = {"rotate": [*job["grid"]["turned"], 0.0], "translate": job["grid"]["moved"]}
        cloth = {"name": "sheet", "grid": grid, "fabric": "cotton", "density": 0.2, "thickness": THICKNESS}
        fields = {"title": "sheet", "duration": 1.0, "cloth": [cloth | turned]}
        fields["body"] = [taut_contact.body_of(body) for body in job["bodies"]]
        ours = Simulation(Scene(fields), threads=1)
        assert np.allclose(ours.positions, sheet.positions, atol=1e-6)
        assert np.allclose(ours.mass, sheet.masses)
        assert np.array_equal(ours.faces, sheet.triangles)
        boxes = [body for body in sheet.bodies if isinstance(body, Box)]
        assert len(boxes) == (scene == "corner")
        for box in boxes:
            corners = ours.bodies["box"].positions
            local = (corners - np.array(box.centre)) @ box.axes
            assert np.allclose(np.abs(local), box.half, atol=1e-6)
            assert np.isclose(corners[:, 2].max(), 0.35 + 0.2 * 3**0.5, atol=1e-6)

    def test_the_quaternion_is_the_matrix(self) -> None:
        box = Box((0, 0, 0), (1, 1, 1), (31.0, -58.0))
        w, x, y, z = box.as_job()["quaternion"]
        matrix = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        assert np.allclose(matrix, box.axes)

    def test_unknown_scenes_are_refused(self) -> None:
        with pytest.raises(ValueError, match="ball, corner, heap"):
            ContactSheet("one-corner", 5)


class TestDepth:
    def test_edges_count_where_their_ends_are_outside(self) -> None:
        ball = Ball((0.0, 0.0, 0.0), 0.5)
        assert depth(segment((-1, 0, 0.3), (1, 0, 0.3)), EDGE, ball) == pytest.approx(0.2)
        assert depth(segment((-1, 0, 0.6), (1, 0, 0.6)), EDGE, ball) == 0
        assert depth(segment((0, 0, 0.1), (0, 0, 9)), EDGE, ball) == pytest.approx(0.4)

    def test_the_deepest_point_of_an_edge_in_a_box_is_found(self) -> None:
        box = Box((1.0, 2.0, 3.0), (0.5, 0.4, 0.3), (20.0, -35.0))

        def at(*local: float) -> NDArray[np.float64]:
            return np.array(local) @ box.axes.T + np.array(box.centre)

        through = segment(at(-2, 0.1, 0.05), at(2, 0.1, 0.05))
        assert depth(through, EDGE, box) == pytest.approx(0.25)
        # From face to face across an edge of the box: deepest where both faces are as near.
        across = segment(at(0.3, 0, 0.5), at(0.7, 0, 0.1))
        assert depth(across, EDGE, box) == pytest.approx(0.0, abs=1e-12)
        deeper = segment(at(0.3, 0, 0.4), at(0.6, 0, 0.1))
        assert depth(deeper, EDGE, box) == pytest.approx(0.05)
        assert depth(segment(at(0, 0, 0.31), at(0.51, 0, 0.31)), EDGE, box) == 0

    def test_it_is_what_many_points_of_the_edges_say(self) -> None:
        random = np.random.default_rng(3)
        box = Box((0.1, -0.2, 0.3), (0.3, 0.5, 0.4), (33.0, 71.0))
        ends = random.uniform(-1, 1, (400, 3)) + np.array(box.centre)
        edges = np.arange(400).reshape(-1, 2)
        found = [depth(ends[pair], EDGE, box) for pair in edges]
        along = np.linspace(0, 1, 2001)[:, None, None]
        points = (1 - along) * ends[edges[:, 0]] + along * ends[edges[:, 1]]
        local = np.abs((points - np.array(box.centre)) @ box.axes)
        sampled = np.maximum((np.array(box.half) - local).min(axis=2).max(axis=0), 0)
        assert np.count_nonzero(sampled) > 50
        assert np.all(np.array(found) >= sampled - 1e-12)
        assert np.allclose(found, sampled, atol=2e-3)
        assert depth(ends, edges, box) == pytest.approx(max(found))

    def test_a_floor_is_as_deep_as_the_lowest_vertex(self) -> None:
        assert depth(segment((0, 0, 1), (0, 0, -0.03)), EDGE, Floor(0.01)) == pytest.approx(0.04)


class TestOracle:
    def test_the_ball_of_triangles_is_inside_of_the_ball_and_near(self) -> None:
        vertices, triangles = icosphere(3)
        assert len(triangles) == 20 * 4**3
        assert len(vertices) - len(triangles) / 2 == 2  # Euler's, of a closed surface
        assert np.allclose(np.linalg.norm(vertices, axis=1), 1)
        a, b, c = (vertices[corner] for corner in triangles.T)
        assert np.all(np.einsum("ij,ij->i", np.cross(b - a, c - a), a) > 0)
        found = surface(Ball((1.0, 0.0, 0.0), 0.3))
        assert found is not None
        places, faces = found
        middles = places[faces].mean(axis=1)
        heights = 0.3 - np.linalg.norm(middles - [1, 0, 0], axis=1)
        assert heights.min() > 0
        assert heights.max() < INSET + 1e-4

    def test_a_fold_that_goes_through_itself_and_one_that_does_not(self) -> None:
        sheet = ContactSheet("heap", 9)
        oracle = Oracle(sheet)
        angle = 5.6 * sheet.flat[:, 0]
        rolled = np.stack([np.sin(angle) / 5.6, sheet.flat[:, 1], 1 - np.cos(angle) / 5.6], axis=1)
        assert not oracle.crosses_itself(rolled)
        # A spiral whose radius does not change meets itself after more than one turn, if it is askew.
        angle = 8.4 * sheet.flat[:, 0]
        shift = 0.02 * (sheet.flat[:, 1] - 0.4)
        twice = np.stack([np.sin(angle) / 8.4 + shift, sheet.flat[:, 1], 1 - np.cos(angle) / 8.4], axis=1)
        assert oracle.crosses_itself(twice)

    def test_a_sheet_that_touches_the_ball_does_not_count_and_one_in_it_does(self) -> None:
        sheet = ContactSheet("ball", 9)
        oracle = Oracle(sheet)
        ball = sheet.bodies[0]
        assert isinstance(ball, Ball)
        # Flat on its top, with a vertex right there.
        level = sheet.flat - sheet.flat[4 * 9 + 4] + np.array(ball.centre)
        for below, crosses in ((0.0, False), (2 * INSET, True), (0.05, True), (0.7, False)):
            positions = level + [0, 0, ball.radius - below]
            assert oracle.crosses_bodies(positions) == crosses
            reached = depth(positions, sheet.structural, ball)
            assert reached == pytest.approx(min(below, 0.3) if below < 0.6 else 0.0)

    def test_below_the_floor_counts(self) -> None:
        sheet = ContactSheet("heap", 5)
        oracle = Oracle(sheet)
        lowest = sheet.positions[:, 2].min()
        assert not oracle.crosses_bodies(sheet.positions - [0, 0, lowest])
        assert oracle.crosses_bodies(sheet.positions - [0, 0, lowest + 2 * INSET])

    def test_frames_are_counted_one_by_one(self) -> None:
        sheet = ContactSheet("heap", 5)
        frames = np.repeat(sheet.positions[None], 6, axis=0)
        lowest = sheet.positions[:, 2].min()
        frames[1] -= [0, 0, lowest + 0.003]
        frames[2, 0] += 1.5 * (frames[2, 6] - frames[2, 0])  # folds a corner flat, not through anything
        frames[3, :, 2] -= 0.1
        frames[5, 7, 1] = np.nan
        touch = Oracle(sheet).measure(frames)
        assert (touch.frames, touch.finite) == (5, False)
        assert (touch.itself, touch.bodies, touch.wrong) == (touch.itself, 2, 2 + touch.itself)
        assert touch.depth == pytest.approx(max(0.003, 0.1 - lowest))
        assert touch.falls == pytest.approx([0, lowest + 0.003, touch.falls[2], 0.1, 0], abs=1e-6)

    def test_stretch_is_that_of_rows_and_columns_and_with_diagonals(self) -> None:
        sheet = ContactSheet("ball", 3)
        frames = np.repeat(sheet.positions[None], 2, axis=0)
        frames[1, 0, 0] -= 0.05
        touch = Oracle(sheet).measure(frames)
        assert touch.worst == pytest.approx(0.1)
        assert touch.worst_everywhere == pytest.approx(0.1)
        frames[1, 0, 1] -= 0.05  # the diagonal of its quad ends there
        touch = Oracle(sheet).measure(frames)
        assert touch.worst == pytest.approx(np.hypot(0.55, 0.05) / 0.5 - 1)
        assert touch.worst_everywhere == pytest.approx(max(0.1, touch.worst))


def touched(**fields: Any) -> Touch:
    usual = {"frames": 10, "worst": 0.04, "worst_everywhere": 0.06, "itself": 0, "bodies": 0, "wrong": 0}
    return Touch(**usual | {"depth": 0.0, "falls": [0.1 * (n + 1) for n in range(10)]} | fields)


def outcome(
    contender: Contender = OURS, cost: float = 4.0, scene: str = "ball", size: int = 33, **fields: Any
) -> Outcome:
    settings = {"strain_limit": 0.05} if contender is OURS else contender.settings(size)[0]
    case = contender.case(settings | fields.pop("settings", {}), scene, size)
    error = fields.pop("error", None)
    cpu_ms = [1000.0] * WARM_UP + [cost] * (FRAMES - WARM_UP)
    return Outcome(case, cpu_ms, 30.0, touched(**fields), error, "abacus")


REFERENCE = [0.1 * (n + 1) for n in range(FRAMES)]


class TestChoice:
    @pytest.mark.parametrize(
        ("fields", "broken"),
        [
            ({}, ()),
            ({"worst": LIMIT + 0.01}, ("stretch",)),
            ({"wrong": 1}, ("intersections",)),
            ({"falls": [0.0] * 10}, ("motion",)),
            ({"falls": [0.79] * 10}, ("motion",)),
            ({"falls": [0.81] * 10}, ()),
            ({"falls": [1.19] * 10}, ()),
            ({"falls": [1.21] * 10}, ("motion",)),
            ({"error": "the cloth blew up", "wrong": 3}, ("failed", "intersections")),
            ({"frames": 0, "falls": []}, ("failed",)),
        ],
    )
    def test_what_is_broken(self, fields: dict[str, Any], broken: tuple[str, ...]) -> None:
        assert judge(outcome(**fields), REFERENCE).broken == broken

    def test_motion_is_compared_at_the_last_frame_that_was_made(self) -> None:
        verdict = judge(outcome(frames=5, falls=[0.1, 0.2, 0.3, 0.4, 0.45]), REFERENCE)
        assert verdict.motion == pytest.approx(0.9)

    def test_the_cheapest_that_breaks_nothing_wins(self) -> None:
        costs = {1.0: {"wrong": 1}, 3.0: {}, 2.0: {}, 0.5: {"worst": 0.2}}
        verdicts = [judge(outcome(cost=cost, **fields), REFERENCE) for cost, fields in costs.items()]
        chosen = best(verdicts)
        assert chosen is not None
        assert chosen.outcome.cost == 2.0

    def test_or_the_one_that_is_least_off(self) -> None:
        low, _ = MOTION
        tried: list[dict[str, Any]] = [
            {"worst": LIMIT + 0.35},
            {"wrong": 3},
            {"falls": [0.5 * low] * 10},
            {"error": "the cloth blew up", "worst": 0.0},
        ]
        verdicts = [judge(outcome(cost=4.0 - n, **fields), REFERENCE) for n, fields in enumerate(tried)]
        assert [verdict.excess for verdict in verdicts[:2]] == pytest.approx([0.35, 0.3])
        assert best(verdicts) is verdicts[1]
        assert best([verdicts[0], verdicts[3]]) is verdicts[0]
        frozen = judge(outcome(worst=0.0, falls=[0.0] * 10), REFERENCE)
        tangled = judge(outcome(worst=LIMIT + 0.5, wrong=10), REFERENCE)
        assert best([frozen, tangled]) is tangled
        assert best([]) is None

    def test_time_is_shared_where_cheap_ones_want_less(self) -> None:
        assert fair_share([1.0, 100.0, 100.0], 21.0) == pytest.approx(10.0)
        assert fair_share([1.0, 2.0], 30.0) >= 2.0
        assert fair_share([5.0, 5.0], 4.0) == pytest.approx(2.0)
        assert fair_share([], 4.0) == 4.0


class TestResults:
    def test_they_come_back_with_timings_of_the_same_frames(self, tmp_path: Path) -> None:
        path = tmp_path / "deep" / "contact.jsonl"
        run = outcome(cost=4.0)
        results = Results(path)
        results.add(run)
        assert Results(path).costs(run.case) == [4.0]
        for ms in (8.0, 2.0):
            results.add(Outcome(run.case, [70.0] * WARM_UP + [ms] * 3, 1.0))
        again = Results(path)
        assert again.get(run.case) == run
        assert again.costs(run.case) == again.costs(run.case, 20) == [4.0, 8.0, 2.0]
        assert again.machine == "abacus"
        results.add(run)
        assert Results(path).costs(run.case) == [4.0]

    def test_frames_that_cost_more_later_are_scaled(self, tmp_path: Path) -> None:
        results = Results(tmp_path / "contact.jsonl")
        run = outcome()
        run = Outcome(run.case, [0.0] * WARM_UP + [10.0] * 5 + [30.0] * 5, 30.0, run.touch)
        results.add(run)
        results.add(Outcome(run.case, [9.0] * WARM_UP + [5.0] * 5, 1.0))
        assert results.costs(run.case) == [20.0, 10.0]
        assert results.costs(run.case, WARM_UP + 5) == [10.0, 5.0]

    def test_a_cut_line_and_what_is_missing(self, tmp_path: Path) -> None:
        path = tmp_path / "contact.jsonl"
        results = Results(path)
        results.miss("jolt", "no node")
        results.miss("newton", "no wheel")
        results.found("newton")
        results.add(outcome())
        path.write_text(path.read_text()[:-30])
        again = Results(path)
        assert again.missing == {"jolt": "no node"}
        assert again.get(outcome().case) is None


def table(tmp_path: Path, verdicts: Mapping[str, Verdict], missing: str = "") -> list[str]:
    results = Results(tmp_path / "contact.jsonl")
    chosen = {}
    for verdict in verdicts.values():
        results.add(verdict.outcome)
        case = verdict.outcome.case
        chosen[case.engine, case.scene, case.size] = verdict
    if missing:
        results.miss(missing, f"{missing} is left out: there is none.")
    page = tmp_path / "peers.md"
    page.write_text(f"# Page\n\n{report.BEGIN}old\n{report.END}\n\nThe rest.\n")
    report.write(CONTENDERS, chosen, results, tmp_path)
    text = page.read_text()
    assert text.startswith("# Page\n")
    assert text.endswith(f"{report.END}\n\nThe rest.\n")
    assert "old" not in text
    return text.splitlines()


def row(lines: list[str], *starts: str) -> list[str]:
    found = [line for line in lines if line.startswith("| " + " | ".join(starts) + " |")]
    assert found, starts
    return [cell.strip() for cell in found[0].strip("|").split("|")]


class TestTable:
    def test_costs_in_times_of_ours_and_what_is_broken(self, tmp_path: Path) -> None:
        rapier = next(contender for contender in CONTENDERS if contender.name == "rapier")
        lines = table(
            tmp_path,
            {
                "ours": judge(outcome(cost=4.0), REFERENCE),
                "broken": judge(
                    outcome(rapier, cost=48.0, worst=0.19, wrong=3, itself=2, bodies=1, depth=0.0213),
                    REFERENCE,
                ),
                "larger": judge(outcome(rapier, cost=300.0, size=65), REFERENCE),
            },
            missing="jolt",
        )
        assert row(lines, "CPU ms a frame")[1:] == ["ball, 33²", "ball, 65²"]
        assert row(lines, "taut")[1:] == ["4.0; first 0.17 s", "not run"]
        theirs = row(lines, "Rapier")
        assert theirs[1:] == [
            "48 (12 ×); 3 of 10 frames intersect, stretch 19.0 %, first 0.17 s",
            "300; first 0.17 s",
        ]
        assert row(lines, "Jolt (WebAssembly)")[1:] == ["not installed"] * 2
        assert row(lines, "Newton (CPU)")[1:] == ["not run"] * 2
        assert "- jolt is left out: there is none." in lines
        detail = row(lines, "Rapier", "ball", "33²")
        assert detail[4:] == ["48", "19.0 %", "2 itself, 1 bodies", "21.3", "100 %", "0.17", "no"]
        assert row(lines, "taut", "ball", "33²")[-1] == "yes"
        assert any(line.startswith("Measured on abacus.") for line in lines)

    def test_a_shorter_run_is_compared_with_the_same_frames_of_ours(self, tmp_path: Path) -> None:
        rapier = next(contender for contender in CONTENDERS if contender.name == "rapier")
        ours = outcome(cost=4.0)
        ours = Outcome(ours.case, [0.0] * WARM_UP + [2.0] * 5 + [90.0] * 110, 30.0, ours.touch)
        lines = table(
            tmp_path,
            {"ours": judge(ours, REFERENCE), "short": judge(outcome(rapier, cost=20.0), REFERENCE)},
        )
        assert row(lines, "Rapier")[1] == "20 (10 ×); first 0.17 s"

    def test_a_failure_says_why(self, tmp_path: Path) -> None:
        failed = Outcome(outcome().case, [], 30.0, error="no such shape", machine="abacus")
        lines = table(tmp_path, {"failed": judge(failed, REFERENCE)})
        assert row(lines, "taut")[1] == "failed: no such shape"


class TestTaut:
    @pytest.mark.parametrize("scene", CONTACT_SCENES)
    def test_its_adapter_drapes_without_intersections_within_the_limit(
        self, scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        sheet = ContactSheet(scene, 12)
        files = {name: str(tmp_path / name) for name in ("environment", "output", "report")}
        job = {"settings": {"strain_limit": 0.05}, "frames": 50, "seconds": 60.0, "foresee": False}
        (tmp_path / "job.json").write_text(json.dumps(sheet.as_job() | job | files))
        monkeypatch.setattr("sys.argv", ["adapter", str(tmp_path / "job.json")])
        serve(taut_contact.Grid)
        frames = np.fromfile(tmp_path / "output", np.float64).reshape(-1, 144, 3)
        touch = Oracle(sheet).measure(frames)
        assert touch.frames == 50
        assert touch.wrong == 0
        assert touch.depth == 0
        assert 0.001 < touch.worst <= LIMIT + 1e-6
        assert 0.2 < touch.falls[-1] < 0.6
        assert all(np.diff(touch.falls[:10]) > 0)

    def test_finer_steps_are_finer(self, tmp_path: Path) -> None:
        sheet = ContactSheet("ball", 6)
        files = {name: str(tmp_path / name) for name in ("environment", "output", "report")}
        fields = sheet.as_job() | {"frames": 1, "seconds": 1.0, "foresee": False} | files
        substeps = []
        for settings in (OURS.settings(6)[0], FINE.settings(6)[0]):
            (tmp_path / "job.json").write_text(json.dumps(fields | {"settings": settings}))
            substeps.append(taut_contact.Grid(Job(tmp_path / "job.json"))._simulation.substeps)
        assert substeps[1] == 4 * substeps[0]


class TestSession:
    def test_taut_is_searched_timed_and_written(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("contact.session.CONTACT_SCENES", ("heap",))
        page = tmp_path / "peers.md"
        page.write_text(f"{report.BEGIN}{report.END}")
        session = ContactSession(["taut"], [7], 30.0, tmp_path / "out")
        session.search()
        session.retime(2.0)
        session.write(tmp_path)
        lines = page.read_text().splitlines()
        cells = row(lines, "taut", "heap", "7²")
        assert cells[-1] == "yes"
        assert "–" in cells[4]
        kept = len((tmp_path / "out" / "contact.jsonl").read_text().splitlines())
        again = ContactSession(["taut"], [7], 30.0, tmp_path / "out")
        again.search()
        assert len((tmp_path / "out" / "contact.jsonl").read_text().splitlines()) == kept


@pytest.mark.parametrize("contender", CONTENDERS, ids=lambda contender: contender.name)
def test_every_engine_has_an_adapter_and_settings_from_cheap_to_dear(contender: Contender) -> None:
    adapters = Path(__file__).parents[1] / "benches" / "peers" / "adapters"
    assert (adapters / contender.engine.adapter).is_file()
    for size in (17, 33, 65):
        tried = contender.settings(size)
        assert 1 <= len(tried) <= 4
        assert len({json.dumps(settings) for settings in tried}) == len(tried)


def test_names_of_results_differ() -> None:
    names = [contender.name for contender in [*CONTENDERS, FINE]]
    assert len(set(names)) == len(names)
    assert Case("a", "b", {}, "ball", 5).key != Case("a", "b", {}, "heap", 5).key
    assert FRICTION == 0.4
