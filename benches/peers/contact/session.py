"""The search for settings and the timing, engine by engine and scene by scene."""

import sys
from collections.abc import Sequence
from pathlib import Path

from contact import report, runner
from contact.choose import Verdict, best, judge
from contact.contenders import CONTENDERS, FINE, Contender
from contact.results import Outcome, Results
from contact.scenes import CONTACT_SCENES
from environments import UnavailableError, prepare
from listed import Listed
from search import Settings

REFERENCE_SECONDS = 1800.0
"""CPU time allowed for taut's finer run [s]; it is run once."""
REPEATS = 2
"""Times that each winner is timed again."""
TRIES = 10.0
"""CPU time for all settings of an engine in a scene, in times of one run's [1]."""


class ContactSession:
    """What was asked for, and its results."""

    def __init__(
        self,
        engines: Sequence[str],
        sizes: Sequence[int] | None,
        seconds: float,
        out: Path,
        listed: Listed | None = None,
    ) -> None:
        """Read the results so far.

        Args:
            engines: names of those to run.
            sizes: particles along an edge; None: the usual ones.
            seconds: CPU time of a run [s], if it is not over before.
            out: folder of results and environments.
            listed: the only settings to try; None: those of the contenders.
        """
        self.results = Results(out / "contact.jsonl")
        self._asked = [contender for contender in CONTENDERS if contender.engine.name in engines]
        self._sizes, self._seconds, self._listed = sizes, seconds, listed
        self._environments = out.resolve() / "env"
        self._commands: dict[str, list[str] | None] = {}

    def search(self) -> None:
        """Try settings from cheap to dear, until one breaks nothing or the time is used up."""
        for contender, scene, size in self._places(self._asked):
            reference = self._reference(scene, size)
            left = TRIES * self._seconds
            for settings in self._settings(contender, scene, size):
                if (
                    left <= 0
                    or (outcome := self._once(contender, settings, scene, size, self._seconds)) is None
                ):
                    break
                left -= sum(outcome.cpu_ms) / 1e3
                if not judge(outcome, reference).broken:
                    break

    def _settings(self, contender: Contender, scene: str, size: int) -> list[Settings]:
        """What is tried."""
        tried = contender.settings(size)
        return tried if self._listed is None else self._listed.contact(contender.title, scene, size, tried)

    def retime(self, seconds: float) -> None:
        """Time all winners again, in about this long [s] together; engines take turns.

        What would take more than its share even with the fewest frames is left with the time of its run.
        """
        winners = [
            (contender, verdict.outcome.case, sum(verdict.outcome.cpu_ms) / 1e3)
            for contender, scene, size in self._places(self._asked)
            if (verdict := self._chosen(contender, scene, size)) is not None
            and "failed" not in verdict.broken
        ]
        share = fair_share([whole for _, _, whole in winners], seconds / REPEATS)
        for _ in range(REPEATS):
            for contender, case, _ in winners:
                command = self._command(contender)
                if command is not None and runner.least_seconds(self.results.get(case)) <= share:
                    self._keep(runner.retime(command, case, self._folder(contender), share))

    def write(self, documents: Path) -> None:
        """Write what is known of all engines into the page."""
        chosen = {
            (contender.name, scene, size): verdict
            for contender, scene, size in self._places(CONTENDERS, known=True)
            if (verdict := self._chosen(contender, scene, size)) is not None
        }
        report.write(CONTENDERS, chosen, self.results, documents)

    def _places(
        self, contenders: Sequence[Contender], known: bool = False
    ) -> list[tuple[Contender, str, int]]:
        """Engines, scenes and sizes that were asked for, or that there are results of."""
        places = []
        for contender in contenders:
            sizes: Sequence[int] = self._sizes or contender.sizes
            if known:
                runs = self.results.of(contender.name, contender.engine.version)
                sizes = sorted({run.case.size for run in runs})
            places += [(contender, scene, size) for size in sizes for scene in CONTACT_SCENES]
        return places

    def _reference(self, scene: str, size: int) -> list[float]:
        """How far the centre of mass of taut's finer run fell, frame by frame [m]; run if it is not known.

        It does not age with the engine.
        """
        outcome = self.results.newest(FINE.name, scene, size)
        if outcome is None:
            outcome = self._once(FINE, FINE.settings(size)[0], scene, size, REFERENCE_SECONDS)
        if outcome is None or outcome.touch is None:
            sys.exit(f"The finer run of taut on {scene} at {size} failed: see contact.jsonl.")
        return outcome.touch.falls

    def _chosen(self, contender: Contender, scene: str, size: int) -> Verdict | None:
        """The winner among the settings that were tried."""
        cases = [contender.case(settings, scene, size) for settings in contender.settings(size)]
        outcomes = [outcome for case in cases if (outcome := self.results.get(case)) is not None]
        return best(judge(outcome, self._reference(scene, size)) for outcome in outcomes)

    def _folder(self, contender: Contender) -> Path:
        """Its environment: taut's finer run has none, like taut."""
        return self._environments / contender.engine.name

    def _command(self, contender: Contender) -> list[str] | None:
        """What runs an engine's adapter; None, and one sentence printed, if it cannot be installed here."""
        name = contender.engine.name
        if name not in self._commands:
            try:
                self._commands[name] = prepare(contender.engine, self._folder(contender))
                self.results.found(name)
            except UnavailableError as error:
                print(error, flush=True)
                self._commands[name] = None
                self.results.miss(name, str(error))
        return self._commands[name]

    def _once(
        self, contender: Contender, settings: Settings, scene: str, size: int, seconds: float
    ) -> Outcome | None:
        """A run, unless it is known; None if the engine cannot be installed."""
        case = contender.case(settings, scene, size)
        known = self.results.get(case)
        if known is not None:
            return known
        command = self._command(contender)
        if command is None:
            return None
        return self._keep(runner.run(command, case, self._folder(contender), seconds))

    def _keep(self, outcome: Outcome) -> Outcome:
        self.results.add(outcome)
        print(report.line(outcome), flush=True)
        return outcome


def fair_share(wanted: Sequence[float], seconds: float) -> float:
    """What each may take so that all together take so long, where some want less than that.

    Args:
        wanted: what each would take at most [s].
        seconds: for all together [s].

    Returns:
        The most that one may take [s].
    """
    left, share = seconds, seconds
    for index, least in enumerate(sorted(wanted)):
        share = left / (len(wanted) - index)
        if least >= share:
            break
        left -= least
    return share
