"""Where cloth touches something and how hard, and bodies that are sent off their paths."""

import copy
from typing import Any

import numpy as np
import pytest
from taut import Scene, Simulation
from taut.bench.meshes import irregular_sheet
from taut.bench.walker import closed

FLOOR = {"name": "floor", "plane": {"normal": [0, 0, 1]}, "friction": 0.3}
BALL = {"name": "ball", "sphere": {"center": [0, 0, -0.4], "radius": 0.2}}
LIFT = BALL | {"name": "lift", "move": [[1.0, [0, 0, 0.3]]]}
WEIGHT = 0.2 * 9.81


def simulation(*bodies: dict[str, Any], height: float = 0.004, pins: Any = ()) -> Simulation:
    grid = {"size": [1, 1], "cells": [16, 16], "origin": [-0.5, -0.5, height], "axes": ["x", "y"]}
    cloth = {"grid": grid, "density": 0.2, "thickness": 0.004, "friction": 0.3, "pins": list(pins)}
    return Simulation(Scene({"fps": 60, "body": list(bodies), "cloth": [cloth]}), threads=1)


def test_contacts_bear_the_weight_of_a_sheet_that_lies_on_a_plane() -> None:
    lying = simulation(FLOOR)
    assert len(lying.contacts) == 0
    lying.run(90)
    borne = []
    for _ in range(60):
        lying.step()
        contacts = lying.contacts
        borne.append((contacts.normals * contacts.forces[:, None] + contacts.friction).sum(axis=0))
    np.testing.assert_allclose(np.mean(borne, axis=0), [0, 0, WEIGHT], atol=0.02 * WEIGHT)
    assert (contacts.bodies == 0).all() and np.array_equal(contacts.normals, [[0, 0, 1]] * len(contacts))
    np.testing.assert_allclose(contacts.positions, lying.exact_positions[contacts.vertices], atol=1e-9)
    assert (np.linalg.norm(contacts.friction, axis=1) <= 0.3 * contacts.forces * (1 + 1e-4)).all()
    lying.set_state(lying.positions, lying.velocities, lying.steps)
    assert len(lying.contacts) == 0


def test_a_sheet_that_sticks_to_the_face_of_a_box_rests_on_its_vertices_and_stays() -> None:
    angle = np.arctan(0.95)  # of friction 1
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    turned = [0.0, float(np.degrees(angle)), 0.0]
    # The diagonal of the face runs below the middle of the sheet.
    box = {"center": (-0.1 * normal).tolist(), "size": [6.0, 2.0, 0.2], "rotate": turned}
    slope = {"name": "slope", "friction": 1.0, "thickness": 0.001, "box": box}
    grid = {"size": [0.3, 0.3], "cells": [16, 16], "origin": [-0.15, -0.15, 0], "axes": ["x", "y"]}
    cloth = {"grid": grid, "thickness": 0.002, "friction": 1.0, "air_drag": 0.0, "drag_coefficient": 0.0}
    placed = {"rotate": turned, "translate": (0.00201 * normal).tolist()}
    lying = Simulation(Scene({"fps": 60, "body": [slope], "cloth": [cloth | placed]}), threads=1)
    lying.run(60)
    assert set(lying.contacts.vertices.tolist()) == set(range(17**2))
    before = lying.exact_positions
    lying.run(60)
    assert np.linalg.norm(lying.exact_positions - before, axis=1).max() < 1e-6


def test_a_ball_that_is_sent_pushes_the_cloth_and_waits_where_that_is_taut() -> None:
    pins = [{"corner": at} for at in ("top-left", "top-right", "bottom-left", "bottom-right")]
    pushed = simulation(BALL, height=0.0, pins=pins)
    for frame in range(60):
        pushed.shift_body("ball", (0, 0, 0.6 * (frame + 1) / 60), over=1 / 60)
        pushed.run(1)
        middle = pushed.bodies["ball"].positions[0]
        assert np.linalg.norm(pushed.exact_positions - middle, axis=1).min() > 0.2
    assert not pushed.intersections()
    offset = pushed.body_offset("ball")[2]
    assert 0.2 < offset < 0.5, "the cloth reaches no further"
    assert middle[2] == pytest.approx(-0.4 + offset)
    contacts = pushed.contacts
    # Where cloth is that taut it may touch itself, too.
    by_ball = contacts.bodies == 0
    assert (contacts.normals[by_ball, 2] > 0).all() and contacts.forces[by_ball].sum() > WEIGHT


