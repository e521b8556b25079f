"""`taut figures`: the page is whole, and what it measures agrees with theory and with plain NumPy."""

import json
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from taut.figures.drops import _turns
from taut.figures.pull import membrane_stiffness, pull_strip
from taut.figures.scenes import LIMIT, Size

Command = Callable[..., Any]
FIGURES = ["Fig. 2", "Fig. 4", "Fig. 5", "Fig. 6 and 7", "Fig. 8 and 9"]


class Links(HTMLParser):
    """Everything that a page refers to, and the texts that stand for its pictures."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.places: list[str] = []
        self.texts: list[str] = []
        self.open: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.places += [value for name in ("src", "href", "srcset") if (value := found.get(name))]
        if tag == "img":
            self.texts.append(found.get("alt") or "")
        if tag not in ("img", "meta", "source"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The quick page; not to be changed."""
    from taut.figures import Options, make_figures

    out = tmp_path_factory.mktemp("figures") / "out"
    make_figures(out, Options(quick=True, threads=1))
    return out


def test_the_page_is_whole_and_stands_alone(made: Path) -> None:
    page = (made / "index.html").read_text()
    links = Links(page)
    assert links.open == []
    inside = {place for place in links.places if not place.startswith("#")}
    assert inside == {"figures.json"} | {f"pictures/{path.name}" for path in (made / "pictures").iterdir()}
    assert not re.search(r"https?:|file:|url\(|@import|<script", page)
    assert len(links.texts) == 6 and all(len(text) > 20 for text in links.texts)
    anchors = [place[1:] for place in links.places if place.startswith("#")]
    assert anchors == re.findall(r'<section id="([^"]+)"', page) and len(anchors) == len(FIGURES)
    assert "prefers-color-scheme: dark" in page and 'name="viewport"' in page
    assert {path.name for path in made.iterdir()} == {"index.html", "figures.json", "pictures"}


def test_every_figure_has_its_pictures_claim_and_verdict(made: Path) -> None:
    page = (made / "index.html").read_text()
    numbers = json.loads((made / "figures.json").read_text())
    assert list(numbers) == FIGURES
    sections = page.split("<section")[1:]
    for name, section in zip(FIGURES, sections, strict=True):
        assert f"<small>{name}</small>" in section
        assert "The paper." in section and "<table>" in section
        verdict = {"holds": "holds.", "holds in part": "holds in part.", "does not hold": "does not hold."}
        assert f"The claim {verdict[numbers[name]['verdict']]}" in section
    for picture in (made / "pictures").iterdir():
        if picture.suffix == ".svg":
            assert "<svg" in picture.read_text()
        else:
            with Image.open(picture) as image:
                assert np.asarray(image.convert("L")).std() > 5


def test_the_numbers_are_those_of_the_text(made: Path) -> None:
    numbers = json.loads((made / "figures.json").read_text())
    page = (made / "index.html").read_text()
    flag, drop, rest = numbers["Fig. 5"], numbers["Fig. 6 and 7"], numbers["Fig. 8 and 9"]
    assert flag["worst_with"] <= 0.05 + 1e-5 < 0.5 < flag["worst_without"]
    assert f"<td>{100 * flag['worst_without']:.1f} %</td>" in page
    assert flag["over_with"] == 0 < flag["over_without"]
    assert drop["near_with"] <= 0.1 + 1e-5 < 0.5 < drop["near_without"]
    # Whoever is further than the taut diagonal from the pin is over-stretched.
    assert drop["reach_with_m"] <= 1.1 * np.sqrt(2) < drop["reach_without_m"]
    assert drop["fall_with_m"] < drop["fall_without_m"]
    assert max(rest["worst_1_with"], rest["worst_2_with"]) <= 0.1 + 1e-5
    assert min(rest["worst_1_without"], rest["worst_2_without"]) > 0.1


def test_membrane_stiffness_against_the_energy_of_a_cell() -> None:
    """A square cell: E along each side, two diagonals of E_sh/2, and the width of the least energy."""
    stiffness, shear, strain = 20.0, 10.0, 1e-4
    width = 1 + np.linspace(-1, 1, 20001) * strain
    length = 1 + strain
    diagonal = np.hypot(length, width) - np.sqrt(2)
    energy = 0.5 * stiffness * (strain**2 + (width - 1) ** 2) + 2 * 0.5 * (shear / 2) * diagonal**2
    assert 2 * energy.min() / strain**2 == pytest.approx(membrane_stiffness(), rel=1e-3)


def test_a_pulled_strip_is_linear_and_stops_at_the_limit() -> None:
    """Fig. 2: Hooke's law without the constraint; with it a knee below the limit, and no spring over it."""
    size = Size(strip=(20, 4), loads=4)
    bare, limited = pull_strip(size, "none"), pull_strip(size, "coarse_to_fine")
    theory = np.array(bare.pull) / membrane_stiffness()
    np.testing.assert_allclose(bare.stretch, theory, rtol=0.05)
    below = theory < 0.07
    np.testing.assert_allclose(np.array(limited.stretch)[below], np.array(bare.stretch)[below], rtol=0.02)
    assert below.sum() == 1
    beyond = np.array(limited.stretch)[~below]
    assert 0.08 < beyond.min() <= beyond.max() <= LIMIT
    assert np.ptp(beyond) < 0.005 < 0.1 < np.ptp(np.array(bare.stretch)[~below])
    assert max(limited.worst) <= LIMIT + 1e-5 < max(bare.worst)


def test_turns_of_a_height() -> None:
    """A cosine turns twice a period; tremors below a centimetre do not count."""
    time = np.linspace(0, 5, 1001)
    assert _turns(np.cos(2 * np.pi * time)) == 9
    assert _turns(time + 0.004 * np.sin(300 * time)) == 0
    assert _turns(np.full(10, 3.0)) == 0
    assert _turns(np.exp(-time) * np.cos(2 * np.pi * time)) == 9


def test_what_is_there_stays(taut: Command, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("precious")
    for more in ([], ["--overwrite"]):
        done = taut("figures", "--out", tmp_path / "out", "--quick", *more)
        assert done.status == 2
        assert "out exists already" in done.err or "holds 'thesis.txt'" in done.err
    assert (tmp_path / "out" / "thesis.txt").read_text() == "precious"


def test_ctrl_c_leaves_nothing(tmp_path: Path) -> None:
    from taut.figures import Options, make_figures

    def stop(what: str, done: int, total: int, note: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_figures(tmp_path / "out", Options(quick=True, watch=stop))
    assert list(tmp_path.iterdir()) == []
