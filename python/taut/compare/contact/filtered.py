"""A simulation whose steps are made admissible by a method in NumPy, instead of by the engine.

The engine takes each step of the same scene without contact, with its forces, its integrator and the strain
limit ``sweeps``. That one may start beyond the limit, as it has to after contact. The method changes where
that step ends, and velocities take the difference over the step. So the strain limit comes before contact,
as in [Bridson02], and what contact changes is not limited again before the next step.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from taut.bodies import BodyRange
from taut.compare.contact.distance import Numbers
from taut.compare.contact.step import Outcome, Resolve, Step
from taut.compare.contact.surfaces import faces_of, points_of
from taut.compare.contact.world import World
from taut.errors import CompareError
from taut.report import Report
from taut.scene import Scene
from taut.simulation import Hook, Simulation

LIMIT = "sweeps"
"""The strain limit of these steps, a value of `solver.filter`."""

_FAR = 1e4  # from where cloth may be [m]: where the cloth is that bodies are moved with


class Filtered(Simulation):
    """Steps of the engine without contact, each followed by a method."""

    def __init__(self, scene: Scene, resolve: Resolve, threads: int | None = None) -> None:
        """Put a scene in its initial state.

        Args:
            scene: with its bodies and contact.
            resolve: the method.
            threads: worker threads [1]; all cores when left out.

        Raises:
            CompareError: a cloth has points without triangles.
            SceneError: the scene cannot be simulated.
        """
        self.guide = Simulation(_bodies_alone(scene), 1)
        """Moves the bodies."""
        alone = ["body=[]", "contact.self=false", f"solver.filter={LIMIT}"]
        super().__init__(scene.with_settings(alone), threads)
        self._resolve = resolve
        self.world = world_of(self, scene, self.guide)
        """What touches."""
        self.places: Numbers = np.concatenate([self.exact_positions, surface_points(self.guide)])
        """Where all vertices of cloths and of the triangles of bodies are [m]: in double precision, in which
        gaps are not lost that single precision does not tell from nothing."""
        self.proposed: Numbers = self.places
        """Where they would have gone in the last step without contact [m]."""
        self.outcomes: list[Outcome] = []
        """What the method made of each step of the last call of :meth:`step`."""
        documents = scene.document["cloth"]
        self._stiffness = max(float(cloth["stiffness"] or np.inf) for cloth in documents)

    def step(self, n: int = 1, dt: float | None = None, hook: Hook | None = None) -> Report:
        """Advance by `n` steps; see :meth:`taut.Simulation.step`."""
        self.outcomes = []
        for _ in range(n):
            self._one(self.step_length if dt is None else dt, hook)
        return self.report

    def _one(self, dt: float, hook: Hook | None) -> None:
        vertices = len(self.mass)
        before = self.exact_positions
        super().step(1, dt, hook)
        self.guide.step(1, dt)
        proposed = self.places.copy()
        proposed[:vertices] += self.exact_positions - before
        proposed[vertices:] = surface_points(self.guide)
        self.proposed = proposed
        outcome = self._resolve(Step(self.world, self.places, proposed, dt, self._stiffness))
        self.outcomes.append(outcome)
        self.places = outcome.end
        moved = (outcome.end - proposed)[:vertices]
        if not moved.any():
            return
        change = (moved / dt).astype(np.float32)
        past = self.past
        # The integrator's own velocities come first, see Simulation.past; what others keep is begun anew.
        kept = past is not None and vertices <= len(past) <= vertices + len(self.cloths)
        if past is not None and kept:
            past[:vertices] += change
        self.set_state(self.places[:vertices], self.velocities + change, self.steps, past if kept else None)

    # Bodies are those of the scene, for caches and pictures.

    @cached_property
    def body_ranges(self) -> list[BodyRange]:
        """See :attr:`taut.Simulation.body_ranges`."""
        return self.guide.body_ranges

    @cached_property
    def body_triangles(self) -> NDArray[np.int32]:
        """See :attr:`taut.Simulation.body_triangles`."""
        return self.guide.body_triangles

    @property
    def body_positions(self) -> NDArray[np.float64]:
        """See :attr:`taut.Simulation.body_positions`."""
        return self.guide.body_positions


def _bodies_alone(scene: Scene) -> Scene:
    """The bodies of a scene, with a small cloth far from them that is held: they follow their paths."""
    cloth = (
        f"cloth=[{{ grid = {{ size = [1.0, 1.0], cells = [1, 1], origin = [{_FAR}, {_FAR}, {_FAR}] }}, "
        'pins = [{ edge = "left" }, { edge = "right" }] }]'
    )
    return scene.with_settings([cloth, "contact.self=false", "solver={}"])


def surface_points(simulation: Simulation) -> Numbers:
    """Corners of the triangles of all bodies, where they are now [m], shape (n, 3)."""
    points = [points_of(body) for body in simulation.bodies.values()]
    return np.concatenate([np.zeros((0, 3)), *points])


def world_of(simulation: Simulation, scene: Scene, bodies: Simulation) -> World:
    """What touches in a scene.

    Args:
        simulation: its cloths.
        scene: its materials.
        bodies: its bodies.

    Raises:
        CompareError: a cloth has points without triangles.
    """
    vertices = len(simulation.mass)
    if len(np.unique(simulation.faces)) < vertices:
        raise CompareError(
            "the scene has points without triangles, as networks have: --contact compares methods for "
            "triangles; leave such cloths out"
        )
    faces: list[NDArray[np.int64]] = [simulation.faces.astype(np.int64)]
    half, friction = [], []
    for cloth, fields in zip(simulation.cloths, scene.document["cloth"], strict=True):
        half.append(np.full(cloth.vertices, 0.5 * float(fields["thickness"])))
        friction.append(np.full(cloth.vertices, float(fields["friction"])))
    first = vertices
    for body, fields in zip(bodies.bodies.values(), scene.document.get("body", ()), strict=True):
        count = len(points_of(body))
        faces.append(faces_of(body) + first)
        half.append(np.full(count, float(fields["thickness"])))
        friction.append(np.full(count, float(fields["friction"])))
        first += count
    light = np.zeros(first)
    light[:vertices] = np.where(simulation.pinned, 0.0, 1.0 / simulation.mass.astype(np.float64))
    return World(np.concatenate(faces), light, np.concatenate(half), np.concatenate(friction), vertices)
