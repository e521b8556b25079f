"""What a single pass of a filter does to the springs around those that it mends.

From states of a run, one step is taken twice: without a filter and with it. Both lead through the same forces
to the same proposal; so the difference is what the filter did.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.cache import Cache
from taut.scene import Scene
from taut.simulation import Simulation

APPLIES_TO = ("sequential", "sweeps", "provot", "tethers")
"""Filters beside which all springs act as they do without one, in the same steps."""

CLEARLY = 0.02
"""Over the limit means here: by more than this share of it [1]. `sweeps` ends within a tolerance."""

_MOMENTS = 24


@dataclass(frozen=True)
class Pass:
    """Stretch before and after the filter's pass, of every type 1 spring in states spread over a run."""

    before: NDArray[np.float64]
    """As the step is proposed [1], shape (values,)."""
    after: NDArray[np.float64]
    """As the filter leaves it [1], shape (values,)."""
    limit: NDArray[np.float64]
    """Strain limit [1], shape (values,)."""
    near: NDArray[np.bool_]
    """Whether a spring that is proposed within its limit meets one that is not, shape (values,)."""

    @property
    def over_before(self) -> float:
        """Share of springs that are proposed over their limit [1]."""
        return float((self.before > (1 + CLEARLY) * self.limit).mean())

    @property
    def over_after(self) -> float:
        """Share of springs that the filter leaves over their limit [1]."""
        return float((self.after > (1 + CLEARLY) * self.limit).mean())

    @property
    def pushed(self) -> NDArray[np.bool_]:
        """Whether the filter itself put a spring over its limit, shape (values,)."""
        return (self.before <= (1 + CLEARLY) * self.limit) & (self.after > (1 + CLEARLY) * self.limit)

    @property
    def pushed_neighbours(self) -> float | None:
        """Of the springs next to one over its limit, the share that the filter puts over theirs [1]."""
        return float(self.pushed[self.near].mean()) if self.near.any() else None


def one_pass(scene: Scene, cache: Cache, threads: int | None = None) -> Pass:
    """Take single steps from states of a run, without and with its filter.

    Args:
        scene: of the run; its filter is one of :data:`APPLIES_TO`.
        cache: the run.
        threads: worker threads [1]; all cores when left out.

    Raises:
        CacheError: the cache is damaged.
        SimulationError: a vertex became non-finite.
    """
    steps = int(cache.attributes["substeps"])
    forced = ["solver.filter=none", f"solver.substeps={steps}", "solver.force_step=true"]
    bare, filtered = Simulation(scene.with_settings(forced), threads), Simulation(scene, threads)
    chosen = cache.spring_kind < 2
    springs, limit = cache.springs[chosen], cache.strain_limit[chosen].astype(np.float64)
    parts = []
    for frame in np.unique(np.linspace(0, cache.frames - 1, _MOMENTS).round().astype(int)):
        ends = []
        for simulation in (bare, filtered):
            state = cache.positions(int(frame)), cache.velocities(int(frame))
            simulation.set_state(*state, int(frame) * steps)
            simulation.step()
            x = simulation.positions.astype(np.float64)[springs]
            ends.append(np.linalg.norm(x[:, 1] - x[:, 0], axis=1) / cache.rest_length[chosen] - 1)
        over = ends[0] > (1 + CLEARLY) * limit
        mended = np.zeros(cache.vertices, dtype=np.bool_)
        mended[springs[over]] = True
        parts.append((*ends, limit, mended[springs].any(axis=1) & ~over))
    before, after, limits, near = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Pass(before, after, limits, near)
