"""Formulas as MathML, so that no script and no network is needed to read them."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

_BAR = re.compile(r"(?:\\(?:Bigg|bigg|Big|big)[lr]\s*)?\\(?P<side>[lr])(?P<kind>[vV])ert(?![A-Za-z])")
_TAG = re.compile(r"\\tag\{(\w+)\}")


def mathml(tex: str, block: bool) -> str:
    """Turn a formula into MathML.

    Raises:
        ValueError: it has a command that cannot be turned into MathML.
    """
    formula = convert(_BAR.sub(_fence, tex), display="block" if block else "inline")
    left = re.search(r"\\[A-Za-z]+", formula)
    if left:
        raise ValueError(f"{left[0]} cannot be turned into MathML, in the formula {tex}")
    return str(formula)


def _fence(match: re.Match[str]) -> str:
    """A bar that is set as a fence, close to what it encloses."""
    side = "left" if match["side"] == "l" else "right"
    bar = "|" if match["kind"] == "v" else "\\|"
    return f"\\{side}{bar} "


def _inline(translator: HTML5Translator, node: nodes.Element) -> None:
    translator.body.append(mathml(node.astext(), block=False))
    raise nodes.SkipNode


def _block(translator: HTML5Translator, node: nodes.Element) -> None:
    tex = node.astext()
    tag = _TAG.search(tex)
    number = f"<span>({tag[1]})</span>" if tag else ""
    formula = mathml(_TAG.sub("", tex), block=True)
    translator.body.append(f'<div class="formula">{formula}{number}</div>')
    raise nodes.SkipNode


def add_to(app: Sphinx) -> None:
    """Let Sphinx know of it as `html_math_renderer = "mathml"`."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
