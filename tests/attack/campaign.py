"""Attacks in turn until the time is up; a table, and a file for every failure."""

from __future__ import annotations

import math
import re
import time
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from tests.attack.catalogue import find
from tests.attack.frame import Case, as_json
from tests.attack.shrink import shrink
from tests.attack.worker import Worker

TURN = 5.0
"""How long an attack runs before the next one has its turn [s]."""
LIFE = 120.0
"""How long a process judges before another one takes its place [s]."""
SHRINKING = 60.0
"""How long a failure is made smaller [s]."""
WARM = 20
"""Cases after which a process has loaded what it needs."""


@dataclass(slots=True)
class Tally:
    """What an attack has done."""

    cases: int = 0
    refused: int = 0
    looked_at: int = 0
    failures: dict[str, int] = field(default_factory=dict)
    """How often each kind of failure was found."""
    peak: int = 0
    """The most memory of any process [bytes]."""
    lives: list[tuple[int, int, int]] = field(default_factory=list)
    """Of each process: cases, memory after the first of them and after the last [bytes]."""

    @property
    def growth(self) -> tuple[int, int]:
        """Memory of the process with most cases, early and at its end [bytes]."""
        return max(self.lives, default=(0, 0, 0))[1:]


class Campaign:
    """One attack under way."""

    def __init__(self, name: str, seed: int, out: Path) -> None:
        """Prepare; nothing runs yet.

        Args:
            name: of the attack.
            seed: the same cases for the same seed.
            out: where failures are written.
        """
        self._attack, self._seed, self._out = find(name), seed, out
        self.name, self.tally = self._attack.name, Tally()
        self._worker = Worker(name, out / f"{self.name}.log")
        self._judging = 0.0
        self._life: tuple[int, int] | None = None

    def turn(self, seconds: float, most: int | None = None) -> None:
        """Run for some time, one case at least, and no more cases than `most`."""
        end = time.monotonic() + seconds
        done = 0
        while done != most and (done == 0 or time.monotonic() < end):
            self._one()
            done += 1

    def stop(self) -> None:
        """End its process."""
        if self._life is not None:
            self.tally.lives.append((*self._life, self._worker.resident))
        self._life, self._judging = None, 0.0
        self._worker.stop()

    def _one(self) -> None:
        tally = self.tally
        seed = f"{self._seed}/{self.name}/{tally.cases}"
        began = time.monotonic()
        outcome = self._worker.judge(seed=seed)
        self._judging += time.monotonic() - began
        tally.cases += 1
        tally.refused += outcome.refused
        tally.looked_at += outcome.looked_at
        tally.peak = max(tally.peak, self._worker.peak)
        cases, early = self._life or (0, 0)
        self._life = cases + 1, early if cases >= WARM else self._worker.resident
        if outcome.failure:
            self._failed(seed, outcome.failure)
        if self._judging > LIFE:
            self.stop()

    def _failed(self, seed: str, failure: str) -> None:
        found = self.tally.failures
        kind = kind_of(failure)
        found[kind] = found.get(kind, 0) + 1
        if found[kind] > 1:
            return
        case = self._attack().generate(Random(seed))
        case = shrink(case, lambda smaller: self._still(smaller, kind), SHRINKING)
        self._write(len(found), case, seed, failure)

    def _still(self, case: Case, kind: str) -> bool:
        return kind_of(self._worker.judge(case=case).failure) == kind

    def _write(self, number: int, case: Case, seed: str, failure: str) -> None:
        folder = self._out / f"{self.name}-{number}"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "case.json").write_text(as_json(case))
        again = f"python -m tests.attack --again {folder / 'case.json'}"
        (folder / "failure.txt").write_text(f"{failure}\n\nseed {seed}\n{again}\n")
        for name, content in self._attack().files(case).items():
            (folder / name).write_bytes(content)


def kind_of(failure: str) -> str:
    """A failure without its numbers: the same mistake in another place."""
    return re.sub(r"\d[\d.e+-]*", "#", failure)[:160]


def attack(names: list[str], seed: int, out: Path, minutes: float | None = None) -> dict[str, Tally]:
    """Run attacks in turn.

    Args:
        names: which ones.
        seed: of all cases.
        out: where failures are written; the attack that found them begins their names.
        minutes: how long; nothing: the short run, a fixed number of cases each.
    """
    campaigns = [Campaign(name, seed, out) for name in names]
    try:
        if minutes is None:
            for name, campaign in zip(names, campaigns, strict=True):
                campaign.turn(math.inf, find(name).short)
        else:
            in_turn(campaigns, 60 * minutes)
    finally:
        for campaign in campaigns:
            campaign.stop()
    return {campaign.name: campaign.tally for campaign in campaigns}


def in_turn(campaigns: list[Campaign], seconds: float) -> None:
    """Run one after the other, again and again, until the time is up."""
    end = time.monotonic() + seconds
    turn = min(TURN, seconds / len(campaigns))
    while time.monotonic() < end:
        for campaign in campaigns:
            campaign.turn(min(turn, end - time.monotonic()))


def table(tallies: dict[str, Tally]) -> str:
    """What was done, as Markdown."""
    lines = [
        "| attack | tries to break | cases | refused | looked at | failures | peak | early, at the end |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, tally in tallies.items():
        attack = find(name)
        looked = f"{tally.looked_at:,} {attack.unit}" if attack.unit else ""
        early, late = (f"{size / 2**20:.0f}" for size in tally.growth)
        memory = f"{tally.peak / 2**20:.0f} MB | {early}, {late} MB"
        failures = sum(tally.failures.values())
        columns = (name, attack.promise, f"{tally.cases:,}", f"{tally.refused:,}", looked, failures, memory)
        lines.append("| " + " | ".join(map(str, columns)) + " |")
    return "\n".join(lines) + "\n"
