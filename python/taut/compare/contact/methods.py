"""What can be compared: the engine's own contact, and three methods of the literature."""

from collections.abc import Sequence
from dataclasses import dataclass

from taut.compare.contact.bridson import bridson
from taut.compare.contact.penalty import penalty
from taut.compare.contact.provot import provot
from taut.compare.contact.step import Outcome, Resolve, Step
from taut.compare.names import chosen

OURS = "ours"
"""Name of the engine's own contact."""


@dataclass(frozen=True, slots=True)
class Method:
    """A way to handle contact."""

    name: str
    """As the command line knows it."""
    resolve: Resolve | None
    """What it makes of a step; nothing for the engine's own."""


def without(step: Step) -> Outcome:
    """No contact at all: what there is to handle."""
    return Outcome(step.proposed)


_KNOWN = {
    method.name: method
    for method in (
        Method(OURS, None),
        Method("bridson", bridson),
        Method("provot", provot),
        Method("penalty", penalty),
        Method("none", without),
    )
}

NAMES = tuple(_KNOWN)
"""All methods, in the order of tables."""

USUAL = NAMES[:-1]
"""Those that `all` stands for: all but `none`."""


def choose(names: Sequence[str]) -> list[Method]:
    """Methods by name, in the order given, each once.

    Args:
        names: some of :data:`NAMES`, or `all`.

    Raises:
        CompareError: a name is unknown, or there is none.
    """
    return [_KNOWN[name] for name in chosen("methods", names, NAMES, USUAL)]
