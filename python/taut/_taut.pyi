"""The compiled engine. Arrays in, arrays out; every error is one of the exceptions below."""

from collections.abc import Callable
from typing import TypeAlias, TypedDict, final, type_check_only

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Engine",
    "SceneError",
    "SimulationError",
    "__version__",
    "break_next_step",
    "footprint",
    "resolve_scene",
    "scene_schema",
    "simd_lanes",
    "state_hash",
    "step_all",
]

__version__: str

class SceneError(ValueError):
    """A scene cannot be simulated. The text names the field, its value, what is allowed and a remedy."""

class SimulationError(RuntimeError):
    """A running simulation cannot go on; the state is the one before the failed call."""

@type_check_only
class Report(TypedDict):
    """What happened during a call of :meth:`Engine.step` (all its steps together)."""

    time: float
    """Time reached [s]."""
    steps: int
    """Steps taken by the call."""
    evaluations: int
    """How often the integrator looked at all springs; a pass of a linear solver counts as one."""
    worst_stretch: float
    """Largest |X_uv| / L - 1 over all springs at the end of the call."""
    worst_spring: int
    """Index of that spring (-1: there are no springs)."""
    worst_stretch_in_steps: float
    """Largest stretch after any step of the call."""
    worst_spring_in_steps: int
    """Index of that spring (-1: there are no springs)."""
    limited_steps: int
    """Steps in which the filter changed a velocity."""
    limited_springs: int
    """Springs found over their limit by the filter, summed over the steps."""
    sweeps: int
    """Passes over the springs (or cycles over all levels) of the filter, summed over the steps."""
    cuts: int
    """Times that the certificate had to shorten the step of a cloth to keep its limit."""
    held_back_pins: int
    """Times that pins of a cloth had to wait: it is not long enough between them, or could not follow."""
    pinched: int
    """Rows of contact that shared too little room, summed over the steps."""
    held_back_bodies: int
    """Bodies that ended behind their paths, summed over the steps."""
    lost_motion: float
    """Largest part of its motion that the certificate, or the bound on the kinetic energy, took from a cloth
    in a step."""
    mean_lost_motion: float
    """The same, mean of the steps."""
    contacts: int
    """Rows of contact (pairs that were near, or came near), summed over the steps."""
    contact_cuts: int
    """Steps that were shortened where something would have crossed something else."""
    halved_steps: int
    """Steps that contact had taken in halves, quarters or eighths."""
    closest: float
    """Least distance that the steps found between what touches [m]; infinite where nothing was near."""
    penetrations: int
    """Places where something intersected at the start of the last step, while that is brought apart."""
    asleep: bool
    """Whether everything slept in the last step, and nothing was done."""
    repaired_momentum: list[float]
    """What rounding took from the momentum of free cloths, and was given back, summed over the steps
    [kg m/s]."""
    detection_ms: float
    """Time that finding pairs took, summed over the steps [ms]."""
    solve_ms: float
    """Time that the filter took for the rest, summed over the steps [ms]."""
    certificate_ms: float
    """Time that contact's certificate took, summed over the steps [ms]."""
    kinetic_energy: float
    """At the end of the call [J]."""
    elastic_energy: float
    """Energy stored in the springs at the end of the call [J]."""
    potential_energy: float
    """In gravity, relative to the origin, at the end of the call [J]."""

_Mesh: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]
"""vertices [m, before scale], shape (vertices, 3); corners: all faces' vertex indices, face after face;
counts: corners of each face (3 or more)."""

def break_next_step() -> None:
    """For tests: the next step of any simulation panics, as a mistake in the engine would."""

def scene_schema() -> str:
    """The JSON schema of a scene; descriptions carry the units."""

def resolve_scene(document: str) -> tuple[str, list[str]]:
    """Check a scene given as JSON, fill in every default; return it as JSON, and the warnings.

    Raises:
        SceneError: a field is unknown, misspelt, of the wrong type or out of range.
    """

