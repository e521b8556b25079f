"""The types with which the viewer's scripts are checked are those of the page and of what is sent to it."""

import re
from pathlib import Path
from typing import Any

import taut.view
from taut import Scene
from taut.view.controls import controls
from taut.view.picture import Panel

PAGE = Path(taut.view.__file__).parent / "page"
TYPES = (Path(__file__).resolve().parent.parent / "tools/page/types.d.ts").read_text()
TAGS = {
    "HTMLCanvasElement": {"canvas"},
    "HTMLSelectElement": {"select"},
    "HTMLInputElement": {"input"},
    "HTMLButtonElement": {"button"},
}


def members(interface: str) -> dict[str, str]:
    """Names and types of the members of an interface."""
    body = re.search(rf"^interface {interface} {{\n(.*?)^}}", TYPES, re.MULTILINE | re.DOTALL)
    assert body, interface
    found = re.findall(r'^  "?([\w-]+)"?: (.+);$', body[1], re.MULTILINE)
    return dict(found)


def test_elements_are_those_of_the_page() -> None:
    tags = {
        name: tag
        for tag, name in re.findall(r'<(\w+)[^>]*? id="([\w-]+)"', (PAGE / "index.html").read_text())
    }
    elements = members("Elements")
    for name, kind in elements.items():
        assert tags[name] in TAGS[kind] if kind in TAGS else kind == "HTMLElement", name
    script = (PAGE / "main.js").read_text()
    named = set(re.findall(r'\$\("([\w-]+)"\)', script))
    assert named <= elements.keys() and len(named) > 30


def test_panels_and_controls_have_the_fields_that_are_sent(flag: dict[str, Any]) -> None:
    nothing = dict.fromkeys(Panel.__dataclass_fields__, 0.0) | {"limits": [], "energies": []}
    assert members("Panel").keys() == Panel(**nothing).describe().keys()  # type: ignore[arg-type]
    one = next(iter(controls().values()))
    assert members("Control").keys() == one.describe(Scene(flag).document).keys()
