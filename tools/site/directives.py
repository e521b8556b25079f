"""Parts of pages that are made of what the program itself says: its commands, the fields of a scene."""

from typing import ClassVar

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from tools.site import pages


class _Made(SphinxDirective):
    """Stands for Markdown that a function of `pages` writes."""

    make: ClassVar[str]
    has_content = False

    def run(self) -> list[nodes.Node]:
        text: str = getattr(pages, self.make)()
        return self.parse_text_to_nodes(text, allow_section_headings=True)


class Commands(_Made):
    """``{commands}``."""

    make = "commands"


class SceneFields(_Made):
    """``{scene-fields}``."""

    make = "scene_fields"


def add_to(app: Sphinx) -> None:
    """Let Sphinx know of them."""
    app.add_directive("commands", Commands)
    app.add_directive("scene-fields", SceneFields)
