"""`make peers`: other engines on the same scenes as taut, each at its cheapest setting that keeps the limit.

There are two parts: sheets that hang and touch nothing ("free"), and sheets that fall on bodies and on
themselves ("contact", see ``contact/``). Results go to ``out/peers/results.jsonl`` and
``out/peers/contact.jsonl``, environments to ``out/peers/env``; a command that was interrupted goes on where
it was. The tables in docs/peers.md and the plot docs/pictures/peers.png are made from them.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import report
import runner
from contact.contenders import CONTENDERS
from contact.contenders import SIZES as CONTACT_SIZES
from contact.session import ContactSession
from engines import ENGINES, REFERENCE, TAUT, Engine
from environments import UnavailableError, prepare
from judge import REFERENCE_SIZE, Reference, reference_of, trials_of, winners_of
from listed import Listed
from search import Run, Settings, Trial, attempt, search
from sheet import SCENES
from store import Case, Record, Store

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("free", "contact")
NAMES = list(dict.fromkeys([*ENGINES, *(contender.engine.name for contender in CONTENDERS)]))
"""Engines of either part."""
SIZES = (32, 64, 128)
"""Particles along an edge of sheets that touch nothing."""
LIMITS = (0.1, 0.05, 0.01)
"""Limits of the table [1]."""
HOPELESS = 2.0
"""A setting that exceeds the loosest limit this many times in one scene is not tried in the other."""
REFERENCE_SECONDS = 600.0
"""CPU time allowed for a run of the reference [s]; it is run once."""
LEAST_SECONDS = 2.0
"""Budget left [s] that is worth starting a run for."""


class Session:
    """What the command was asked to do, and its results."""

    def __init__(self, options: argparse.Namespace) -> None:
        """Read the results so far."""
        self.engines = [ENGINES[name] for name in options.engines if name in ENGINES]
        self.sizes: list[int] = options.sizes or list(SIZES)
        self.limits: list[float] = options.limits
        self.budget: float = options.budget
        self._listed: Listed | None = options.listed
        self._out: Path = options.out
        self.store = Store(self._out / "results.jsonl")
        self._commands: dict[str, list[str] | None] = {}

    def command(self, engine: Engine) -> list[str] | None:
        """What runs an engine's adapter; None, and one sentence printed, if it cannot be installed here."""
        if engine.name not in self._commands:
            try:
                self._commands[engine.name] = prepare(engine, self.environment(engine))
            except UnavailableError as error:
                print(error, flush=True)
                self._commands[engine.name] = None
        return self._commands[engine.name]

    def environment(self, engine: Engine) -> Path:
        """The folder of an engine's environment."""
        return self._out.resolve() / "env" / engine.name

    def reference(self) -> Reference:
        """The reference's peak speeds, run if they are not known yet."""
        known = reference_of(self.store)
        if known is None:
            [family] = REFERENCE.families(REFERENCE_SIZE, [])
            for scene in SCENES:
                self._run(REFERENCE, family.at(family.least), scene, REFERENCE_SIZE, REFERENCE_SECONDS)
            known = reference_of(self.store)
        if known is None:
            sys.exit("The reference run failed: see the last lines of results.jsonl.")
        return known

    def _run(self, engine: Engine, settings: Settings, scene: str, size: int, seconds: float) -> Record:
        command = self.command(engine)
        assert command is not None
        case = Case(engine.name, engine.version, settings, scene, size)
        record = runner.run(command, case, self.environment(engine), seconds)
        self.store.add(record)
        print(report.line(record), flush=True)
        return record

    def search(self, engine: Engine, size: int, reference: Reference, again: bool = False) -> list[Trial]:
        """Search an engine's settings at a size; ``again`` does not trust earlier results."""
        left = self.budget

        def run(settings: Settings, scene: str) -> Run | None:
            nonlocal left
            record = self.store.run_of(Case(engine.name, engine.version, settings, scene, size))
            if record is None or again or (record.error is None and _worth_more(record, left)):
                if left < LEAST_SECONDS:
                    return None
                record = self._run(engine, settings, scene, size, left)
                left -= record.cpu_seconds
            return reference.judge(record)

        def attempt_all(settings: Settings) -> Trial | None:
            return attempt(settings, SCENES, HOPELESS * max(self.limits), run)

        families = engine.families(size, self.limits)
        if self._listed is not None:
            settings = self._listed.free(engine.title, size, families)
            return [trial for setting in settings if (trial := attempt_all(setting)) is not None]
        return search(families, self.limits, attempt_all)

    def retime(self, seconds: float, reference: Reference) -> None:
        """Time taut's runs and all winners again; the peers' together in about this long."""
        winners: list[tuple[Engine, Case]] = []
        for engine in self.engines:
            for size in self.sizes:
                if engine is TAUT:
                    self.search(engine, size, reference, again=True)
                    continue
                trials = trials_of(self.store, engine, size, reference)
                chosen = {str(winner.settings): winner for winner in winners_of(trials, self.limits).values()}
                for winner in chosen.values():
                    cases = [Case(engine.name, engine.version, winner.settings, s, size) for s in SCENES]
                    winners += [(engine, case) for case in cases]
        for engine, case in winners:
            command = self.command(engine)
            if command is not None:
                record = runner.retime(command, case, self.environment(engine), seconds / len(winners))
                self.store.add(record)
                print(report.line(record), flush=True)


