"""Settings of a page, run again without a search."""

from pathlib import Path

import pytest

from engines import ENGINES
from judge import Reference
from listed import Earlier, Listed
from metric import Measured
from report import BEGIN, END, write
from run import Session, options
from search import Settings
from sheet import SCENES
from store import Case, Record, Store

LIMITS = [0.10, 0.05, 0.01]

PAGE = """
| CPU ms a frame | 32², 10 % |
|---|---|
| Jolt (WebAssembly) | 2.3 |

| engine | size | limit | cheapest setting | worst stretch | motion |
|---|---|---|---|---|---|
| Jolt (WebAssembly) | 32² | 10 % | attachments 1, compliance 1e-05, iterations 40 | 8.85 % | 99 % |
| Jolt (WebAssembly) | 32² | 5 % | attachments 1, compliance 1e-05, iterations 40 | 4.94 % | 99 % |
| Jolt (WebAssembly) | 32² | 1 % | attachments 3, compliance 0, iterations 40 | 0.75 % | 99 % |
| Jolt (WebAssembly) | 64² | 10 % | attachments 0, compliance 0, iterations 320 | 0.75 % | 99 % |
| MuJoCo flex | 32² | 10 % | steps 1, young 1500000 | 7.51 % | 99 % |

| engine | scene | size | setting | CPU ms (spread) |
|---|---|---|---|---|
| Jolt (WebAssembly) | ball | 33² | iterations 128, compliance 0 | 7.1 |
"""


def test_settings_are_those_that_the_search_would_have_made(tmp_path: Path) -> None:
    (tmp_path / "page.md").write_text(PAGE, encoding="utf-8")
    listed, jolt = Listed(tmp_path / "page.md"), ENGINES["jolt"]
    families = jolt.families(32, LIMITS)
    expected: Settings = {"attachments": 1, "compliance": 1e-5, "iterations": 40}
    assert listed.free(jolt.title, 32, families) == [expected]  # once, and none of an unknown family
    assert listed.free("Jolt", 32, families) == []
    tried: list[Settings] = [{"iterations": n, "compliance": 0.0} for n in (64, 128)]
    assert listed.contact(jolt.title, "ball", 33, tried) == tried[1:]
    assert listed.contact(jolt.title, "heap", 33, tried) == []


def test_they_are_run_instead_of_a_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "page.md").write_text(PAGE, encoding="utf-8")
    arguments = ["--engines", "jolt", "--listed", str(tmp_path / "page.md"), "--out", str(tmp_path)]
    session = Session(options(arguments))

    def run(command: list[str], case: Case, environment: Path, seconds: float) -> Record:
        return Record(case, [1.0] * 10, True, seconds, measured=Measured(0.05, 1.0, 0.05, 2.0, 0.0))

    monkeypatch.setattr("runner.run", run)
    monkeypatch.setattr(session, "command", lambda engine: ["jolt"])
    trials = session.search(ENGINES["jolt"], 32, Reference({scene: 2.0 for scene in SCENES}))
    assert [trial.settings["iterations"] for trial in trials] == [40]
    assert trials[0].keeps(0.05)


def test_what_a_page_says_of_engines_without_results_is_kept(tmp_path: Path) -> None:
    earlier = Earlier(PAGE)
    assert earlier.words() == []
    assert earlier.cell("Jolt (WebAssembly)", "32², 10 %") == "2.3"
    assert earlier.cell("Jolt (WebAssembly)", "64², 10 %") is earlier.cell("MuJoCo flex", "32², 10 %") is None
    columns = ["engine", "scene", "size", "setting", "CPU ms (spread)"]
    assert [row["scene"] for row in earlier.details(columns, "Jolt (WebAssembly)")] == ["ball"]
    assert earlier.words() == ["Kept from an earlier run: Jolt (WebAssembly) (32²)."]


def test_a_partial_run_leaves_the_rest_of_the_page(tmp_path: Path) -> None:
    page = tmp_path / "peers.md"
    page.write_text(f"head\n{BEGIN}{PAGE}{END}\ntail\n", encoding="utf-8")
    (tmp_path / "pictures").mkdir()
    store = Store(tmp_path / "results.jsonl")
    for engine, cost in (("taut", 1.0), ("jolt", 8.0)):
        for scene in SCENES:
            case = Case(engine, ENGINES[engine].version, {"effort": 7}, scene, 64)
            measured = Measured(0.05, 1.0, 0.05, 2.2, 0.0)
            store.add(Record(case, [cost] * 10, True, 60.0, measured=measured, machine="abacus"))
    write(store, Reference({scene: 2.0 for scene in SCENES}), [0.1], tmp_path)
    text = page.read_text(encoding="utf-8")
    assert text.startswith("head\n") and text.endswith(f"{END}\ntail\n")
    assert "| Jolt (WebAssembly) | 2.3 | 8.0 (8.0 ×) |" in text
    assert "| Jolt (WebAssembly) | 64² | 10 % | effort 7 | 5.00 % | 110 % |" in text
    assert "Kept from an earlier run: Jolt (WebAssembly) (32²)." in text
    write(store, Reference({scene: 2.0 for scene in SCENES}), [0.1], tmp_path)
    assert page.read_text(encoding="utf-8") == text
