"""Bodies in the viewer: its pages are told what stands there, and where what moves is now."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Cache, Scene, Simulation, record
from taut.bodies import Skin
from taut.view.live import LiveShow
from taut.view.playback import PlaybackShow
from viewing import order, picture, settle, status, unpack

FLOOR = {"name": "floor", "plane": {"normal": [0, 0, 1], "point": [0, 0, -0.5]}}
WALL = {"name": "wall", "plane": {"normal": [0, -1, 0], "point": [0, 3, 0]}}
BALL = {"name": "ball", "sphere": {"center": [0.7, 1.5, 0.5], "radius": 0.3}}
MOVING = BALL | {"move": [[0.5, [0, 0, 1]]]}
CRATE = {"name": "crate", "box": {"center": [2.5, 0, 0], "size": [1, 1, 1]}}

Make = Callable[..., Scene]


@pytest.fixture
def beside(flag: dict[str, Any]) -> Make:
    """The flag beside some bodies."""
    return lambda *bodies: Scene(flag | {"body": list(bodies)})


def points(simulation: Simulation, *names: str) -> NDArray[np.float32]:
    """Where the skins of bodies are now."""
    bodies = simulation.bodies
    start = Simulation(simulation.scene, threads=1).bodies
    return np.concatenate([Skin(start[name]).points(bodies[name]) for name in names]).astype(np.float32)


def test_a_page_begins_with_the_bodies(beside: Make) -> None:
    show = LiveShow(beside(BALL, FLOOR, CRATE, WALL), threads=1)
    header, arrays = unpack(show.board.layout)
    assert header["meshes"][0]["floor"] == -0.5
    corners = arrays["solids0"][arrays["solid_faces0"]].astype(float)
    volume = np.linalg.det(corners).sum() / 6
    assert volume == pytest.approx(1 + 4 / 3 * np.pi * 0.3**3, rel=0.01), "closed, and facing outwards"
    assert np.array_equal(arrays["solids0"], points(show.simulations[0], "ball", "crate"))
    # The floor is drawn as such; the wall is a square that faces the cloth.
    assert np.array_equal(arrays["square_faces0"], [[0, 1, 2], [0, 2, 3]])
    square = arrays["squares0"]
    assert (square[:, 1] == 3).all() and np.cross(square[1] - square[0], square[2] - square[0])[1] < 0
    settle(show, 2)
    assert "solids0" not in picture(show)[1], "what stays is sent once"


def test_pages_without_bodies_are_told_so(show: LiveShow) -> None:
    header, arrays = unpack(show.board.layout)
    assert header["meshes"][0]["floor"] is None
    for name in ("solids0", "solid_faces0", "squares0", "square_faces0"):
        assert arrays[name].shape == (0, 3)


def test_what_moves_is_sent_with_every_picture(beside: Make) -> None:
    show = LiveShow(beside(MOVING, CRATE), threads=1)
    settle(show, 9)
    simulation = show.simulations[0]
    assert simulation.bodies["ball"].positions[0, 2] == pytest.approx(0.5 + simulation.time / 0.5)
    assert np.array_equal(picture(show)[1]["solids0"], points(simulation, "ball", "crate"))
    order(show, {"type": "play", "on": False})
    order(show, {"type": "reset"})
    settle(show)
    assert np.array_equal(picture(show)[1]["solids0"], unpack(show.board.layout)[1]["solids0"])


def test_bodies_go_on_with_what_was_changed(beside: Make) -> None:
    show = LiveShow(beside(MOVING), threads=1)
    settle(show, 9)
    order(show, {"type": "play", "on": False})
    order(show, {"type": "set", "control": "wind_speed", "value": 3})
    settle(show)
    simulation = show.simulations[0]
    assert simulation.scene.document["wind"]["velocity"] != [8.0, 1.5, 0.0]
    assert simulation.bodies["ball"].positions[0, 2] == pytest.approx(0.5 + simulation.time / 0.5)


def test_filters_without_contact_are_refused_with_the_reason(beside: Make) -> None:
    show = LiveShow(beside(BALL), threads=1)
    order(show, {"type": "compare", "on": True})
    settle(show, 2)
    assert "knows no contact" in status(show)["note"][1] and len(show.simulations) == 1
    assert not status(show)["compare"]


def test_recordings_tell_how_near_things_were(beside: Make, recorded: Path, tmp_path: Path) -> None:
    near = BALL | {"sphere": {"center": [0.7, 0.302, 1.5], "radius": 0.3}}
    path = record(Simulation(beside(near), threads=1), tmp_path / "near.zarr", 5).path
    playback = PlaybackShow([Cache.open(recorded), Cache.open(path)])
    order(playback, {"type": "contacts", "on": True})
    order(playback, {"type": "seek", "frame": 4})
    playback.turn(0.0)
    header, arrays = picture(playback)
    without, beside_it = header["panels"]
    assert (without["contacts"], without["closest"]) == (0, None)
    assert beside_it["contacts"] > 0 and 0 < beside_it["closest"] < 0.01
    assert "touches1" not in arrays and "contacts" not in status(playback)["note"][1]


def test_recordings_have_their_own_bodies(beside: Make, recorded: Path, tmp_path: Path) -> None:
    path = record(Simulation(beside(MOVING, WALL), threads=1), tmp_path / "ball.zarr", 10).path
    playback = PlaybackShow([Cache.open(recorded), Cache.open(path)])
    order(playback, {"type": "seek", "frame": 7})
    playback.turn(0.0)
    arrays = picture(playback)[1]
    simulation = Simulation(beside(MOVING, WALL), threads=1)
    simulation.run(7)
    np.testing.assert_allclose(arrays["solids1"], points(simulation, "ball"), atol=1e-6)
    assert "solids0" not in arrays and arrays["squares1"].shape == (4, 3)
