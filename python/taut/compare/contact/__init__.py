"""Ways to handle contact side by side: ours and those of the literature, on the same scenes."""

from taut.compare.contact.comparing import Found, SceneFound, compare_contact
from taut.compare.contact.methods import Method, choose
from taut.compare.contact.report import FORMAT
from taut.compare.contact.running import Figures, Moment, Run
from taut.compare.contact.scenes import built_in

__all__ = [
    "FORMAT",
    "Figures",
    "Found",
    "Method",
    "Moment",
    "Run",
    "SceneFound",
    "built_in",
    "choose",
    "compare_contact",
]
