import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene, Simulation

from contact.contenders import CONTENDERS
from engines import ENGINES, TAUT
from harness import Job, serve
from judge import Reference, reference_of, trials_of, winners_of
from metric import Measured, measure
from run import options
from search import Family, Run, Settings, Trial, attempt, cheapest, search
from sheet import FPS, GRAVITY, SCENES, Sheet
from store import WARM_UP, Case, Record, Store

LIMITS = (0.10, 0.05, 0.01)


def still(sheet: Sheet, frames: int) -> NDArray[np.float32]:
    return np.repeat(sheet.positions[None], frames, axis=0).astype(np.float32)


class TestSheet:
    @pytest.mark.parametrize("size", [2, 5, 8])
    def test_it_is_the_cloth_that_taut_makes(self, size: int) -> None:
        sheet = Sheet("two-corners", size)
        grid = {"size": [1, 1], "cells": [size - 1] * 2, "origin": [0, 0, 0], "axes": ["x", "y"]}
        pins = [{"corner": "bottom-left"}, {"corner": "top-left"}]
        cloth = {"name": "sheet", "grid": grid, "fabric": "cotton", "density": 0.2, "pins": pins}
        ours = Simulation(Scene({"title": "sheet", "duration": 1.0, "cloth": [cloth]}), threads=1)
        assert np.allclose(ours.positions, sheet.positions)
        assert np.allclose(ours.mass, sheet.masses)
        assert list(np.flatnonzero(ours.pinned)) == sheet.pins
        assert np.array_equal(ours.faces, sheet.triangles)
        edges = np.concatenate([sheet.structural, sheet.diagonal, sheet.other_diagonal])
        assert {frozenset(pair) for pair in ours.springs.tolist()} == {
            frozenset(pair) for pair in edges.tolist()
        }

    def test_scenes_differ_in_their_pins(self) -> None:
        assert Sheet("one-corner", 4).pins == [0]
        assert Sheet("two-corners", 4).pins == [0, 12]
        with pytest.raises(ValueError, match="one-corner, two-corners"):
            Sheet("flag", 4)
        with pytest.raises(ValueError, match="at least 2"):
            Sheet("one-corner", 1)


