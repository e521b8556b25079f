"""Formulas as MathML, so that no script and no network is needed to read them."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

_BAR = re.compile(r"(?:\\(?:Bigg|bigg|Big|big)[lr]\s*)?\\(?P<side>[lr])(?P<kind>[vV])ert(?![A-Za-z])")
_LIMITS = re.compile(r"\\(max|min)_")
_TAG = re.compile(r"\\tag\{(\w+)\}")

_FUNCTION = r"<mi>(?:arc)?(?:sin|cos|tan)</mi>"
_THIN = '<mspace width="0.17em"/>'
_SPACING = (
    # A solidus is set as close as a letter.
    (re.compile(r"<mo>&#x0002F;</mo>"), '<mo lspace="0" rspace="0">&#x0002F;</mo>'),
    # After a relation, a comma or an opening bracket a minus is a sign.
    (re.compile(r"(<mo[^>]*>(?:=|&#x000(?:3D|3C|3E|28|5B|2C);|&#x0226[45];)</mo>)<mo>&#x02212;</mo>"),
     r'\1<mo form="prefix" lspace="0" rspace="0">&#x02212;</mo>'),
    # Names of functions keep away from what is around them, but for brackets.
    (re.compile(rf"(</(?:mi|mn|msub|msup|mfrac)>)({_FUNCTION})"), rf"\1{_THIN}\2"),
    (re.compile(rf"(?<!<msu[bp]>)({_FUNCTION})(?=<m(?:i|n|sub|sup|frac)>)"), rf"\1{_THIN}"),
)  # fmt: skip


def mathml(tex: str, block: bool) -> str:
    """Turn a formula into MathML.

    Raises:
        ValueError: it has a command that cannot be turned into MathML.
    """
    tex = _BAR.sub(_fence, tex)
    if block:
        tex = _LIMITS.sub(r"\\\1\\limits_", tex)
    formula = str(convert(tex, display="block" if block else "inline"))
    left = re.search(r"\\[A-Za-z]+", formula)
    if left:
        raise ValueError(f"{left[0]} cannot be turned into MathML, in the formula {tex}")
    for pattern, better in _SPACING:
        formula = pattern.sub(better, formula)
    return formula


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
