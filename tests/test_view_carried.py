"""Bodies that pages drag, the ball that they throw, and the contacts that they ask for."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from taut import Scene
from taut.view.live import LiveShow
from viewing import order, picture, settle, status, unpack

FLOOR = {"name": "floor", "plane": {"normal": [0, 0, 1], "point": [0, 0, -0.5]}}
BALL = {"name": "ball", "sphere": {"center": [0.7, 1.5, 0.5], "radius": 0.3}}
MOVING = BALL | {"name": "moving", "move": [[10, [0, 0, 10]]]}
THROW = {"type": "throw", "start": [0.8, -4, 1.2], "target": [0.8, 0, 1.5]}

Make = Callable[..., LiveShow]


@pytest.fixture
def beside(flag: dict[str, Any]) -> Make:
    """The flag beside some bodies."""
    return lambda *bodies: LiveShow(Scene(flag | {"body": list(bodies)}), threads=1)


def middle(show: LiveShow, name: str) -> NDArray[np.float64]:
    return show.simulations[0].bodies[name].positions[0]


def drag(show: LiveShow, body: int, target: tuple[float, ...], client: int = 1) -> None:
    order(show, {"type": "drag", "body": body, "target": list(target)}, client)


def test_a_body_follows_the_pointer_and_stays_where_it_is_let_go(beside: Make) -> None:
    show = beside(BALL)
    settle(show, 2)
    assert "solids0" not in picture(show)[1]
    drag(show, 0, (0.9, 1.2, 0.7))
    settle(show, 10)
    np.testing.assert_allclose(middle(show, "ball"), (0.9, 1.2, 0.7), atol=1e-9)
    shown = picture(show)[1]
    np.testing.assert_allclose(shown["middles0"], [middle(show, "ball")], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(shown["solids0"] - shown["middles0"], axis=1), 0.3, atol=1e-6)
    drag(show, 0, (-3, 5, 0.7))
    settle(show, 2)
    order(show, {"type": "release"})
    settle(show, 1)
    place = middle(show, "ball")
    assert place[0] > -2, "no faster than a hand"
    settle(show, 20)
    np.testing.assert_allclose(middle(show, "ball"), place, atol=1e-9)
    order(show, {"type": "set", "control": "wind_speed", "value": 3})
    settle(show, 2)
    np.testing.assert_allclose(middle(show, "ball"), place, atol=1e-9)
    order(show, {"type": "play", "on": False})
    order(show, {"type": "reset"})
    settle(show)
    np.testing.assert_array_equal(middle(show, "ball"), [0.7, 1.5, 0.5])
    np.testing.assert_allclose(picture(show)[1]["middles0"], [[0.7, 1.5, 0.5]], atol=1e-6)


def test_a_body_that_moves_goes_on_beside_its_path(beside: Make) -> None:
    show = beside(MOVING)
    drag(show, 0, (2, 1.5, 0.5))
    settle(show, 30)
    held = middle(show, "moving")
    assert np.linalg.norm(held - (2, 1.5, 0.5)) < 0.02, "it is held against its own motion"
    show.leave(1)
    settle(show, 1)
    before = middle(show, "moving")
    settle(show, 29)
    np.testing.assert_allclose(middle(show, "moving") - before, [0, 0, 0.5], atol=1e-6)


def test_a_body_is_led_into_the_cloth_and_nothing_crosses(beside: Make) -> None:
    show = beside(BALL)
    for y in (0.5, 0, -0.5, -2):
        drag(show, 0, (0.7, y, 1.5))
        settle(show, 15)
        assert not show.simulations[0].intersections()
        assert picture(show)[0]["panels"][0]["worst"] <= 0.04 * (1 + 1e-4)


def test_what_cannot_be_dragged_is_refused(beside: Make) -> None:
    show = beside(FLOOR, BALL)
    for body, words in ((0, "the floor stays"), (2, "there are 2 bodies"), (7, "there are 2 bodies")):
        drag(show, body, (0, 0, 0))
        settle(show)
        assert words in status(show)["note"][1]
    assert not show.simulations[0].body_offset("floor").any()


def test_a_ball_is_thrown_through_the_flag(show: LiveShow) -> None:
    header, layout = unpack(show.board.layout)
    assert header["meshes"][0]["parts"] == [] and layout["ball_faces0"].shape[1] == 3
    settle(show, 10)
    assert not show.simulations[0].bodies
    order(show, THROW)
    settle(show)
    (ball,) = show.simulations[0].bodies
    radius = show.simulations[0].bodies[ball].radius
    assert picture(show)[0]["time"] == pytest.approx(show.simulations[0].time), "time goes on"
    nearest, pushed = np.inf, 0
    for _ in range(30):
        settle(show)
        simulation, at = show.simulations[0], middle(show, ball)
        shown = picture(show)[1]["ball0"]
        np.testing.assert_allclose(np.linalg.norm(shown - at, axis=1), radius, atol=1e-5)
        assert np.linalg.norm(simulation.exact_positions - at, axis=1).min() > radius
        assert simulation.report.worst_stretch <= 0.04 * (1 + 1e-4)
        nearest = min(nearest, float(np.linalg.norm(at - THROW["target"])))
        pushed += len(simulation.contacts)
    assert nearest < 0.3 and pushed > 0
    order(show, THROW)
    settle(show)
    assert middle(show, ball)[1] < -3.5, "it is thrown again"
    order(show, {"type": "reset"})
    settle(show, 3)
    assert not show.simulations[0].bodies and "ball0" not in picture(show)[1]


def test_a_ball_falls_on_the_floor_and_can_be_caught(beside: Make) -> None:
    show = beside(FLOOR)
    order(show, THROW | {"target": [0.8, -3.5, 1.0]})
    settle(show, 240)
    ball = list(show.simulations[0].bodies)[-1]
    radius = show.simulations[0].bodies[ball].radius
    place = middle(show, ball)
    assert radius < place[2] + 0.5 < radius + 0.02, "it lies on the floor"
    drag(show, 1, (0, -2, 2))
    settle(show, 120)
    np.testing.assert_allclose(middle(show, ball), [0, -2, 2], atol=1e-6)
    order(show, {"type": "release"})
    settle(show, 10)
    np.testing.assert_allclose(middle(show, ball), [0, -2, 2], atol=1e-6)


def test_a_ball_that_is_gone_cannot_be_dragged(show: LiveShow) -> None:
    order(show, THROW | {"start": [0.8, -30, 1.2], "target": [0.8, -29, 40]})
    settle(show, 120)
    assert "ball0" not in picture(show)[1]
    drag(show, 0, (0, 0, 0))
    settle(show, 2)
    assert "there are 0 bodies" in status(show)["note"][1]
    assert not show.simulations[0].bodies, "the scene is what it was"
    order(show, {"type": "compare", "on": True})
    settle(show, 2)
    assert len(show.simulations) == 2


def test_throws_that_cannot_be_are_refused(show: LiveShow) -> None:
    for throw, words in (
        ({"start": [0.8, 0, 1.5], "target": [0.8, 0, 1.5]}, "start elsewhere"),
        ({"start": [0.8, 0.1, 1.5], "target": [0.8, -3, 1.5]}, "the cloth is where"),
    ):
        order(show, {"type": "throw"} | throw)
        settle(show, 2)
        assert words in status(show)["note"][1] and "ball0" not in picture(show)[1]


def test_filters_without_contact_refuse_a_ball_with_the_reason(show: LiveShow) -> None:
    order(show, {"type": "set", "control": "filter", "value": "none"})
    settle(show)
    order(show, THROW)
    settle(show, 3)
    assert "knows no contact" in status(show)["note"][1] and not show.simulations[0].bodies
    order(show, {"type": "set", "control": "filter", "value": "coarse_to_fine"})
    settle(show, 3)
    assert not show.simulations[0].bodies, "a throw that was refused is forgotten"
    order(show, THROW)
    settle(show, 3)
    assert "ball0" in picture(show)[1]


def test_throw_reset_and_throw_again_before_anything_is_built(show: LiveShow) -> None:
    for text in (THROW, {"type": "reset"}, THROW, {"type": "compare", "on": True}, {"type": "reset"}, THROW):
        order(show, text)
        show.turn()
    settle(show, 5)
    settle(show, 20)
    order(show, {"type": "compare", "on": False})
    order(show, THROW)
    settle(show, 3)
    assert "ball0" in picture(show)[1]


def test_contacts_are_sent_while_a_page_wants_them(flag: dict[str, Any]) -> None:
    flag["wind"]["velocity"] = [0, -4, 0]
    wall = {"name": "wall", "plane": {"normal": [0, 1, 0], "point": [0, -0.005, 0]}}
    show = LiveShow(Scene(flag | {"body": [wall]}), threads=1)
    settle(show, 20)
    panel = picture(show)[0]["panels"][0]
    assert panel["contacts"] > 0 and 0 < panel["closest"] < 0.01
    assert "touches0" not in picture(show)[1]
    for client in (1, 2):
        order(show, {"type": "contacts", "on": True}, client)
    settle(show, 5)
    touches, contacts = picture(show)[1]["touches0"], show.simulations[0].contacts
    assert touches.shape == (len(contacts), 4)
    np.testing.assert_allclose(touches[:, 3].sum(), contacts.forces.sum(), rtol=1e-5, atol=1e-9)
    order(show, {"type": "contacts", "on": False})
    settle(show)
    assert "touches0" in picture(show)[1]
    show.leave(2)
    settle(show)
    assert "touches0" not in picture(show)[1]
