"""All attacks, by name."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from random import Random
from types import ModuleType
from typing import ClassVar

from tests.attack.frame import Attack, Case, Outcome

_PLACES = {
    "whole": "tests.attack.whole:Whole",
    "texts": "tests.attack.texts:Texts",
    "orders": "tests.attack.orders:Orders",
    "sockets": "tests.attack.sockets:Sockets",
    "snapshots": "tests.attack.snapshots:Snapshots",
    "caches": "tests.attack.caches:Caches",
    "resumes": "tests.attack.resumes:Resumes",
}
_MUTANTS = {
    "scenes": "every field of a scene with values of every size: simulated or refused",
    "meshes": "mutated mesh files: read or refused",
}
"""Modules with `mutants(seed, count)` and `judge(mutant)`, which returns what is wrong, or nothing."""


def names() -> list[str]:
    """In the order in which they take turns."""
    return [*_PLACES, *(name for name in _MUTANTS if find_spec(f"tests.attack.{name}") is not None)]


def find(name: str) -> type[Attack]:
    """The attack of this name, or at this place: `module:Class`."""
    if name in _MUTANTS:
        return _of_mutants(name, import_module(f"tests.attack.{name}"))
    module, _, kind = _PLACES.get(name, name).partition(":")
    found: type[Attack] = getattr(import_module(module), kind)
    return found


def _of_mutants(called: str, module: ModuleType) -> type[Attack]:
    class Mutants(Attack):
        name: ClassVar[str] = called
        promise: ClassVar[str] = _MUTANTS[called]
        short: ClassVar[int] = 60

        def generate(self, random: Random) -> Case:
            return next(iter(module.mutants(random.getrandbits(31), 1)))

        def judge(self, case: Case) -> Outcome:
            return Outcome(failure=str(module.judge(case) or ""))

    return Mutants
