"""Methods side by side on one scene: figures, plots, a strip and a film."""

from taut.compare.comparing import Options, compare
from taut.compare.comparison import EQUAL, Comparison, Refusal, Run
from taut.compare.measure import Body, Figures, measure
from taut.compare.methods import Method, choose, known
from taut.compare.report import FORMAT
from taut.compare.running import Conditions

__all__ = [
    "EQUAL",
    "FORMAT",
    "Body",
    "Comparison",
    "Conditions",
    "Figures",
    "Method",
    "Options",
    "Refusal",
    "Run",
    "choose",
    "compare",
    "known",
    "measure",
]
