"""Keys in brackets, [Sun08], become links to the entries of the bibliography."""

import re

from docutils import nodes
from sphinx.application import Sphinx

BIBLIOGRAPHY = "bibliography"
"""Name of the document."""

_ENTRY = re.compile(r"\[([A-Z]\w+)\]")
_CITED = re.compile(r"(?<=[\[ ])[A-Z]\w+(?=[\],])")


def link(app: Sphinx, document: nodes.document, name: str) -> None:
    """Give the entries of the bibliography targets, and link to them from everywhere else."""
    entries = _entries(app)
    if name == BIBLIOGRAPHY:
        for strong in document.findall(nodes.strong):
            if match := _ENTRY.fullmatch(strong.astext()):
                strong["ids"].append(_target(match[1]))
        return
    base = app.builder.get_relative_uri(name, BIBLIOGRAPHY)
    for text in list(document.findall(nodes.Text)):
        inside = text.parent
        if isinstance(
            inside, nodes.literal | nodes.literal_block | nodes.math | nodes.math_block | nodes.reference
        ):
            continue
        if parts := _parts(text.astext(), entries, base):
            inside.replace(text, parts)


def _entries(app: Sphinx) -> set[str]:
    """Keys of the bibliography."""
    strong = app.env.get_doctree(BIBLIOGRAPHY).findall(nodes.strong)
    return {match[1] for one in strong if (match := _ENTRY.fullmatch(one.astext()))}


def _parts(text: str, entries: set[str], base: str) -> list[nodes.Node]:
    """The text, with links in it; nothing if it cites nothing."""
    parts: list[nodes.Node] = []
    end = 0
    for match in _CITED.finditer(text):
        if match[0] in entries and text.rfind("[", 0, match.start()) > text.rfind("]", 0, match.start()):
            parts.append(nodes.Text(text[end : match.start()]))
            parts.append(nodes.reference("", match[0], internal=True, refuri=f"{base}#{_target(match[0])}"))
            end = match.end()
    return [*parts, nodes.Text(text[end:])] if parts else []


def _target(key: str) -> str:
    return f"entry-{key.lower()}"


def add_to(app: Sphinx) -> None:
    """Let Sphinx do it when a page is written."""
    app.connect("doctree-resolved", link)
