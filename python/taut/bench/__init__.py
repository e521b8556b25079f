"""Benchmarks of whole scenes, against a yardstick timed in the same process."""

from taut.bench.history import HISTORY, History
from taut.bench.machine import Machine, this_machine
from taut.bench.measure import COLUMNS, Row, Window, measure, measure_in_turn
from taut.bench.scenes import SCENES, Case, irregular_square, plan

__all__ = [
    "COLUMNS",
    "HISTORY",
    "SCENES",
    "Case",
    "History",
    "Machine",
    "Row",
    "Window",
    "irregular_square",
    "measure",
    "measure_in_turn",
    "plan",
    "this_machine",
]