class TestMetric:
    def test_a_sheet_at_rest_neither_stretches_nor_moves(self) -> None:
        sheet = Sheet("one-corner", 6)
        measured = measure(sheet, still(sheet, 40))
        assert measured.worst == pytest.approx(0, abs=1e-6)
        assert measured.peak_speed == pytest.approx(0, abs=1e-6)

    def test_the_worst_edge_of_the_worst_frame_after_half_a_second(self) -> None:
        sheet = Sheet("one-corner", 3)
        frames = still(sheet, 60)
        frames[29, 0, 0] -= 0.2  # at 0.5 s: does not count
        frames[35, 0, 0] -= 0.05  # its row's first edge was 0.5 m long
        frames[40, 0, 0] -= 0.02
        measured = measure(sheet, frames)
        assert measured.worst == pytest.approx(0.1, abs=1e-5)
        assert measured.worst_time == pytest.approx(36 / FPS)
        assert measured.worst_everywhere == pytest.approx(0.4, abs=1e-5)

    def test_the_other_diagonals_count_only_everywhere(self) -> None:
        sheet = Sheet("one-corner", 2)
        frames = still(sheet, 40)
        frames[:, [1, 2]] += np.array([0.1, -0.1, 0], np.float32), np.array([-0.1, 0.1, 0], np.float32)
        assert sheet.other_diagonal.tolist() == [[1, 2]]
        measured = measure(sheet, frames)
        assert measured.worst == pytest.approx(np.hypot(1.1, 0.1) - 1, abs=1e-5)
        assert measured.worst_everywhere == pytest.approx(0.2, abs=1e-5)

    def test_speed_is_that_of_the_centre_of_mass(self) -> None:
        sheet = Sheet("one-corner", 5)
        frames = still(sheet, 4)
        frames[1:, :, 2] -= 0.05
        assert measure(sheet, frames).peak_speed == pytest.approx(0.05 * FPS, rel=1e-5)
        frames = still(sheet, 4)
        frames[1:, 0, 2] -= 0.8  # a corner carries a quarter of an inner particle: 1/64 of the sheet
        assert measure(sheet, frames).peak_speed == pytest.approx(0.8 / 64 * FPS, rel=1e-5)

    def test_what_falls_or_swings_gains_no_energy(self) -> None:
        sheet, times = Sheet("one-corner", 5), np.arange(1, 41) / FPS
        frames = still(sheet, 40)
        frames[:, :, 2] -= (GRAVITY / 2 * times**2)[:, None]
        assert measure(sheet, frames).gained == 0.0
        speed, length = 2.0, 0.5  # round and round at one height: the energy of motion, less the bent chord's
        frames = still(sheet, 40)
        angles = speed / length * times
        frames[:, :, :2] += length * np.stack([np.cos(angles) - 1, np.sin(angles)], axis=1)[:, None]
        assert measure(sheet, frames).gained == pytest.approx(speed**2 / (2 * GRAVITY), rel=1e-3)

    def test_energy_is_gained_by_what_rises_and_by_what_trembles(self) -> None:
        sheet = Sheet("one-corner", 5)
        frames = still(sheet, 3)
        frames[1:, :, 2] += 0.3
        assert measure(sheet, frames).gained == pytest.approx(
            0.15 + (0.3 * FPS) ** 2 / (2 * GRAVITY), rel=1e-5
        )
        frames = still(sheet, 3)
        frames[1, 6, 0] += 0.01  # an inner particle: 1/16 of the sheet, whose centre hardly moves
        trembled = measure(sheet, frames)
        assert trembled.gained == pytest.approx((0.01 * FPS) ** 2 / 16 / (2 * GRAVITY), rel=1e-5)
        assert trembled.peak_speed == pytest.approx(0.01 * FPS / 16, rel=1e-5)

    def test_what_is_not_finite_has_no_stretch(self) -> None:
        sheet = Sheet("one-corner", 3)
        frames = still(sheet, 50)
        frames[45, 2, 1] = np.nan
        assert measure(sheet, frames) == Measured(
            None, None, None, pytest.approx(0, abs=1e-6), pytest.approx(0, abs=1e-6)
        )

    def test_a_run_that_was_too_short_has_no_worst_stretch(self) -> None:
        sheet = Sheet("one-corner", 3)
        measured = measure(sheet, still(sheet, 30))
        assert measured.worst is None
        assert measured.worst_everywhere == pytest.approx(0, abs=1e-6)


class Fake:
    """An engine whose stretch halves and whose cost doubles when the effort doubles."""

    def __init__(self, stretch: float, cost: float = 1.0) -> None:
        self.stretch, self.cost = stretch, cost
        self.asked: list[tuple[str, int]] = []

    def run(self, settings: Settings, scene: str) -> Run | None:
        effort = int(settings["effort"])
        self.asked.append((scene, effort))
        weak = 2.0 if settings.get("kind") == "weak" else 1.0
        return Run(weak * self.stretch / effort, motion=1.0, cost=weak * self.cost * effort)

    def attempt(self, settings: Settings) -> Trial | None:
        return attempt(settings, SCENES, 2 * max(LIMITS), self.run)


def found(trials: list[Trial]) -> dict[float, int | None]:
    winners = {limit: cheapest(trials, limit) for limit in LIMITS}
    return {
        limit: None if trial is None else int(trial.settings["effort"]) for limit, trial in winners.items()
    }


