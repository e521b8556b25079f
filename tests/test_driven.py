"""Cloth that is driven: what pins turn and draw goes with them, and does not tremble."""

import numpy as np
import pytest
from taut import Scene, Simulation
from taut.bench.meshes import irregular_sheet

from tools.targets.contact.pulled import funnel, twist

TREMBLE = 0.001  # [m]
LIMIT = 0.05


def _pulled(
    mesh: bool, thickness: dict[str, float], held: str, stretched: float, walked: float
) -> tuple[Simulation, np.ndarray]:
    """A sheet of 1 m, an edge, the corners of that or half of it stretched while it walks, and their path."""
    size, cells = (1.0, 1.0), (24, 24)
    if mesh:
        vertices, faces = irregular_sheet(cells, size, seed=5)
    else:
        y, x = np.mgrid[0 : cells[1] + 1, 0 : cells[0] + 1]
        vertices = np.column_stack([x.ravel() / cells[0], y.ravel() / cells[1], 0 * x.ravel()]).astype(float)
        a = (y * (cells[0] + 1) + x)[:-1, :-1].ravel()
        faces = np.concatenate(
            [
                np.column_stack([a, a + 1, a + cells[0] + 2]),
                np.column_stack([a, a + cells[0] + 2, a + cells[0] + 1]),
            ]
        )
    upper = vertices[:, 1] > vertices[:, 1].max() - 1e-9
    if held == "half":
        upper = vertices[:, 1] > 0.5
    if held == "corners":
        upper &= np.abs(vertices[:, 0] - 0.5) > 0.5 - 1e-9
    chosen = np.flatnonzero(upper)
    time = np.linspace(0, 1, 61)[:, None, None]
    middle = np.array([0.5, 0, 0])
    path = middle + (vertices[chosen] - middle) * (1 + stretched * np.sin(np.pi * time / 2) * [1, 0, 0])
    path += walked * time * [0, 1, 0]
    pins = [{"vertices": chosen.tolist(), "follow": "path"}]
    cloth = {"mesh": "sheet", "strain_limit": LIMIT, "air_drag": 0.5, "pins": pins} | thickness
    return Simulation(
        Scene({"fps": 60, "cloth": [cloth]}, {"sheet": (vertices, faces)}, paths={"path": path}), 1
    ), path


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
    """Pins draw a sheet down a funnel: cloth that is calmed must not go with them into its wall."""
    simulation = funnel(21, mesh=True).simulation(threads=1)
    reports = [simulation.run(frames=1) for _ in range(160)]
    assert sum(report.halved_steps + report.contact_cuts for report in reports) == 0


@pytest.mark.parametrize("held", ["edge", "half"])
@pytest.mark.parametrize("mesh", [False, True])
@pytest.mark.parametrize("thickness", [{}, {"thickness": 0.002}])
def test_what_is_pinned_and_stretched_too_far_goes_along(
    held: str, mesh: bool, thickness: dict[str, float]
) -> None:
    """The places nearest to those of a row stretched by 10 % are those of a row stretched by the limit."""
    simulation, path = _pulled(mesh, thickness, held, stretched=0.1, walked=0.5)
    for now in path[1:]:
        report = simulation.run(frames=1)
        behind = np.linalg.norm(simulation.positions[simulation.pin_groups[0]] - now, axis=1)
        assert report.cuts == 0 and report.worst_stretch <= LIMIT + 1e-5
        # Where anything can touch, what was held back comes back by a quarter of a cell in a step.
        assert behind.max() < 0.5 * 0.1 - 0.5 * LIMIT + 0.005
    assert report.held_back_pins == 1


@pytest.mark.parametrize("mesh", [False, True])
def test_cloth_goes_on_falling_while_its_corners_are_pulled_beyond_reach(mesh: bool) -> None:
    fallen = []
    for stretched in (0.0, 0.3):
        simulation, path = _pulled(mesh, {}, "corners", stretched, walked=0.0)
        reports = [simulation.run(frames=1) for _ in path[1:]]
        fallen.append(simulation.positions[:, 2].mean())
        assert max(report.lost_motion for report in reports) < 0.05
    # Stretched cloth sags less.
    assert fallen[1] < 0.8 * fallen[0] < -0.1
    apart = np.linalg.norm(np.diff(simulation.positions[simulation.pin_groups[0]], axis=0))
    assert 1 + 0.6 * LIMIT < apart <= 1 + LIMIT


def test_pins_that_each_pair_of_springs_would_bear_wait_and_come_back() -> None:
    """Three pins go apart around one point: any two of them are within reach of each other, not all three."""
    outwards = np.array([[1, 0, 0], [-0.5, np.sqrt(0.75), 0], [-0.5, -np.sqrt(0.75), 0]])
    net = {"points": [[0, 0, 0], *outwards.tolist()], "links": [[0, 1], [0, 2], [0, 3]], "mass": 0.01}
    pins = [{"vertices": [vertex]} for vertex in (1, 2, 3)]
    cloth = {"network": net, "strain_limit": LIMIT, "pins": pins}
    simulation = Simulation(Scene({"gravity": [0, 0, 0], "cloth": [cloth]}), 1)
    for way in (0.15, 0.0):
        for pin in range(3):
            simulation.shift_pins(pin, tuple(way * outwards[pin]), speed=0.5)
        reports = [simulation.run(frames=1) for _ in range(60)]
        assert max(report.worst_stretch_in_steps for report in reports) <= LIMIT + 1e-5
        away = np.linalg.norm(simulation.positions[1:] - simulation.positions[0], axis=1)
        if way:
            assert reports[-1].held_back_pins > 0
            assert (away > 1 + 0.9 * LIMIT).all()
    assert simulation.positions[1:] == pytest.approx(outwards, abs=1e-4)


@pytest.mark.parametrize(("across", "seed"), [(16, 1), (16, 2), (24, 2)])
def test_a_tarpaulin_that_is_drawn_too_tight_over_a_ridge_goes_on_flapping(across: int, seed: int) -> None:
    """What draws it goes back a little, where the ridge and the limit leave no way at all."""
    vertices, faces = irregular_sheet((across, across * 4 // 3), (1.8, 2.4), seed)
    places = vertices + [-0.9, -1.2, 1.23]
    pins = [
        {"nearest": [x, y, 1.23], "move": [[0.1, [0, 0, 0]], [1.5, [0, -0.25 * y, -0.9]]]}
        for x in (-0.9, 0, 0.9)
        for y in (-1.2, 1.2)
    ]
    cloth = {"name": "tarp", "mesh": "tarp", "pins": pins, "thickness": 0.002, "bending": "fabric"}
    cloth |= {"density": 0.2, "strain_limit": 0.05}
    ridge = {"name": "ridge", "capsule": {"from": [-1, 0, 1.2], "to": [1, 0, 1.2], "radius": 0.02}}
    wind = {"velocity": [2, 6, 0], "gust": {"strength": 0.5, "period": 1, "seed": 3}}
    document = {"fps": 60, "body": [ridge], "cloth": [cloth], "wind": wind}
    simulation = Simulation(Scene(document, {"tarp": (places, faces)}), 1)
    cuts, frames = 0, []
    for _ in range(180):
        report = simulation.run(1)
        cuts += report.contact_cuts
        assert report.penetrations == 0
        frames.append(simulation.positions.copy())
    speeds = 60 * np.linalg.norm(np.diff(np.array(frames[-60:]), axis=0), axis=2)
    assert cuts < 100
    assert np.sqrt((speeds**2).mean()) > 0.3
