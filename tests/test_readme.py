"""The README is short and true; documents name only commands, rows and files that exist."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer.main
import yaml
from taut import Scene, Simulation
from taut.cli.app import app

from tools.targets.__main__ import ROWS

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
AT_ROOT = sorted(ROOT.glob("*.md"))
DOCUMENTS = [*AT_ROOT, *sorted((ROOT / "docs").rglob("*.md"))]
COMMANDS = vars(typer.main.get_command(app))["commands"]


def blocks(path: Path, language: str) -> list[str]:
    """Code blocks of a document in a language; "" is for those without one."""
    text = path.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def code(path: Path) -> Iterator[str]:
    """Lines of blocks and what stands in backticks."""
    text = path.read_text(encoding="utf-8")
    for block in re.findall(r"^```[^\n]*\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield from block.splitlines()
    yield from re.findall(r"(?<!`)`([^`\n]+)`(?!`)", text)


def test_the_readme_is_short() -> None:
    assert len(README.read_text(encoding="utf-8").split()) <= 700  # as `wc -w` counts


def test_limits_come_before_commands() -> None:
    titles = re.findall(r"^## (.+)$", README.read_text(encoding="utf-8"), re.MULTILINE)
    assert titles[:3] == ["Limits", "Two commands", "Five minutes"]


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_commands_of_documents_exist(path: Path) -> None:
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    for line in code(path):
        if made := re.match(r"make ([a-z][\w-]*)", line):
            assert made[1] in targets, line
        for row in re.findall(r"\bROW=([a-z][\w-]*)", line):
            assert row in ROWS, line
        if called := re.match(r"(?:\.venv/bin/)?taut ([a-z]\w*)", line):
            assert called[1] in COMMANDS, line
            known = {
                option for one in COMMANDS[called[1]].params for option in [*one.opts, *one.secondary_opts]
            }
            given = re.findall(r"(?<=\s)--[a-z][\w-]*", line.split("#")[0])
            assert set(given) <= known | {"--help"}, line


@pytest.mark.parametrize("path", AT_ROOT, ids=lambda path: path.name)
def test_links_of_documents_at_the_root_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", path.read_text(encoding="utf-8")):
        assert target.startswith("https://") or (ROOT / target).exists(), target


@pytest.mark.parametrize("path", [README, ROOT / "docs" / "scene.md"], ids=lambda path: path.name)
def test_scenes_of_documents_are_simulated(path: Path) -> None:
    for block in blocks(path, "toml"):
        scene = Scene(tomllib.loads(block), folder=ROOT / "scenes" / "meshes")
        simulation = Simulation(scene)
        assert simulation.warnings == []
        assert simulation.run(frames=2).worst_stretch <= 0.05 + 1e-5


def test_python_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (block,) = blocks(README, "python")
    exec(block, {})
    last = capsys.readouterr().out.splitlines()[-1].split()
    assert float(last[0]) == pytest.approx(1.0) and float(last[1]) <= 0.05 + 1e-5


def row(name: str) -> str:
    """What a row of the table of targets has reached."""
    lines = (ROOT / "docs" / "targets.md").read_text(encoding="utf-8").splitlines()
    (line,) = (line for line in lines if line.endswith(f"| `{name}` |"))
    return line.split(" | ")[1]


@pytest.mark.parametrize("path", [README, ROOT / "docs" / "why.md"], ids=lambda path: path.name)
def test_figures_are_those_of_the_targets(path: Path) -> None:
    """After `make targets` the figures that are quoted may have to follow the table."""
    text = " ".join(path.read_text(encoding="utf-8").split())
    (flag,) = re.findall(r"flag \d+ \(([\d.]+) ms", row("two-threads"))
    assert f"a flag of {385 * 257:,} vertices in the wind takes {float(flag):.1f} ms a frame" in text
    (worst,) = re.findall(r"worst ([\d.]+) x", row("mesh"))
    assert f"up to {float(worst):.0f} times as much as grids" in text


def test_figures_are_those_of_the_peers() -> None:
    """After `make peers` likewise."""
    page = (ROOT / "docs" / "peers.md").read_text(encoding="utf-8")
    table = [
        line.strip("| ").split(" | ")
        for line in page.split("results: begin -->\n")[1].split("\n\n")[0].splitlines()
    ]
    head, ours, others = table[0], table[2], table[3:]
    assert ours[0] == "taut"
    compared = re.findall(
        r"^\| (\d+) x \d+(?: particles)?, (\d+ %) \| ([\d.]+) ms \| (none found|[\d.]+ ms \(\w+)",
        (ROOT / "docs" / "why.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    assert len(compared) == 5
    for size, limit, cost, best in compared:
        column = head.index(f"{size}², {limit}")
        found = {
            float(row[column].split()[0]): row[0].split()[0] for row in others if row[column][0].isdigit()
        }
        least = min(found, default=None)
        assert cost == ours[column], (size, limit)
        assert best == ("none found" if least is None else f"{least:g} ms ({found[least]}"), (size, limit)


def test_the_citation_is_of_this_version_and_of_the_paper() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    package = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]
    assert (citation["version"], citation["license"]) == (
        package["version"],
        package["license"].split(" OR "),
    )
    assert citation["repository-code"] == package["repository"]
    assert f"## {package['version']}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    (paper,) = citation["references"]
    assert f"DOI {paper['doi']}" in " ".join((ROOT / "docs" / "bibliography.md").read_text().split())


def test_the_oldest_compiler_is_the_one_that_is_checked() -> None:
    oldest = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["rust-version"]
    workflow = (ROOT / ".github" / "workflows" / "test.yml").read_text()
    assert f"cargo +{oldest} check" in workflow and f"rustup toolchain install {oldest} " in workflow
    assert f"compiler from {oldest} on" in (ROOT / "CONTRIBUTING.md").read_text()
