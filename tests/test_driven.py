"""Cloth that is driven: what pins turn and draw goes with them, and does not tremble."""

import numpy as np

from tools.targets.contact.pulled import funnel, twist

TREMBLE = 0.001  # [m]


def test_what_is_twisted_does_not_tremble() -> None:
    """Between two pinned edges masses are hardly scaled: a step has many parts, and the limit acts all over.

    Second differences from frame to frame, root mean square; four steps a frame leave 0.4 mm.
    """
    made = twist(17, mesh=False)
    del made.document["cloth"][0]["thickness"]
    simulation = made.simulation(threads=1)
    places = []
    for _ in range(100):
        simulation.run(frames=1)
        places.append(simulation.positions.copy())
    turns = np.linalg.norm(np.diff(places[40:], 2, axis=0), axis=2)
    assert np.sqrt((turns**2).mean()) < TREMBLE


def test_what_is_drawn_past_a_body_needs_no_shorter_steps() -> None:
    """Pins draw a sheet down a funnel, which stands still: cloth that is calmed must not go with the pins into its wall."""
    simulation = funnel(21, mesh=True).simulation(threads=1)
    reports = [simulation.run(frames=1) for _ in range(160)]
    assert sum(report.halved_steps + report.contact_cuts for report in reports) == 0
