"""From a scene and some methods to a folder."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from taut.compare.comparison import Comparison, run_all
from taut.compare.methods import Method
from taut.compare.report import is_ours, write_report
from taut.compare.running import Conditions
from taut.errors import CompareError
from taut.output import whole_folder
from taut.scene import Scene


@dataclass(frozen=True, slots=True)
class Options:
    """What a user may choose about a comparison."""

    conditions: Conditions = field(default_factory=Conditions)
    """What is the same for all methods."""
    budget: float | None = 60.0
    """Time for each search of settings that reach the limit [s]; nothing for no search."""
    film: bool = True
    """Whether to make the film."""
    overwrite: bool = False
    """Replace an earlier comparison."""


def compare(
    scene: Scene, methods: Sequence[Method], out: str | Path, options: Options | None = None
) -> Comparison:
    """Run a scene with each method and write what was found to a folder, which appears whole or not at all.

    A :class:`KeyboardInterrupt` while methods run ends the runs; the report is then written of those that are
    whole. At any other time nothing is left behind.

    Args:
        scene: what is simulated.
        methods: what is compared, see :func:`taut.compare.choose`.
        out: the folder to make.
        options: how.

    Raises:
        CompareError: no method simulates the scene, or a number is out of range.
        OutputError: `out` exists or cannot be written.
        CacheWriteError: the disk is full, say.
    """
    options = options or Options()
    if options.budget is not None and not 0 < options.budget < float("inf"):
        raise CompareError(f"budget = {options.budget}: must be above 0 seconds")
    with whole_folder(Path(out), options.overwrite, is_ours) as folder:
        found = run_all(scene, methods, folder, options.conditions, options.budget)
        write_report(found, folder, options.film, options.conditions.watch)
    return found