def footprint(scene: str, meshes: dict[str, _Mesh]) -> tuple[int, int, int, int]:
    """What a scene given as JSON needs, before anything of it is built.

    Returns:
        Vertices [1]; springs, about [1]; memory, about [bytes]; what a frame holds, not compressed [bytes].

    Raises:
        SceneError: as :func:`resolve_scene`.
    """

def simd_lanes() -> int:
    """Numbers of single precision in the vector registers used: 16 (AVX-512), 8 (AVX2), 4 (NEON) or 1.

    They are the widest of the processor, unless the environment variable ``TAUT_SIMD`` names others when the
    first engine is made: ``baseline``, ``neon``, ``avx2`` or ``avx512``. Results do not depend on it.

    Raises:
        SceneError: it names none that there are, or none that the processor has.
    """

def step_all(
    engines: list[Engine], count: int = 1, dt: float | None = None, threads: int | None = None
) -> list[Report]:
    """Have several engines take steps side by side: all of them, or none; see :meth:`Engine.step`.

    Raises:
        SimulationError: a vertex became non-finite; the world is named.
        ValueError: no such length is possible; the world is named.
    """

def state_hash(
    positions: NDArray[np.float32],
    velocities: NDArray[np.float32],
    past: NDArray[np.float32] | None = None,
    origins: NDArray[np.float64] | None = None,
) -> str:
    """XXH3 hash (16 hexadecimal digits) of local positions and velocities, shape (vertices, 3), and past.

    The past is what :meth:`Engine.past` gives, of shape (n, 3). Origins, of
    shape (cloths, 3), count unless all of them are zero, as they are when left out.
    """