class TestSearch:
    def test_doubles_then_halves_the_gap_twice(self) -> None:
        fake = Fake(stretch=1.0)
        trials = search([Family({}, "effort", 1, 1024)], LIMITS, fake.attempt)
        # From 10, 20 and 100 on the limits are kept; the last gap is halved to 96, which fails, then to 112.
        assert found(trials) == {0.10: 10, 0.05: 20, 0.01: 112}

    def test_hopeless_settings_are_not_tried_in_the_second_scene(self) -> None:
        fake = Fake(stretch=1.0)
        search([Family({}, "effort", 1, 1024)], LIMITS, fake.attempt)
        second = [effort for scene, effort in fake.asked if scene == SCENES[1]]
        assert second == [8, 16, 32, 64, 128, 12, 24, 96, 10, 20, 112]

    def test_a_family_that_costs_more_is_left_early(self) -> None:
        fake = Fake(stretch=1.0)
        good, weak = Family({}, "effort", 1, 1024), Family({"kind": "weak"}, "effort", 1, 1024)
        trials = search([good, weak], LIMITS, fake.attempt)
        assert found(trials) == {0.10: 10, 0.05: 20, 0.01: 112}
        assert max(int(trial.settings["effort"]) for trial in trials if "kind" in trial.settings) == 64

    def test_a_better_family_wins_where_it_is_better(self) -> None:
        fake = Fake(stretch=1.0)
        good, weak = Family({}, "effort", 66, 1024), Family({"kind": "weak"}, "effort", 1, 1024)
        trials = search([good, weak], LIMITS, fake.attempt)
        winner = cheapest(trials, 0.10)
        assert winner is not None
        assert winner.settings == {"kind": "weak", "effort": 20}

    def test_frozen_cloth_does_not_win(self) -> None:
        def frozen(settings: Settings, scene: str) -> Run:
            motion = 0.5 if scene == "two-corners" and settings["effort"] == 1 else 0.8
            return Run(0.001, motion, cost=float(settings["effort"]))

        trials = search(
            [Family({}, "effort", 1, 8)], LIMITS, lambda settings: attempt(settings, SCENES, 0.2, frozen)
        )
        assert found(trials) == {0.10: 2, 0.05: 2, 0.01: 2}

    @pytest.mark.parametrize(
        ("motion", "gained", "kept"),
        [(0.79, 0, False), (0.8, 0, True), (1.2, 0.05, True), (1.21, 0, False), (1.0, 0.06, False)],
    )
    def test_cloth_that_is_frozen_or_gains_energy_does_not_count(
        self, motion: float, gained: float, kept: bool
    ) -> None:
        runs = (Run(0.01, 1.0, 1.0), Run(0.01, motion, 1.0, gained))
        trial = Trial({}, runs, all_scenes=True)
        assert trial.holds(0.05)
        assert trial.keeps(0.05) is kept
        assert trial.motions == (min(motion, 1.0), max(motion, 1.0))

    def test_what_blows_up_is_climbed_on_and_what_runs_out_of_time_is_not(self) -> None:
        def fragile(settings: Settings, scene: str) -> Run:
            effort = int(settings["effort"])
            if effort < 4:
                return Run(None, 0.0, 1.0, complete=False)
            return Run(0.02, 1.0, float(effort), complete=effort < 16, out_of_time=effort >= 16)

        asked: list[int] = []

        def try_it(settings: Settings) -> Trial | None:
            asked.append(int(settings["effort"]))
            return attempt(settings, SCENES, 0.2, fragile)

        trials = search([Family({}, "effort", 1, 1024)], LIMITS, try_it)
        assert asked == [1, 2, 4, 8, 16, 3]
        assert found(trials) == {0.10: 4, 0.05: 4, 0.01: None}

    def test_a_family_is_left_when_more_effort_does_not_help(self) -> None:
        stretches = {1: 0.50, 2: 0.30, 4: 0.15, 8: 0.145, 16: 0.12, 32: 0.13, 64: 0.11, 128: 0.05}
        asked: list[int] = []

        def stiff(settings: Settings, scene: str) -> Run:
            asked.append(int(settings["effort"]))
            return Run(stretches[asked[-1]], 1.0, cost=float(asked[-1]))

        search(
            [Family({}, "effort", 1, 1024)], LIMITS, lambda settings: attempt(settings, SCENES[:1], 1, stiff)
        )
        assert asked == [1, 2, 4, 8, 16, 32, 64]

    def test_a_family_is_left_when_more_effort_freezes_the_cloth(self) -> None:
        motions = {1: 0.7, 2: 0.75, 3: 0.85, 4: 0.9, 8: 0.79}
        asked: list[int] = []

        def slow(settings: Settings, scene: str) -> Run:
            asked.append(int(settings["effort"]))
            return Run(0.2 / asked[-1], motions[asked[-1]], cost=float(asked[-1]))

        trials = search(
            [Family({}, "effort", 1, 16)], LIMITS, lambda settings: attempt(settings, SCENES[:1], 1, slow)
        )
        assert asked == [1, 2, 4, 8, 3]
        assert found(trials) == {0.10: 3, 0.05: 4, 0.01: None}

    def test_finds_the_window_between_too_soft_and_frozen(self) -> None:
        def narrow(settings: Settings, scene: str) -> Run:
            effort = int(settings["effort"])
            return Run(worst=1.0 / effort, motion=1.0 if effort < 13 else 0.7, cost=1.0)

        trials = search(
            [Family({}, "effort", 4, 64)], (0.1,), lambda settings: attempt(settings, SCENES[:1], 1, narrow)
        )
        winner = cheapest(trials, 0.1)
        assert winner is not None
        assert winner.settings == {"effort": 12}

    def test_efforts_are_multiples_where_they_must_be(self) -> None:
        fake = Fake(stretch=1.0)
        search([Family({}, "effort", 8, 1024, multiple=4)], LIMITS, fake.attempt)
        assert {effort % 4 for _, effort in fake.asked} == {0}
        assert 20 in [effort for _, effort in fake.asked]

    def test_the_search_ends_when_the_time_is_spent(self) -> None:
        fake = Fake(stretch=1.0)
        left = iter([True] * 4 + [False])
        trials = search(
            [Family({}, "effort", 1, 64), Family({"kind": "weak"}, "effort", 1, 64)],
            LIMITS,
            lambda settings: fake.attempt(settings) if next(left) else None,
        )
        assert [trial.settings["effort"] for trial in trials] == [1, 2, 4, 8]

    def test_time_that_ends_between_the_scenes_leaves_half_a_trial(self) -> None:
        runs = iter([Run(0.01, 1.0, 1.0), None])
        trial = attempt({"effort": 1}, SCENES, 0.2, lambda settings, scene: next(runs))
        assert trial is not None
        assert not trial.keeps(0.1)