def test_a_body_off_its_path_goes_on_with_it() -> None:
    moving = simulation(LIFT, height=1.0)
    moving.shift_body("lift", (0.5, 0, 0))
    np.testing.assert_allclose(moving.bodies["lift"].positions, [[0.5, 0, -0.4]])
    moving.run(30)
    np.testing.assert_allclose(moving.bodies["lift"].positions, [[0.5, 0, -0.25]], atol=1e-9)
    np.testing.assert_allclose(moving.body_offset("lift"), [0.5, 0, 0], atol=1e-9)
    moving.shift_body("lift", (0.5, 0.2, 0), over=0.5)
    moving.run(15)
    np.testing.assert_allclose(moving.body_offset("lift"), [0.5, 0.1, 0], atol=1e-9)
    again = copy.deepcopy(moving)
    moving.run(15)
    again.run(15)
    for one in (moving, again):
        np.testing.assert_allclose(one.bodies["lift"].positions, [[0.5, 0.2, -0.1]], atol=1e-9)
    moving.set_state(moving.positions, moving.velocities, 0)
    np.testing.assert_allclose(moving.bodies["lift"].positions, [[0.5, 0.2, -0.4]], atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        (("box", (0, 0, 0)), KeyError, "body = 'box': must be one of floor, ball"),
        ((1, (0, 0, 0)), KeyError, "body = 1: must be"),
        (("ball", (0, 0)), ValueError, "offset = .*three finite numbers"),
        (("ball", (0, 0, np.nan)), ValueError, "offset"),
        (("ball", (0, 0, 1e300)), ValueError, "offset"),
        (("ball", "up"), TypeError, "offset"),
        (("ball", (0, 0, 0), -1), ValueError, "over"),
        (("ball", (0, 0, 0), np.inf), ValueError, "over"),
    ],
)
def test_what_cannot_be_sent_is_refused(arguments: Any, error: type[Exception], words: str) -> None:
    asked = simulation(FLOOR, BALL)
    with pytest.raises(error, match=words):
        asked.shift_body(*arguments)
    assert not asked.body_offset("ball").any()
    with pytest.raises(KeyError, match="must be one of"):
        asked.body_offset("nothing")


def test_on_a_smooth_body_of_triangles_rows_are_those_of_vertices() -> None:
    around, radius, thickness, skin = 96, 0.15, 0.004, 0.001
    angle = np.arange(around) * 2 * np.pi / around
    ring = radius * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    places, faces = closed(np.stack([ring + [0, along, 0] for along in np.linspace(0.4, -0.4, 41)]))
    roll = {"name": "roll", "mesh": "roll", "friction": 0.8, "thickness": skin}
    vertices, corners = irregular_sheet((48, 24), (0.8, 0.4), 3)
    cloth = {"mesh": "sheet", "density": 0.2, "thickness": thickness, "friction": 0.8, "air_drag": 1.5}
    cloth["translate"] = [-0.4, -0.2, radius + 0.01]
    meshes = {"roll": (places, faces), "sheet": (vertices, corners)}
    draped = Simulation(Scene({"fps": 60, "body": [roll], "cloth": [cloth]}, meshes), threads=1)
    draped.run(150)

    # The cloth keeps half of its thickness and the skin.
    apart = thickness / 2 + skin
    normals = np.stack([np.cos(angle + np.pi / around), 0 * angle, np.sin(angle + np.pi / around)], axis=1)
    weights = np.array([(i, j, 6 - i - j) for i in range(7) for j in range(7 - i)]) / 6
    inside = np.einsum("wc,tcx->twx", weights, draped.exact_positions[draped.faces]).reshape(-1, 3)
    heights = (inside @ normals.T).max(axis=1) - radius * np.cos(np.pi / around)
    assert heights.min() > 0.78 * apart, "edges cut a fifth deeper at most"
    own = (draped.exact_positions @ normals.T).max(axis=1) - radius * np.cos(np.pi / around)
    beside = int((own < 1.5 * apart).sum())
    assert beside > 500
    assert draped.step().contacts < 1.25 * beside
