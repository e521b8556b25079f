"""Benchmarks of whole scenes, against a yardstick timed in the same process; and scenes for judging."""

from taut.bench.history import HISTORY, History
from taut.bench.machine import Machine, this_machine
from taut.bench.measure import COLUMNS, Row, Runs, Timeable, Window, measure, measure_in_turn, runs_in_turn
from taut.bench.scenes import SCENES, Case, irregular_square, plan
from taut.bench.spread import Spread

__all__ = [
    "COLUMNS",
    "HISTORY",
    "SCENES",
    "Case",
    "History",
    "Machine",
    "Row",
    "Runs",
    "Spread",
    "Timeable",
    "Window",
    "irregular_square",
    "measure",
    "measure_in_turn",
    "plan",
    "runs_in_turn",
    "this_machine",
]
