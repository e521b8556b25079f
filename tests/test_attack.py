"""A short, seeded run of every attack, and of what carries them."""

import os
import time
from pathlib import Path
from random import Random
from typing import Any

import pytest

from tests.attack import campaign
from tests.attack.catalogue import find, names
from tests.attack.frame import Attack, Case, Outcome, as_json, from_json
from tests.attack.shrink import shrink
from tests.attack.worker import Worker

SEED = 4


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_a_short_attack_finds_nothing(name: str, tmp_path: Path) -> None:
    (tally,) = campaign.attack([name], SEED, tmp_path).values()
    assert tally.cases == find(name).short
    assert not tally.failures, (tally.failures, [path.read_text() for path in tmp_path.rglob("failure.txt")])
    assert tally.refused < tally.cases or name in ("scenes", "meshes"), "all were refused: nothing was tried"


@pytest.mark.parametrize("name", names())
def test_cases_come_from_their_seed(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = find(name)()
    first, again = (repr(made.generate(Random("1/x/2"))) for _ in range(2))
    assert first == again != repr(made.generate(Random("1/x/3")))


class Weak(Attack):
    """An attack on what is known to be weak."""

    name = "weak"
    promise = "nothing"
    seconds = 2.0

    def generate(self, random: Random) -> Case:
        return {"numbers": [random.randint(0, 79) for _ in range(20)], "text": "x" * 50, "bytes": b"abc"}

    def judge(self, case: Case) -> Outcome:
        match max(case["numbers"]):
            case 99:
                os.abort()
            case 98:
                time.sleep(20)
            case 97:
                print("Traceback (most recent call last)", flush=True)
            case worst if worst > 70:
                return Outcome(f"{worst} is too much")
        return Outcome()


WEAK = "tests.test_attack:Weak"


def test_crashes_hangs_prints_and_wrong_answers_are_told(tmp_path: Path) -> None:
    worker = Worker(WEAK, tmp_path / "weak.log")
    told = [worker.judge(case={"numbers": [worst]}).failure for worst in (10, 75, 99, 97, 98, 10)]
    worker.stop()
    assert told[0] == told[5] == ""
    assert told[1] == "75 is too much"
    assert told[2].startswith("the process died with status -6")
    assert told[3] == "printed: Traceback (most recent call last)"
    assert told[4] == "took longer than 2 s"
    assert worker.peak >= worker.resident > 1e6


def test_a_failure_is_written_small_and_counted_once(tmp_path: Path) -> None:
    run = campaign.Campaign(WEAK, 1, tmp_path)
    run.turn(60.0, 6)
    run.stop()
    found = run.tally.failures
    assert list(found) == ["# is too much"] and found["# is too much"] > 1
    (folder,) = (path for path in tmp_path.iterdir() if path.is_dir())
    assert "is too much" in (folder / "failure.txt").read_text()
    (number,) = from_json((folder / "case.json").read_text())["numbers"]
    assert 70 < number < 80
    (line,) = (line for line in campaign.table({WEAK: run.tally}).splitlines() if "weak" in line.lower())
    assert f"| nothing | 6 | 0 |  | {found['# is too much']} |" in line


def test_cases_shrink_to_what_matters() -> None:
    case = {
        "list": list(range(40)),
        "text": "some words",
        "bytes": b"\x00\x01" * 20,
        "deep": {"x": [1.23456, None]},
    }
    assert from_json(as_json(case)) == case

    def fails(smaller: Any) -> bool:
        return 17 in smaller.get("list", ()) and b"\x01" in smaller.get("bytes", b"")

    assert shrink(case, fails, 20.0) == {"list": [17], "bytes": b"\x01"}
    assert shrink({"x": 1000.123}, lambda smaller: smaller.get("x", 0) > 10, 5.0) == {"x": 1000.0}
