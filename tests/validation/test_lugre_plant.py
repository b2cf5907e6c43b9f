"""The plant with the LuGre law: what holds in it by mechanics, whatever grips it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from validation.held_object import Held
from validation.lugre_plant import TORSION, Faces, LugreHand, least_force
from vegrip.trials.closed_loop import FORCE, FORCE_X, FORCE_Y, TORQUE

FACES = Faces((0.5, 0.5), exponent=0.25, kinetic=0.8, presliding=2e-4, play=0.0, viscous=0.0)
MASS, WEIGHT = 0.2, 0.2 * 9.81  # [kg], [N]


def held(faces: Faces = FACES, offset: float = 0.0) -> LugreHand:
    made = Held("", MASS, 0.5, offset_x=offset, offset_y=0.0).settings()
    return LugreHand(replace(made, spread=0.0), faces, 1)


def pressed(hand: LugreHand, force: float, seconds: float) -> LugreHand:
    while hand.time < seconds:
        hand.advance(0.01, np.full(2, force))
    return hand


@pytest.mark.long
def test_two_faces_carry_the_weight_and_its_torque() -> None:
    hand = pressed(held(offset=5e-3), 12.0, 3.0)
    truth = hand.truths()
    assert hand.slips == 0
    assert truth[:, FORCE] == pytest.approx([12.0, 12.0], rel=1e-3)
    assert truth[:, FORCE_Y].sum() == pytest.approx(-WEIGHT, rel=1e-3)
    assert truth[0, FORCE_X] - truth[1, FORCE_X] == pytest.approx(0.0, abs=1e-3)
    assert truth[1, TORQUE] - truth[0, TORQUE] == pytest.approx(-5e-3 * WEIGHT, rel=0.02)


@pytest.mark.parametrize(("share", "holds"), [(1.25, True), (0.95, False)])
def test_an_object_breaks_away_below_its_least_force_and_not_above(share: float, *, holds: bool) -> None:
    at_rest = 0.5 * (5.0 / 5.0) ** -0.25
    least = least_force(5.0, 0.5 * WEIGHT, 0.0, at_rest, 3e-3, 2.0, 0.25)
    assert 0.5 * (least / 5.0) ** -0.25 * least == pytest.approx(0.5 * WEIGHT)
    hand = pressed(held(), 3.0, 2.0)
    for force in np.linspace(3.0, share * least, 100):  # slowly; a face that creeps breaks away early
        pressed(hand, force, hand.time + 0.02)
    pressed(hand, share * least, 5.0)
    assert (hand.slips == 0) is holds


def test_a_face_that_slides_carries_its_kinetic_friction() -> None:
    hand = pressed(pressed(held(), 6.0, 2.0), 1.0, 2.3)
    truth, most = hand.truths(), 0.8 * 0.5 * (1.0 / 5.0) ** -0.25
    assert np.hypot(truth[:, FORCE_X], truth[:, FORCE_Y]) == pytest.approx([most, most], rel=0.02)
    assert hand.shift > 1e-2


def test_a_load_below_the_limit_stretches_the_bristles_and_no_more() -> None:
    hand = pressed(held(), 6.0, 3.0)
    mu = 0.5 * (6.0 / 5.0) ** -0.25
    expected = 0.5 * WEIGHT / (6.0 * (0.5 / 2e-4))
    assert mu * 6.0 > 0.5 * WEIGHT
    assert 0.9 * expected < hand.shift < 2e-4  # it was less pressed while it was lifted


def test_a_drive_with_play_gives_way_only_when_its_command_has_turned_by_that_much() -> None:
    hand = pressed(held(replace(FACES, play=0.4)), 6.0, 2.0)
    up = float(hand.truths()[0, FORCE])
    less = float(pressed(hand, 5.7, 3.0).truths()[0, FORCE])
    much_less = float(pressed(hand, 5.0, 4.0).truths()[0, FORCE])
    assert up == pytest.approx(5.8, abs=0.01)
    assert less == pytest.approx(up)
    assert much_less == pytest.approx(5.2, abs=0.01)


def test_torsion_counts_by_its_effective_radius() -> None:
    radius, torque = 4e-3, 3e-3
    alone = least_force(5.0, torque / (TORSION * radius), 0.0, 0.5, radius, 2.0)
    assert least_force(5.0, 0.0, torque, 0.5, radius, 2.0) == pytest.approx(alone)
    both = least_force(5.0, 1.0, torque, 0.5, radius, 2.0)
    assert both == pytest.approx(math.hypot(1.0, torque / (TORSION * radius)) / 0.5)
