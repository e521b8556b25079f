"""Textile tests on simulated cloth: strips that are pulled, circles that are draped."""

import json
import math

import numpy as np
import pytest
from taut import Scene, SceneError
from taut.laboratory import drape, pull
from taut.laboratory.cusick import CLOTH, DISC, folds
from taut.laboratory.round import disc_mesh, shadow_area

CURVE = [[0.0, 0.0], [0.04, 2.0], [0.06, 22.0], [0.1, 142.0]]


def test_a_shadow_counts_once_what_lies_twice_and_nothing_that_stands_upright() -> None:
    vertices, faces, rim = disc_mesh(CLOTH, DISC, 5e-3)
    assert DISC < rim < DISC + 5e-3
    ring = math.pi * (CLOTH**2 - DISC**2)
    assert shadow_area(vertices, faces, DISC) == pytest.approx(ring, rel=1e-3)
    twice = np.concatenate([vertices, vertices - [0, 0, 0.05]])
    both = np.concatenate([faces, faces + len(vertices)])
    assert shadow_area(twice, both, DISC) == pytest.approx(ring, rel=1e-3)
    folded = vertices * [1, 1, 0] + np.array([0, 0, 1]) * vertices[:, :1]
    folded[:, 0] = np.abs(folded[:, 0])
    assert shadow_area(folded, faces, DISC) == pytest.approx(ring / 2, rel=0.01)
    tube = vertices / np.hypot(vertices[:, 0], vertices[:, 1])[:, None] * 0.1
    tube[:, 2] = np.hypot(vertices[:, 0], vertices[:, 1])
    assert shadow_area(tube, faces, 0.1) < 1e-3 * ring


@pytest.mark.parametrize("count", [0, 4, 7, 11])
def test_folds_are_counted_along_the_edge(count: int) -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 180, endpoint=False) + 0.3
    distance = 0.12 + (0.02 * np.cos(count * angle) + 0.001 * np.sin(31 * angle) if count else 0.0)
    edge = np.column_stack([distance * np.cos(angle), distance * np.sin(angle), 0.0 * angle])
    assert folds(edge) == count


def sag_of_a_plate(load: float, bending: float) -> float:
    """How far the free edge of a ring sinks that is clamped inside [m]; thin plate, Poisson's ratio 0.

    B ∇⁴w = q: w = q r⁴ / 64 B + c₁ + c₂ r² + c₃ ln r + c₄ r² ln r; held level at a, free at b.
    """
    a, b, scale = DISC, CLOTH, load / bending
    log_a, log_b = math.log(a), math.log(b)
    conditions = [
        [1.0, a**2, log_a, a**2 * log_a],
        [0.0, 2.0 * a, 1.0 / a, 2.0 * a * log_a + a],
        [0.0, 2.0, -1.0 / b**2, 2.0 * log_b + 3.0],
        [0.0, 0.0, 0.0, 4.0 / b],
    ]
    right = [-scale * a**4 / 64, -scale * a**3 / 16, -3.0 * scale * b**2 / 16, -scale * b / 2]
    factors = np.linalg.solve(conditions, right)
    return float(scale * b**4 / 64 + factors @ [1.0, b**2, log_b, b**2 * log_b])


def test_a_board_keeps_its_shadow_and_a_limp_cloth_loses_it() -> None:
    material = {"density": 0.2, "stiffness": 40.0, "strain_limit": 0.05}
    board = drape({**material, "bending": 4e-3}, 0.01)
    assert board.coefficient > 99.0 and board.folds == 0
    edge = np.hypot(board.positions[:, 0], board.positions[:, 1]) > 0.149
    sag = -float(board.positions[edge, 2].mean())
    assert sag == pytest.approx(sag_of_a_plate(0.2 * 9.81, 4e-3), rel=0.05)
    limp = drape({**material, "bending": 1e-7}, 0.01)
    assert limp.coefficient < 25.0 and limp.stretch < 0.05


@pytest.mark.slow
def test_wool_drapes_as_published_whatever_the_mesh() -> None:
    coarse, fine = (drape({"fabric": "wool", "bending": "fabric"}, edge) for edge in (0.01, 7.5e-3))
    assert 40 <= fine.coefficient <= 70 and 4 <= fine.folds <= 9
    assert abs(coarse.coefficient - fine.coefficient) < 5
    assert fine.speed < 2e-3, "it has not come to rest"


@pytest.mark.parametrize("filter", ["none", "coarse_to_fine"])
def test_a_strip_gives_its_curve_back(filter: str) -> None:
    found = pull({"curves": {"tension": CURVE}, "shear_stiffness": 0.0, "damping": 0.02}, 0.09, filter)
    bare = filter == "none"
    assert found.limit == (None if bare else 0.06)
    assert found.strain[-1] == pytest.approx(0.09 if bare else 0.06, rel=0.01)
    exact = np.interp(found.strain, *np.transpose(CURVE))
    assert np.abs(found.force - exact).max() < 0.02 * exact.max()


def test_a_strip_of_a_preset_has_its_stiffness_and_stops_at_its_limit() -> None:
    found = pull({"fabric": "wool", "shear_stiffness": 0.0}, 0.2)
    assert found.limit == 0.08
    assert np.allclose(found.force, 25.0 * found.strain, atol=0.02 * 25.0 * 0.08)


def test_what_makes_no_test_is_refused() -> None:
    for wrong in (0.0, 2.0):
        with pytest.raises(ValueError, match="furthest"):
            pull({"fabric": "wool"}, wrong)
        with pytest.raises(ValueError, match="edge"):
            drape({"fabric": "wool"}, wrong)
    with pytest.raises(SceneError, match="no such field"):
        drape({"fabrik": "wool"})


def test_bending_of_the_preset_is_written_out() -> None:
    grid = {"size": [1, 1], "cells": [4, 4]}
    document = Scene({"cloth": [{"grid": grid, "fabric": "wool", "bending": "fabric"}]}).document
    assert isinstance(document["cloth"][0]["bending"], float)
    assert Scene(json.loads(json.dumps(document))).document == document
    without = Scene({"cloth": [{"grid": grid, "fabric": "wool"}]}).document
    assert without["cloth"][0]["bending"] == 0.0