def record(scene: str, effort: int, worst: float, cost: float, engine: str = "taut") -> Record:
    case = Case(engine, ENGINES[engine].version, {"effort": effort}, scene, 32)
    measured = Measured(worst, 1.0, worst, 2.0, 0.0)
    return Record(case, [1000.0] * WARM_UP + [cost] * 10, True, 60.0, 0.5, measured, machine="abacus")


class TestStore:
    def test_results_come_back_and_the_newest_counts(self, tmp_path: Path) -> None:
        store = Store(tmp_path / "deep" / "results.jsonl")
        first, second = record("one-corner", 1, 0.2, 4.0), record("one-corner", 1, 0.1, 3.0)
        store.add(first)
        store.add(second)
        again = Store(tmp_path / "deep" / "results.jsonl")
        assert again.get(first.case) == second
        assert again.machine == "abacus"

    def test_a_line_that_was_cut_off_is_forgotten(self, tmp_path: Path) -> None:
        path = tmp_path / "results.jsonl"
        kept, lost = record("one-corner", 1, 0.2, 4.0), record("one-corner", 2, 0.1, 8.0)
        Store(path).add(kept)
        Store(path).add(lost)
        path.write_text(path.read_text()[:-40])
        store = Store(path)
        assert store.get(kept.case) == kept
        assert store.get(lost.case) is None
        store.add(lost)
        assert Store(path).get(lost.case) == lost

    def test_a_shorter_timing_scales_the_whole_run(self, tmp_path: Path) -> None:
        store = Store(tmp_path / "results.jsonl")
        case = record("one-corner", 1, 0.1, 0.0).case
        whole = [90.0] * WARM_UP + [10.0] * 5 + [30.0] * 5
        store.add(Record(case, whole, True, 60.0, 0.5, Measured(0.1, 1.0, 0.1, 2.0, 0.0)))
        store.add(Record(case, [70.0] * WARM_UP + [5.0] * 3, False, 1.0))
        timed = Store(tmp_path / "results.jsonl").get(case)
        assert timed is not None
        assert timed.cost == pytest.approx(20.0 / 2)
        assert timed.measured == Measured(0.1, 1.0, 0.1, 2.0, 0.0)
        untimed = store.run_of(case)
        assert untimed is not None
        assert untimed.cost == pytest.approx(20.0)

    def test_winners_come_from_the_records(self, tmp_path: Path) -> None:
        store = Store(tmp_path / "results.jsonl")
        reference = Reference({scene: 2.0 for scene in SCENES})
        for effort, worst in ((1, 0.08), (2, 0.04), (4, 0.02)):
            for scene in SCENES:
                store.add(record(scene, effort, worst, cost=float(effort)))
        store.add(record("one-corner", 8, 0.001, cost=8.0))  # not tried in the other scene
        winners = winners_of(trials_of(store, TAUT, 32, reference), LIMITS)
        assert {limit: trial.settings["effort"] for limit, trial in winners.items()} == {0.10: 1, 0.05: 2}
        assert reference_of(store) is None