def _worth_more(record: Record, seconds: float) -> bool:
    """Whether a run that was given up for lack of time has more of it now."""
    return not record.complete and seconds > 1.2 * record.seconds


def _list(kind: Callable[[str], float | int | str]) -> Callable[[str], list[float | int | str]]:
    return lambda text: [kind(part) for part in text.split(",")]


def options(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", choices=PARTS, help="one of the two parts")
    parser.add_argument("--engines", type=_list(_engine), default=NAMES, help=f"of {', '.join(NAMES)}")
    parser.add_argument(
        "--sizes",
        type=_list(int),
        help=f"particles along an edge; {_words(SIZES)}, with contact {_words(CONTACT_SIZES)}",
    )
    parser.add_argument("--limits", type=_list(_per_cent), default=list(LIMITS), help="in per cent, free")
    parser.add_argument(
        "--budget", type=float, default=300.0, help="CPU seconds for an engine and a size, free"
    )
    parser.add_argument(
        "--contact-seconds", type=float, default=10.0, help="CPU seconds of a run with contact"
    )
    parser.add_argument(
        "--retime", action="store_true", help="only time taut and the winners found so far again"
    )
    parser.add_argument(
        "--retime-seconds", type=float, default=200.0, help="how long that takes for the peers"
    )
    parser.add_argument(
        "--listed",
        type=lambda path: Listed(Path(path)),
        metavar="PAGE",
        help="do not search, but run the settings that a page like docs/peers.md lists",
    )
    parser.add_argument("--report", action="store_true", help="only write the table and the plot again")
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "peers", help="folder of results and environments"
    )
    return parser.parse_args(arguments)


def _words(sizes: Sequence[int]) -> str:
    return ", ".join(map(str, sizes))


def _engine(name: str) -> str:
    if name not in NAMES:
        raise argparse.ArgumentTypeError(f"{name!r} is no engine here; must be of {', '.join(NAMES)}")
    return name


def _per_cent(text: str) -> float:
    limit = float(text) / 100
    if not 0 < limit <= 1:
        raise argparse.ArgumentTypeError(f"a limit of {text} %: must be over 0 and at most 100 %")
    return limit


def _free(asked: argparse.Namespace) -> None:
    """Search or time again what touches nothing, then write its table and the plot."""
    session = Session(asked)
    reference = session.reference()
    if asked.retime:
        session.retime(asked.retime_seconds, reference)
    elif not asked.report:
        for engine in session.engines:
            for size in session.sizes:
                if session.command(engine) is not None:
                    session.search(engine, size, reference)
    report.write(session.store, reference, sorted({*LIMITS, *session.limits}, reverse=True), ROOT / "docs")


def _contact(asked: argparse.Namespace) -> None:
    """The same with contact, without a plot."""
    session = ContactSession(asked.engines, asked.sizes, asked.contact_seconds, asked.out, asked.listed)
    if asked.retime:
        session.retime(asked.retime_seconds)
    elif not asked.report:
        session.search()
    session.write(ROOT / "docs")


def main() -> None:
    """Do what the command line asks for."""
    asked = options()
    if asked.only != "contact":
        _free(asked)
    if asked.only != "free":
        _contact(asked)


if __name__ == "__main__":
    main()
