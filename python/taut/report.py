"""What happened in a call of the engine."""

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Report:
    """What happened since the last call of :meth:`taut.Simulation.step` or the last frame of a run.

    Stretch is ``|X_uv| / L - 1``, a fraction of the rest length L: 0.05 means 5 per cent.
    """

    time: float
    """Time reached [s]."""
    steps: int
    """Steps taken by the call [1]."""
    evaluations: int
    """How often the integrator looked at all springs, summed over the steps;
    a pass of a linear solver counts as one [1]."""
    worst_stretch: float
    """Largest stretch of any spring at the end of the call [1]."""
    worst_spring: int
    """Index of that spring; -1 where there are no springs."""
    worst_stretch_in_steps: float
    """Largest stretch after any step of the call [1]."""
    worst_spring_in_steps: int
    """Index of that spring; -1 where there are no springs."""
    limited_steps: int
    """Steps in which the filter changed a velocity [1]."""
    limited_springs: int
    """Springs that the filter found over their limit, summed over the steps [1]."""
    sweeps: int
    """Passes over the springs (or cycles over all levels) of the filter, summed over the steps [1]."""
    cuts: int
    """Times that the certificate had to shorten the step of a cloth to keep its limit [1]."""
    held_back_pins: int
    """Times that pins of a cloth had to wait: it is not long enough between them, or could not follow [1]."""
    pinched: int
    """Rows of contact that shared too little room, since what they keep apart was pressed from two sides;
    summed over the steps [1]. There skins and thicknesses give way."""
    held_back_bodies: int
    """Bodies that ended behind their paths, since cloth was pressed between them and something else; summed
    over the steps [1]."""
    lost_motion: float
    """Largest part of its motion that the certificate, or the bound on the kinetic energy, took from a
    cloth in a step [1]: 0 where nothing was cut, 1 where it stopped the cloth."""
    mean_lost_motion: float
    """The same, mean of the steps [1]."""
    contacts: int
    """Rows of contact, which are pairs that were near or came near, summed over the steps [1]."""
    contact_cuts: int
    """Steps that were shortened where something would have crossed something else [1]."""
    halved_steps: int
    """Steps that contact had taken in halves, quarters or eighths [1]."""
    closest: float
    """Least distance that the steps found between what touches [m]; infinite where nothing was near."""
    penetrations: int
    """Places where something intersected at the start of the last step, while that is brought apart [1]."""
    asleep: bool
    """Whether everything slept in the last step (``solver.sleep``): nothing moves then, and nothing is looked
    for, until something from outside changes."""
    kinetic_energy: float
    """At the end of the call [J]."""
    elastic_energy: float
    """Energy stored in the springs at the end of the call [J]."""
    potential_energy: float
    """In gravity, relative to the origin, at the end of the call [J]."""
    repaired_momentum: Sequence[float] = (0.0, 0.0, 0.0)
    """What rounding took from the momentum of free cloths, and was given back, summed over the steps
    [kg m/s]."""
    detection_ms: float = field(default=0.0, compare=False)
    """Time that contact took to find pairs that were near or came near, and what intersected, summed over the
    steps [ms]. This and the next two are wall-clock times: they differ from run to run, and two reports that
    differ in them alone are equal."""
    solve_ms: float = field(default=0.0, compare=False)
    """Time that the filter took for the rest, which is the projection of springs and rows and the certificate
    of the strain limit, summed over the steps [ms]."""
    certificate_ms: float = field(default=0.0, compare=False)
    """Time that contact took to look for what would cross on the way, summed over the steps [ms]."""
