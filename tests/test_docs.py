"""The site builds without a warning, shows its formulas without scripts, and fetches nothing."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from taut.cli.app import app
from taut.scene.fields import fields, tables

from tools.site.mathml import mathml

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as `make docs` does."""
    out = tmp_path_factory.mktemp("docs") / "site"
    done = subprocess.run([sys.executable, "-m", "tools.site", out], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr  # a warning is an error
    return out


def pages(site: Path) -> Iterator[tuple[Path, str]]:
    for path in sorted(site.rglob("*.html")):
        if "_static" not in path.parts:
            yield path, path.read_text(encoding="utf-8")


@pytest.mark.slow
def test_every_document_is_a_page(site: Path) -> None:
    documents = {path.relative_to(ROOT / "docs").with_suffix("") for path in (ROOT / "docs").rglob("*.md")}
    made = {path.relative_to(site).with_suffix("") for path, _ in pages(site)}
    assert documents <= made and len(documents) > 12


@pytest.mark.slow
def test_formulas_are_mathml(site: Path) -> None:
    formulas = 0
    for path, page in pages(site):
        text = re.sub(r"<(pre|code)\b.*?</\1>", "", page, flags=re.DOTALL)
        formulas += text.count("<math ")
        body = re.sub(r"<[^>]*>", " ", text)
        assert not re.findall(r"\\(?:frac|lvert|sum|tfrac|text)\b|\$\$|\$[A-Za-z\\]", body), path
    assert formulas > 300


@pytest.mark.slow
def test_nothing_is_fetched_and_nothing_is_missing(site: Path) -> None:
    for path, page in pages(site):
        sources = re.findall(r'(?:src|poster)="([^"]+)"|<link[^>]+href="([^"]+)"', page)
        for source in (first or second for first, second in sources):
            assert not re.match(r"(?:https?:)?//", source), (path, source)
            if not source.startswith("data:"):
                assert (path.parent / source.split("?")[0].split("#")[0]).exists(), (path, source)
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\(\s*['\"]?(?:https?:)?//|@import", sheet.read_text()), sheet


@pytest.mark.slow
def test_citations_lead_to_the_bibliography(site: Path) -> None:
    entries = set(re.findall(r'id="(entry-\w+)"', (site / "bibliography.html").read_text()))
    assert len(entries) > 20 and "entry-sun08" in entries
    cited = set()
    for path, page in pages(site):
        for target, fragment in re.findall(r'href="([^"#]*bibliography\.html)#(entry-\w+)"', page):
            assert (path.parent / target).exists() and fragment in entries, (path, fragment)
            cited.add(fragment)
    assert "[<" in (site / "equations.html").read_text() and len(cited) > 15


@pytest.mark.slow
def test_pages_that_are_made_hold_what_they_are_made_of(site: Path) -> None:
    commands = (site / "commands.html").read_text()
    assert all(f"taut {command.name}" in commands for command in app.registered_commands)
    scene = (site / "scene.html").read_text()
    for table in tables():
        assert f'id="{table.lower()}"' in scene
        assert all(f">{field.name}<" in scene for field in fields(table))
    reference = (site / "reference.html").read_text()
    for name in ("taut.Scene.load", "taut.Simulation.step", "taut.Cache.positions", "taut.record"):
        assert f'id="{name}"' in reference


@pytest.mark.slow
def test_the_notebook_was_run(site: Path) -> None:
    page = (site / "python.html").read_text()
    assert page.count("<img") >= 5
    assert re.search(r"a quarter of a second after the push: \d", page)


def test_the_notebook_is_kept_without_outputs() -> None:
    notebook = json.loads((ROOT / "docs" / "python.ipynb").read_text())
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) >= 7
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells)


def test_formulas() -> None:
    assert "<mfrac>" in mathml(r"\tfrac12 E", block=False)
    assert 'display="block"' in mathml("x", block=True)
    norm = mathml(r"\Bigl\lvert \lVert x\rVert_M \Bigr\rvert", block=True)
    assert norm.count('fence="true"') == 4
    assert mathml(r"2\cos wH", block=False).count("<mspace") == 2
    assert "<mspace" not in mathml(r"\sin^2(x)", block=False)
    assert mathml("a = -b - c", block=False).count('form="prefix"') == 1
    assert "<munder>" in mathml(r"\max_{uv} d", block=True)
    with pytest.raises(ValueError, match=r"\\nonsense cannot be turned into MathML"):
        mathml(r"\nonsense{x}", block=False)
