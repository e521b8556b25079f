"""How Sphinx builds the site. `python -m tools.site` calls it."""

import importlib.util
import re
import shutil
from pathlib import Path

from numpy.typing import ArrayLike
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation
from taut import __version__

from tools.site import citations, directives, mathml

ROOT = Path(__file__).resolve().parent.parent.parent
FILMS = ROOT / "out" / "gallery"
"""Where `make gallery` puts films; the site has those that are there."""

project = "taut"
release = __version__
copyright = "The taut developers"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]

html_theme = "furo"
html_title = "taut"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
smartquotes_action = "D"  # quotation marks stay: they are part of what is to be typed

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600

add_module_names = False
autodoc_class_signature = "separated"
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_default_options = {"members": True}
copybutton_exclude = ".linenos, .gp, .go"

_ARRAY_LIKE = stringify_annotation(ArrayLike, "smart")
_NDARRAY = re.compile(r"~numpy\.ndarray\[tuple\[~typing\.Any, \.\.\.\], ~numpy\.dtype\[([~\w.]+)\]\]")
_FILM = re.compile(r"<!-- film: (\S+) -->\n!\[(.*?)\]\((.*?)\)")


def show_films(app: Sphinx, name: str, source: list[str]) -> None:
    """Put a film in place of the picture below its name, if it was made."""

    def shown(match: re.Match[str]) -> str:
        film, text, picture = match.groups()
        if not (FILMS / f"{film}.mp4").exists():
            return f"![{text}]({picture})"
        attributes = (
            f'controls loop muted playsinline preload="none" poster="films/{film}.jpg" title="{text}"'
        )
        return f'<video {attributes} src="films/{film}.mp4"></video>'

    source[0] = _FILM.sub(shown, source[0])


def keep_colons(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Keep napoleon from taking what stands before a colon for a type: ours stand in the code."""
    if what in ("attribute", "property"):
        lines[:0] = ["..", ""]  # an empty comment


def name_arrays(
    app: Sphinx, what: str, name: str, obj: object, options: object, given: str | None, back: str | None
) -> tuple[str | None, str | None]:
    """Write the types of arrays in a signature, arguments and result, as the code has them."""

    def named(text: str | None) -> str | None:
        return text and _NDARRAY.sub(
            r"~numpy.typing.NDArray[\1]", text.replace(_ARRAY_LIKE, "~numpy.typing.ArrayLike")
        )

    return named(given), named(back)


def copy_files(app: Sphinx, error: Exception | None) -> None:
    """Add what the pages show besides text and pictures: the films, and the font of the formulas."""
    if error is not None:
        return
    ziamath = importlib.util.find_spec("ziamath")
    assert ziamath is not None and ziamath.origin is not None  # `make setup` installs it
    font = Path(ziamath.origin).parent / "fonts" / "STIXTwoMath-Regular.ttf"
    shutil.copy(font, app.outdir / "_static")
    for film in FILMS.glob("[!.]*.mp4"):
        (app.outdir / "films").mkdir(exist_ok=True)
        shutil.copy(film, app.outdir / "films")
        shutil.copy(ROOT / "docs" / "pictures" / "gallery" / f"{film.stem}.jpg", app.outdir / "films")


def setup(app: Sphinx) -> None:
    """Add what is ours."""
    mathml.add_to(app)
    directives.add_to(app)
    citations.add_to(app)
    app.connect("source-read", show_films)
    app.connect("autodoc-process-signature", name_arrays)
    app.connect("autodoc-process-docstring", keep_colons, priority=400)  # napoleon has 500
    app.connect("build-finished", copy_files)
