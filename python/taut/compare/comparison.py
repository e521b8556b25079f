"""Every method on the same scene: run, searched, measured."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from taut.cache import Cache
from taut.compare.measure import Body, Figures, measure
from taut.compare.methods import Method, dial_of
from taut.compare.neighbours import APPLIES_TO, Pass, one_pass
from taut.compare.running import Conditions, Search, Searcher, simulate
from taut.errors import CompareError, SceneError
from taut.scene import Scene
from taut.simulation import Simulation

EQUAL = 1.05
"""Two methods keep the same stretch if the worst of both is at most so many times the strain limit [1]."""

CACHES = "caches"
"""Folder of the runs."""


@dataclass(frozen=True, slots=True)
class Run:
    """A method with certain settings, measured."""

    method: Method
    settings: Literal["usual", "equal"]
    """Those of its author, or those that reach the same worst stretch."""
    label: str
    """Short name, for plots and rows, which says how far the dial was turned."""
    cache: str
    """The recorded run, from the folder of the comparison."""
    figures: Figures
    ended: str | None
    """Why it ended before its time; nothing if it did not."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """A method that does not simulate this scene."""

    method: Method
    reason: str


@dataclass(slots=True)
class Comparison:
    """What was found."""

    title: str
    """Of the scene."""
    body: Body
    """What does not depend on the method."""
    vertices: int
    springs: int
    """Of type 1 [1]."""
    limit: float | None
    """Largest strain limit [1]; nothing where a spring has none."""
    threads: int
    """Worker threads [1]."""
    fps: float
    """Frames per second [1/s]."""
    searched: bool
    """Whether settings for equal stretch were asked for."""
    budget: float
    """Most time for each such search [s]."""
    labels: dict[Method, str]
    """Short name of each method."""
    runs: list[Run] = field(default_factory=list)
    searches: list[tuple[Method, Search]] = field(default_factory=list)
    refused: list[Refusal] = field(default_factory=list)
    passes: list[tuple[Run, Pass]] = field(default_factory=list)
    interrupted: bool = False
    """Whether it was stopped before all methods had their turn."""

    @property
    def target(self) -> float | None:
        """The worst stretch that counts as equal [1]."""
        return None if self.limit is None or not self.searched else EQUAL * self.limit

    def of(self, settings: Literal["usual", "equal"]) -> list[Run]:
        """The runs with these settings."""
        return [run for run in self.runs if run.settings == settings]


def run_all(
    scene: Scene, methods: Sequence[Method], folder: Path, conditions: Conditions, budget: float | None
) -> Comparison:
    """Run every method; at a :class:`KeyboardInterrupt` stop and keep what is whole.

    Args:
        scene: what is simulated.
        methods: what is compared.
        folder: gets a folder `caches`.
        conditions: what is the same for all.
        budget: time for each search of settings that reach the limit [s]; nothing for no search.

    Raises:
        CompareError: no method simulates the scene, or there is no spring in it.
        CacheWriteError: the disk is full, say.
    """
    (folder / CACHES).mkdir()
    found: Comparison | None = None
    refused: list[Refusal] = []
    labels = _labels(methods)
    try:
        for method in methods:
            try:
                usual = method.usual(scene)
                start = Simulation(usual, conditions.threads)
            except SceneError as error:
                refused.append(Refusal(method, str(error)))
                continue
            found = found or _empty(start, budget, labels)
            named = usual.with_settings([f'title="{labels[method]}"'])
            _run_method(found, method, named, folder, conditions)
    except KeyboardInterrupt:
        if found is None or not found.runs:
            raise
        found.interrupted = True
    if found is None:
        reasons = "; ".join(f"{labels[refusal.method]}: {refusal.reason}" for refusal in refused)
        raise CompareError(f"none of these methods simulates the scene: {reasons}")
    found.refused = refused
    return found


def _labels(methods: Sequence[Method]) -> dict[Method, str]:
    """The filters, with their integrators where there are several."""
    several = len({method.integrator for method in methods}) > 1
    return {method: method.filter + (f", {method.integrator}" if several else "") for method in methods}


def _empty(start: Simulation, budget: float | None, labels: dict[Method, str]) -> Comparison:
    limits = start.strain_limit[start.spring_kind < 2]
    if not len(limits):
        raise CompareError("the scene has no springs that could stretch: there is nothing to compare")
    # A limit is stored in single precision; the decimal number that was asked for is meant.
    largest = float(str(limits.max(initial=0.0)))
    return Comparison(
        title=start.scene.title,
        body=Body.of(start),
        vertices=len(start.mass),
        springs=len(limits),
        limit=largest if 0 < largest < float("inf") else None,
        threads=start.threads,
        fps=start.scene.fps,
        searched=budget is not None,
        budget=budget or 0.0,
        labels=labels,
    )


def _run_method(
    found: Comparison, method: Method, scene: Scene, folder: Path, conditions: Conditions
) -> None:
    """The usual settings, one pass from their states, and the search for equal stretch."""
    name = f"{method.filter}-{method.integrator}"
    place = f"{CACHES}/{name}.zarr"
    ended = simulate(scene, folder / place, conditions)
    cache = Cache.open(folder / place)
    usual = Run(method, "usual", scene.title, place, measure(cache, found.body), ended)
    found.runs.append(usual)
    if method.filter in APPLIES_TO and usual.ended is None:
        found.passes.append((usual, one_pass(scene, cache, conditions.threads)))
    target = found.target
    if target is None or found.limit is None:
        return
    dial, out = dial_of(method, scene), folder / CACHES / f"{name}-equal.zarr"
    if usual.ended is None and usual.figures.worst_stretch <= target:
        found.searches.append((method, Search(dial, (), 1.0)))
        return
    steps = usual.figures.steps_per_frame
    searcher = Searcher(scene, steps, dial, target, found.limit, found.budget, conditions)
    search = searcher.search()
    if search.factor is not None:
        equal = scene.with_settings(search.settings)
        ended = simulate(equal, out, conditions)
        figures = measure(Cache.open(out), found.body)
        found.runs.append(Run(method, "equal", equal.title, f"{CACHES}/{out.name}", figures, ended))
    found.searches.append((method, search))