class Falling:
    """A cloth in free fall, as an adapter makes it; it can blow up."""

    def __init__(self, job: Job) -> None:
        self._job, self._frames = job, 0

    def frame(self) -> None:
        self._frames += 1

    def positions(self) -> NDArray[Any]:
        drop = 9.81 / 2 * (self._frames / FPS) ** 2
        lost = self._job.settings.get("lost_after", 1000)
        return self._job.positions - [0, 0, drop if self._frames < lost else np.inf]


def serve_job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, **fields: Any) -> tuple[int, dict[str, Any]]:
    sheet = Sheet("one-corner", 4)
    files = {name: str(tmp_path / name) for name in ("environment", "output", "report")}
    job = {"settings": {}, "frames": 20, "seconds": 60.0, "foresee": True} | sheet.as_job() | files | fields
    (tmp_path / "job.json").write_text(json.dumps(job))
    monkeypatch.setattr("sys.argv", ["adapter", str(tmp_path / "job.json")])
    serve(Falling)
    size = 8 if "bodies" in fields else 4
    return (tmp_path / "output").stat().st_size // (3 * 16 * size), json.loads(
        (tmp_path / "report").read_text()
    )


class TestAdapters:
    def test_writes_frames_and_their_times(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        frames, report = serve_job(tmp_path, monkeypatch)
        assert frames == len(report["cpu_ms"]) == 20

    def test_gives_up_what_will_not_end_in_time(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        frames, _ = serve_job(tmp_path, monkeypatch, seconds=-1.0)
        assert frames == 5

    def test_timing_again_makes_a_few_frames_more(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        frames, _ = serve_job(tmp_path, monkeypatch, seconds=-1.0, foresee=False)
        assert WARM_UP < frames == 10

    def test_makes_the_least_frames_that_were_asked_for(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        frames, _ = serve_job(tmp_path, monkeypatch, seconds=-1.0, foresee=False, least=15)
        assert frames == 15

    def test_positions_with_contact_are_written_in_double_precision(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        serve_job(tmp_path, monkeypatch, bodies=[], frames=1)
        [drop] = np.unique(-np.fromfile(tmp_path / "output", np.float64).reshape(16, 3)[:, 2])
        assert drop == 9.81 / 2 * (1 / FPS) ** 2

    def test_stops_when_the_cloth_blows_up(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        frames, _ = serve_job(tmp_path, monkeypatch, settings={"lost_after": 7})
        assert frames == 7


def test_the_command_line_reads_lists() -> None:
    asked = options(["--engines", "jolt,taut", "--sizes", "8,16", "--limits", "10,0.5"])
    assert (asked.engines, asked.sizes, asked.limits) == (["jolt", "taut"], [8, 16], [0.1, 0.005])
    assert set(options([]).engines) == {*ENGINES, *(contender.engine.name for contender in CONTENDERS)}
    assert (options([]).only, options(["--only", "contact"]).only) == (None, "contact")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--engines", "havok"], "must be of taut, jolt"),
        (["--limits", "-3"], "must be over 0"),
        (["--only", "speed"], "invalid choice"),
    ],
)
def test_the_command_line_refuses(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        options(arguments)
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_every_engine_has_an_adapter_and_settings(engine: Any) -> None:
    adapters = Path(__file__).parents[1] / "benches" / "peers" / "adapters"
    assert (adapters / engine.adapter).is_file()
    for size in (32, 64, 128):
        for family in engine.families(size, list(LIMITS)):
            assert 1 <= family.least <= family.most
