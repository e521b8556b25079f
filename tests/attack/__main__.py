"""`python -m tests.attack`: attacks taut until the time is up; an error if anything fails. `make attack`."""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from taut.bench import this_machine

from tests.attack.campaign import attack, table
from tests.attack.catalogue import names
from tests.attack.frame import from_json
from tests.attack.worker import Worker
from tools.documents import ROOT, rewrite

OUT = ROOT / "out" / "attack"
PAGE = ROOT / "docs" / "reliability.md"


def main() -> None:
    """Attacks, or tries a case again."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m tests.attack")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1, help="other cases for another one")
    parser.add_argument("--only", action="append", choices=names(), help="one attack, or several")
    parser.add_argument("--again", type=Path, metavar="CASE", help="a case.json below out/attack")
    parser.add_argument("--write", action="store_true", help="the table, into docs/reliability.md")
    given = parser.parse_args()
    if given.again:
        sys.exit(again(given.again))
    if given.write and given.only:
        parser.error("--write needs all attacks; leave out --only")
    shutil.rmtree(OUT, ignore_errors=True)
    tallies = attack(given.only or names(), given.seed, OUT, given.minutes)
    text = table(tallies)
    print(text, end="")
    if given.write:
        machine = this_machine()
        asked = f"`make attack MINUTES={given.minutes:g} SEED={given.seed} WRITE=1`"
        rewrite(PAGE, "attack", f"{asked}, {machine.cores} cores of {machine.processor}:\n\n{text}")
    failures = [
        f"{name}: {kind} ({times} x)"
        for name, tally in tallies.items()
        for kind, times in tally.failures.items()
    ]
    if failures:
        sys.exit("\n".join([*failures, f"reproductions: {OUT.relative_to(ROOT)}"]))


def again(path: Path) -> str | None:
    """What a case that was written fails with, or nothing."""
    path = path.resolve()
    name = path.parent.name.rpartition("-")[0]
    worker = Worker(name, path.with_suffix(".log"))
    outcome = worker.judge(case=from_json(path.read_text()))
    worker.stop()
    return outcome.failure or None


if __name__ == "__main__":
    main()
