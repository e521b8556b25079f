"""A step that a method makes admissible: where all vertices are, and where they would go without contact."""

from dataclasses import dataclass
from typing import Protocol

from taut.compare.contact.distance import Numbers
from taut.compare.contact.world import World


@dataclass(frozen=True, slots=True)
class Step:
    """What a method is given. Vertices of cloths come first, then those of bodies."""

    world: World
    """What touches."""
    start: Numbers
    """Where all vertices are [m], shape (n, 3)."""
    proposed: Numbers
    """Where they would go without contact [m], shape (n, 3); bodies and what is held go there."""
    dt: float
    """Its length [s]."""
    stiffness: float
    """Of the cloth's structural springs [N/m]; infinite where curves stand for it."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a method made of a step."""

    end: Numbers
    """Where all vertices go [m], shape (n, 3)."""
    rounds: int = 0
    """How often collisions were looked for [1]."""
    rigid: int = 0
    """Vertices of cloth in rigid zones [1]."""
    clear: bool = True
    """Whether the method itself sees nothing that collides any more; one that does not look says so, too."""


class Resolve(Protocol):
    """A method: a filter of velocities, told as the ends of a step."""

    def __call__(self, step: Step, /) -> Outcome:
        """Make a step admissible, as well as the method can."""
        ...
