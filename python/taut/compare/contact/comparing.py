"""Every method on every scene, into a folder."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from taut.compare.contact.methods import Method
from taut.compare.contact.running import Run, no_energy, run
from taut.compare.running import Conditions
from taut.errors import CompareError, SceneError
from taut.output import whole_folder
from taut.scene import Scene
from taut.simulation import Simulation

CACHES = "caches"
"""Folder of the runs."""

MOST_VERTICES = 5000
"""Vertices of cloth in a scene [1]: these methods are for study, and take seconds a frame with more."""


@dataclass(slots=True)
class SceneFound:
    """What was found of a scene."""

    name: str
    title: str
    vertices: int
    """Of all cloths [1]."""
    limit: float | None
    """Largest strain limit [1]; nothing where a spring has none."""
    no_energy: str | None
    """Why a gain of energy is not told; nothing where it is."""
    runs: list[Run] = field(default_factory=list)
    refused: list[tuple[str, str]] = field(default_factory=list)
    """Methods that do not simulate it, and why."""


@dataclass(slots=True)
class Found:
    """What was found of all scenes."""

    threads: int
    """Worker threads of the engine [1]."""
    scenes: list[SceneFound] = field(default_factory=list)
    interrupted: bool = False
    """Whether it was stopped before all methods had their turn."""


def compare_contact(
    scenes: Mapping[str, Scene],
    methods: Sequence[Method],
    out: str | Path,
    conditions: Conditions | None = None,
    film: bool = False,
    overwrite: bool = False,
) -> Found:
    """Run scenes with ways to handle contact, and write what was found to a folder.

    The folder appears whole or not at all. A :class:`KeyboardInterrupt` while methods run ends the runs; the
    report is then written of those that are whole.

    Args:
        scenes: what is simulated, by names of letters, digits, - and _; see
            :func:`taut.compare.contact.built_in`.
        methods: what is compared, see :func:`taut.compare.contact.choose`.
        out: the folder to make.
        conditions: what is the same for all methods.
        film: whether to make a film of each scene.
        overwrite: replace an earlier comparison.

    Raises:
        CompareError: no method simulates a scene, or a scene has too many vertices or no contact.
        OutputError: `out` exists or cannot be written.
        SceneError: a scene cannot be simulated.
        CacheWriteError: the disk is full, say.
    """
    from taut.compare.contact.report import is_ours, write_report

    conditions = conditions or Conditions()
    with whole_folder(Path(out), overwrite, is_ours) as folder:
        (folder / CACHES).mkdir()
        found = _run_all(scenes, methods, folder, conditions)
        write_report(found, folder, film, conditions.watch)
    return found


def _run_all(
    scenes: Mapping[str, Scene], methods: Sequence[Method], folder: Path, conditions: Conditions
) -> Found:
    found: Found | None = None
    try:
        for name, scene in scenes.items():
            start = Simulation(scene, conditions.threads)
            _check(start)
            found = found or Found(start.threads)
            here = _empty(name, scene, start)
            found.scenes.append(here)
            for method in methods:
                label, place = f"{name}, {method.name}", f"{CACHES}/{name}-{method.name}.zarr"
                titled = scene.with_settings([f'title="{method.name}"'])
                try:
                    here.runs.append(run(method, titled, label, folder, place, conditions))
                except (CompareError, SceneError) as error:
                    here.refused.append((method.name, str(error)))
            if not here.runs:
                reasons = "; ".join(f"{method}: {reason}" for method, reason in here.refused)
                raise CompareError(f"none of these methods simulates the scene {name}: {reasons}")
    except KeyboardInterrupt:
        if found is None or not any(here.runs for here in found.scenes):
            raise
        found.scenes = [here for here in found.scenes if here.runs]
        found.interrupted = True
    if found is None:
        raise CompareError("there is no scene to compare methods on")
    return found


def _check(start: Simulation) -> None:
    """Whether a scene is one for these methods."""
    vertices = len(start.mass)
    if vertices > MOST_VERTICES:
        raise CompareError(
            f"the scene has {vertices} vertices: --contact compares methods in NumPy, for at most "
            f"{MOST_VERTICES}; "
            "take fewer cells, as in --set cloth[0].grid.cells=[24,24]"
        )
    if not start.body_ranges and not start.scene.document.get("contact", {}).get("self"):
        raise CompareError(
            "nothing touches in this scene: add a body, or give a cloth its thickness, as in "
            "--set cloth[0].thickness=0.01"
        )


def _empty(name: str, scene: Scene, start: Simulation) -> SceneFound:
    limits = start.strain_limit[start.spring_kind < 2]
    largest = float(str(limits.max(initial=0.0)))
    limit = largest if 0 < largest < float("inf") else None
    return SceneFound(name, scene.title, len(start.mass), limit, no_energy(scene))