@final
class Engine:
    """A model, its state and its workspace.

    Args:
        scene: a scene as JSON (resolved or not).
        meshes: for every ``mesh`` path that the scene names, its geometry.
        threads: worker threads; results do not depend on it. ``None``: all cores.
        paths: for every array that a pin or a body of the scene follows its places [m], shape (frames,
            vertices, 3), and its frames per second; ``None``: those of the scene.

    Raises:
        SceneError: the scene or a mesh cannot be simulated; or see :func:`simd_lanes`.
    """

    def __new__(
        cls,
        scene: str,
        meshes: dict[str, _Mesh],
        threads: int | None = None,
        paths: dict[str, tuple[NDArray[np.float64], float | None]] | None = None,
    ) -> Engine: ...
    @property
    def scene(self) -> str:
        """The resolved scene as JSON."""
    @property
    def warnings(self) -> list[str]:
        """What is suspicious in the scene and what was repaired in its meshes."""
    @property
    def threads(self) -> int: ...
    @property
    def vertex_count(self) -> int: ...
    @property
    def cloths(self) -> list[tuple[str, int, int]]:
        """Name, first vertex and vertex count of each cloth; vertices keep their order in the file."""
    @property
    def bodies(self) -> list[tuple[str, str, float, bool, int, int, int, int]]:
        """What each body is.

        Name, shape ("sphere", "capsule", "plane" or "surface"), radius [m], whether it ever moves, first
        vertex, vertex count, first triangle, triangle count.
        """
    @property
    def body_triangles(self) -> NDArray[np.int32]:
        """Triangles of all bodies, vertices counted over all bodies, shape (triangles, 3)."""
    def body_positions(self) -> NDArray[np.float64]:
        """Where the vertices of all bodies are now in the world [m], shape (body vertices, 3), a copy."""
    def pose_body(
        self,
        body: int,
        offset: tuple[float, float, float],
        rotation: tuple[float, float, float] | None,
        over: float,
    ) -> None:
        """Send a body off its path [m] and turn it about its middle, in a time [s]; at once if that is 0.

        The rotation is an axis times an angle [rad]; ``None``: it stays turned as it is.

        Raises:
            IndexError: there is no such body.
            ValueError: a number is not finite, or the time below 0.
        """
    def form_body(self, body: int, places: NDArray[np.float64], over: float) -> None:
        """Send the vertices of a body to places [m], shape (vertices of the body, 3), in a time [s].

        Raises:
            IndexError: there is no such body.
            ValueError: a wrong shape, a non-finite number, or a time below 0.
        """
    def translate(self, cloth: int, offset: tuple[float, float, float]) -> None:
        """Displace a cloth and what holds it [m]; nothing is thrown.

        Raises:
            IndexError: there is no such cloth.
            ValueError: a number is not finite.
        """
    def body_offset(self, body: int) -> tuple[float, float, float]:
        """How far a body is off its path now [m], the mean of its vertices.

        Raises:
            IndexError: there is no such body.
        """
    def contacts(
        self,
    ) -> tuple[
        NDArray[np.int32],
        NDArray[np.int32],
        NDArray[np.float64],
        NDArray[np.float64],
        NDArray[np.float64],
        NDArray[np.float64],
    ]:
        """Where cloth was pushed in the last step: a row for each place, none after a state was set.

        The nearest vertex of the cloth, the body (-1: cloth), where on the cloth in the world [m], the way in
        which the cloth is pushed, how hard [N] and the friction [N]: shapes (n,), (n,), (n, 3), (n, 3), (n,)
        and (n, 3).
        """
    def keep_trace(self, keep: bool) -> None:
        """Whether steps tell where their parts end, from now on."""
    def trace(self) -> list[NDArray[np.float64]] | None:
        """Where the parts of the steps of the last :meth:`step` ended [m], in their order, if kept.

        Each has shape (vertices + body vertices, 3): of all cloths, then of all bodies.
        """
    def intersections(
        self,
    ) -> tuple[int, list[tuple[str, str, str, str, int, list[float], float | None]]]:
        """How many places there are where cloth intersects something now, and the first of them.

        Of each the cloth, the other cloth or body, which of these it is ("cloth", "body"), how ("crosses",
        "inside"), the nearest vertex of all, where in the world [m], and how deep [m], where that is known.
        """
    @property
    def faces(self) -> NDArray[np.int32]:
        """Triangles, shape (triangles, 3)."""
    @property
    def springs(self) -> NDArray[np.int32]:
        """Vertex pairs, shape (springs, 2)."""
    @property
    def spring_kind(self) -> NDArray[np.uint8]:
        """0 structural, 1 shear (both type 1), 2 flexion (type 2); shape (springs,)."""
    @property
    def rest_length(self) -> NDArray[np.float32]:
        """[m], shape (springs,)."""
    @property
    def strain_limit(self) -> NDArray[np.float32]:
        """Lambda of each spring, infinite where there is none; shape (springs,)."""
    @property
    def mass(self) -> NDArray[np.float32]:
        """[kg], shape (vertices,)."""
    @property
    def pinned(self) -> NDArray[np.bool_]:
        """Shape (vertices,)."""
    @property
    def substeps(self) -> int:
        """Steps per frame."""
    @property
    def step_length(self) -> float:
        """Length of a step, h [s]."""
    @property
    def step_bound(self) -> float:
        """Largest stable step of springs, damping, drag and wind together [s]."""
    @property
    def steps(self) -> int:
        """Steps taken since the start."""
    @property
    def time(self) -> float:
        """Time since the start [s]."""
    def positions(self) -> NDArray[np.float32]:
        """A copy, [m], shape (vertices, 3); in the world."""
    @property
    def local_positions(self) -> NDArray[np.float32]:
        """A copy, [m], shape (vertices, 3); from the origin of each cloth."""
    @property
    def origins(self) -> NDArray[np.float64]:
        """Where the local positions of each cloth begin now [m], shape (cloths, 3), a copy."""
    def velocities(self) -> NDArray[np.float32]:
        """Those of the motion, a copy, [m/s], shape (vertices, 3)."""
    def read_state(self, positions: NDArray[np.float32], velocities: NDArray[np.float32]) -> None:
        """Write the state into two arrays of shape (vertices, 3) [m], [m/s]."""
    @property
    def pin_groups(self) -> list[NDArray[np.int32]]:
        """The vertices of each pin of each cloth, in the scene's order; shape (vertices of the group,)."""
    def lead(self, vertex: int, target: tuple[float, float, float], speed: float) -> None:
        """Lead a vertex towards a place [m] at no more than a speed [m/s], until :meth:`release`.

        Raises:
            IndexError: there is no such vertex.
            ValueError: a number is not finite, or the speed not above 0.
        """
    def hold(self, vertices: list[int], targets: NDArray[np.float64], over: float = 0.0) -> None:
        """Hold vertices until :meth:`release`; they reach their targets [m], shape (n, 3), in a time [s].

        Raises:
            IndexError: there is no such vertex.
            ValueError: a wrong shape or a non-finite number.
        """
    def release(self, vertices: list[int]) -> None:
        """Let vertices go, whether they are held or led.

        Raises:
            IndexError: there is no such vertex.
        """
    @property
    def held(self) -> NDArray[np.int32]:
        """The vertices that are held, in rising order; shape (n,)."""
    @property
    def gravity(self) -> list[float]:
        """Acceleration of gravity [m/s^2]; assignable."""
    @gravity.setter
    def gravity(self, gravity: list[float]) -> None: ...
    @property
    def wind(self) -> str | None:
        """The wind as JSON, with the fields of a scene; assignable, then checked as that of a scene."""
    @wind.setter
    def wind(self, wind: str | None) -> None: ...
    def shift_pins(self, group: int, offset: tuple[float, float, float], speed: float) -> None:
        """Move a pin group off its path [m] at no more than a speed [m/s]; at once if that is infinite.

        Raises:
            IndexError: there is no such group.
            ValueError: a number is not finite, or the speed not above 0.
        """
    def pin_offset(self, group: int) -> tuple[float, float, float]:
        """How far a pin group is off its path now [m].

        Raises:
            IndexError: there is no such group.
        """
    def admit(self) -> None:
        """Move the vertices of a state from elsewhere until no spring is over its limit (coarse_to_fine)."""
    def past(self) -> NDArray[np.float32] | None:
        """What the integrator needs to go on besides positions and velocities; ``None``: nothing.

        Its own velocities [m/s], where they are not those of the motion; then, of a two-step integrator,
        displacements [m] and what forces added to velocities [m/s]: shape (n vertices, 3), a copy.
        """
    def set_state(
        self,
        positions: NDArray[np.float32] | NDArray[np.float64],
        velocities: NDArray[np.float32],
        steps: int,
        past: NDArray[np.float32] | None = None,
        origins: NDArray[np.float64] | None = None,
    ) -> None:
        """Replace the state [m], [m/s] and the number of steps taken, from which the time follows.

        Positions are in the world, float64; or local, float32, if there are origins. Without its past an
        integrator starts anew.

        Raises:
            ValueError: a wrong shape or a non-finite number (which one is named).
        """
    def step(
        self,
        count: int = 1,
        dt: float | None = None,
        hook: Callable[[NDArray[np.float32], NDArray[np.float32], float], None] | None = None,
    ) -> Report:
        """Advance by ``count`` steps of ``dt`` seconds (the scene's own); other Python threads run meanwhile.

        The hook is called with positions [m], proposed velocities [m/s], which it may change, and the length
        of the step [s].

        Whatever is raised, by signal handlers too: the state is the one before the call.

        Raises:
            SimulationError: a vertex became non-finite.
            ValueError: no such length is possible.
        """
    def report(self) -> Report:
        """The report of the present state (no steps)."""
    def snapshot(self) -> bytes:
        """The state, to be given to :meth:`restore` of an engine with the same scene."""
    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot.

        Raises:
            ValueError: damaged, or of another scene.
        """
    def yardstick(self, repeats: int) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        """Time one plain spring-force pass over the cloth in its present state, on one thread.

        Returns:
            Duration of each pass [s], shape (repeats,), and the spring forces [N], shape (vertices, 3).
        """
    def external_forces(self) -> NDArray[np.float32]:
        """Gravity, air drag and wind in the present state [N], shape (vertices, 3); zero for pinned ones."""
    def spring_tensions(self) -> NDArray[np.float64] | None:
        """Tension of each spring in the last step [N], shape (springs,); ``None``: no step is known."""
    def state_hash(self) -> str:
        """XXH3 hash (16 hexadecimal digits) of positions, velocities and the past."""
