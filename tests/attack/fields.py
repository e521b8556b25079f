"""Every field of a scene with numbers of every size."""

from __future__ import annotations

from random import Random
from typing import ClassVar

from tests.attack.frame import Attack, Case, Outcome
from tests.attack.scenes import judge, mutant, mutants


class Fields(Attack):
    """One to three values of a small scene are replaced: it is simulated, or refused by their names."""

    name: ClassVar[str] = "scenes"
    promise: ClassVar[str] = "scenes with numbers of every size: simulated, or refused by name"
    unit: ClassVar[str] = "springs"
    seconds: ClassVar[float] = 120.0
    short: ClassVar[int] = 100

    def generate(self, random: Random) -> Case:
        made = next(mutants(random.getrandbits(31), 1))
        changes = [[list(path), value] for path, value in made.changes]
        return {"base": made.base, "changes": changes, "solver": made.document["solver"]}

    def judge(self, case: Case) -> Outcome:
        changes = {tuple(path): value for path, value in case["changes"]}
        return judge(mutant(case["base"], changes, case["solver"]))
