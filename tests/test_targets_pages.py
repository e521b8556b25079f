"""The pages of the targets: a row that is measured again is renewed, all others stay as they are."""

import sys
from pathlib import Path

import pytest
from taut.bench import this_machine

from tools.targets import __main__ as targets
from tools.targets import pages
from tools.targets.pages import lines_of, section, sections_of, table, with_lines, with_sections
from tools.targets.table import Effort, Row

ORDER = ("a", "b-b", "c")
OLD = f"""# Targets

{pages.BEGIN}| target | reached | met | threads | spread | `make targets ROW=` |
|---|---|---|---|---|---|
| slow: ≤ 1 | 2 | **no** | 1 | – | `c` |
| quick | 1 (of `c`) | yes | 2 | 1.0 (0.9 – 1.1, 5 runs) ms | `a` |

taut 0.1.0 7fa5635 on 2 cores of AMD EPYC, Linux x86_64.
{pages.END}

What follows.
"""
OLD_MACHINE = "0.1.0 7fa5635 on 2 cores of AMD EPYC, Linux x86_64"


def cells(line: str) -> list[str]:
    return line.strip("| ").split(" | ")


def new(name: str, measured_with: str = "0.2.0 abc on 8 cores") -> dict[str, str]:
    return {name: pages.line(name, Row("t", "r", True), measured_with)}


def test_a_table_that_names_one_engine_below_is_read() -> None:
    found = lines_of(OLD)
    assert list(found) == ["c", "a"]
    assert cells(found["c"]) == ["slow: ≤ 1", "2", "**no**", "1", "–", OLD_MACHINE, "`c`"]
    assert cells(found["a"])[4:] == ["1.0 (0.9 – 1.1, 5 runs) ms", OLD_MACHINE, "`a`"]


def test_a_row_is_renewed_and_the_others_stay() -> None:
    page = with_lines(OLD, new("b-b"), ORDER)
    assert lines_of(page) == {"a": lines_of(OLD)["a"], **new("b-b"), "c": lines_of(OLD)["c"]}
    assert list(lines_of(page)) == list(ORDER)
    assert page.startswith("# Targets\n") and page.endswith("\n\nWhat follows.\n")
    assert page.count("7fa5635") == 2 and page.count("0.2.0 abc on 8 cores") == 1
    again = with_lines(page, new("a", "0.3.0"), ORDER)
    assert lines_of(again) == {**lines_of(page), **new("a", "0.3.0")}
    assert with_lines(again, {}, ORDER) == again


def test_rows_that_never_were_measured_are_named_and_rows_that_are_gone_leave() -> None:
    page = with_lines(OLD, {}, ("b-b", "a", "d"))
    assert list(lines_of(page)) == ["a"]
    assert "\n\nNot measured yet: `b-b`, `d`.\n" + pages.END in page
    assert "Not measured" not in with_lines(page, {**new("b-b"), **new("d")}, ("b-b", "a", "d"))


def test_a_page_without_a_table_is_refused() -> None:
    with pytest.raises(ValueError, match="must stand between"):
        with_lines("# Targets\n", new("a"), ORDER)


def test_sections_are_renewed_by_name() -> None:
    full = {name: section(name, Row("t", "r", True, detail=f"| all of {name} |\n")) for name in ORDER}
    assert full["a"] == "## a\n\nt\n\n| all of a |\n"
    page = with_sections("# Any head\n", {"c": full["c"], "a": full["a"]}, ORDER)
    assert page == pages.HEAD + full["a"] + "\n" + full["c"]
    page = with_sections(page, {"b-b": full["b-b"]}, ORDER)
    assert sections_of(page) == full and list(sections_of(page)) == list(ORDER)
    page = with_sections(page, {"b-b": section("b-b", Row("t", "r", True))}, ORDER)
    assert list(sections_of(page)) == ["a", "c"]


def test_the_pages_are_as_they_would_be_written() -> None:
    page, detail = targets.TABLE.read_text(encoding="utf-8"), targets.DETAIL.read_text(encoding="utf-8")
    assert with_lines(page, {}, targets.ROWS) == page
    assert with_sections(detail, {}, targets.ROWS) == detail
    assert sections_of(detail).keys() <= lines_of(page).keys() <= targets.ROWS.keys()
    assert all(len(cells(line)) == len(pages.COLUMNS) for line in lines_of(page).values())


def measured(_: Effort) -> Row:
    return Row("to be quick", "quick", True, "2", "1.0 (0.9 – 1.1, 5 runs) ms", "| all |\n")


@pytest.mark.parametrize("met", [True, False])
def test_a_missed_target_is_an_error(
    met: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(targets, "ROWS", {"made-up": lambda _: Row("to be quick", "quick", met)})
    monkeypatch.setattr(sys, "argv", ["targets", "--only", "made-up"])
    if met:
        targets.main()
    else:
        with pytest.raises(SystemExit, match="not met: made-up"):
            targets.main()
    (line,) = lines_of(pages.BEGIN + capsys.readouterr().out + pages.END).values()
    assert cells(line)[:5] == ["to be quick", "quick", "yes" if met else "**no**", "1", "–"]


def test_one_row_is_written(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(targets, "TABLE", tmp_path / "targets.md")
    monkeypatch.setattr(targets, "DETAIL", tmp_path / "targets-detail.md")
    targets.TABLE.write_text(OLD, encoding="utf-8")
    targets.DETAIL.write_text("# Head\n", encoding="utf-8")
    monkeypatch.setattr(targets, "ROWS", dict.fromkeys(ORDER, measured))
    monkeypatch.setattr(sys, "argv", ["targets", "--only", "b-b", "--write"])
    targets.main()
    found = lines_of(targets.TABLE.read_text(encoding="utf-8"))
    assert (found["a"], found["c"]) == (lines_of(OLD)["a"], lines_of(OLD)["c"])
    assert cells(found["b-b"])[:5] == ["to be quick", "quick", "yes", "2", "1.0 (0.9 – 1.1, 5 runs) ms"]
    assert this_machine().processor in cells(found["b-b"])[5]
    assert sections_of(targets.DETAIL.read_text(encoding="utf-8")) == {
        "b-b": "## b-b\n\nto be quick\n\n| all |\n"
    }


@pytest.mark.parametrize("less", [["--quick"], ["--sizes", "65"], ["--case", "ball"], ["--runs", "1"]])
def test_less_than_a_whole_row_is_not_written(less: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["targets", "--only", "far", "--write", *less])
    with pytest.raises(SystemExit):
        targets.main()


def test_the_table_names_its_columns() -> None:
    assert cells(table(new("a")).splitlines()[0]) == list(pages.COLUMNS)
