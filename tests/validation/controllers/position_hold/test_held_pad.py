"""The held pad is the exact solution of its material, and the rules know no more than they are told."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from validation.controllers.position_hold.gripper import Gripper
from validation.controllers.position_hold.pad import RATES, TOTAL_SHARE, Pad, PressedPad, draw_pad
from validation.controllers.position_hold.scenario import LIFT_END_S, draw_hold
from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.settings import FingertipSettings

PAD = Pad(12e-3, 2.0, 1.6, (0.2, 0.15, 0.1), (6.0, 0.4, 0.02), 0.8)


def pressed(pad: Pad, depth: float, ramp: float, steps: int) -> PressedPad:
    """Return a pad pressed to ``depth`` [m] within ``ramp`` [s], N_e growing evenly."""
    one = PressedPad(pad)
    for step in range(1, steps + 1):
        one.press(pad.elastic_depth(pad.elastic_force(depth) * step / steps), ramp / steps)
    return one


@pytest.mark.parametrize("time", [0.02, 1.0, 60.0])
def test_after_a_sudden_press_the_force_is_that_of_the_relaxation_function(time: float) -> None:
    pad = pressed(PAD, 2e-3, 1e-9, 1)
    pad.press(2e-3, time)
    assert pad.force == pytest.approx(PAD.elastic_force(2e-3) * PAD.left_after(time), rel=1e-6)


def test_a_pad_that_is_pressed_slowly_and_then_held_has_the_force_of_the_hereditary_integral() -> None:
    ramp, hold = 0.7, 12.0
    pad = pressed(PAD, 2e-3, ramp, 7)
    pad.press(2e-3, hold)
    integral = quad(lambda s: PAD.left_after(ramp + hold - s), 0.0, ramp, epsabs=1e-12)[0]
    assert pad.force == pytest.approx(PAD.elastic_force(2e-3) / ramp * integral, rel=1e-9)


def test_a_long_step_of_a_standing_pad_is_the_same_as_many_short_ones() -> None:
    one, many = pressed(PAD, 1.5e-3, 0.1, 5), pressed(PAD, 1.5e-3, 0.1, 5)
    one.press(1.5e-3, 30.0)
    for _ in range(300):
        many.press(1.5e-3, 0.1)
    assert one.force == pytest.approx(many.force, rel=1e-12)


def test_a_pad_that_is_tightened_again_is_the_fingertip_of_the_virtual_hand() -> None:
    """Its history is summed directly; both take N_e as linear within a step."""
    tip = FingertipSettings(
        radius=PAD.radius,
        reference_force=PAD.stiffness,
        exponent=PAD.exponent,
        amplitudes=PAD.shares,
        rates=PAD.rates,
    )
    ours, theirs = PressedPad(PAD), Fingertips((tip,), 0.01)
    for step in range(1, 701):
        depth = 1e-3 * min(step / 30.0, 1.0) + 5e-4 * min(max(step - 400, 0) / 20.0, 1.0)
        ours.press(depth, 0.01)
        theirs.press(np.array([depth]))
    assert ours.force == pytest.approx(float(theirs.force[0]), rel=1e-6)


def test_a_gripper_stops_at_the_force_and_then_stands() -> None:
    gripper = Gripper(PAD, np.random.default_rng(0))
    while not gripper.move(lambda _, force: force >= 3.0):
        pass
    assert gripper.pressed.force == pytest.approx(3.0, abs=0.01)
    depth = gripper.pressed.depth
    for _ in range(40):
        gripper.stand()
    assert gripper.pressed.depth == depth
    assert 0.5 * 3.0 < gripper.pressed.force < 0.9 * 3.0


def test_pads_lose_what_the_measured_materials_lose() -> None:
    pads = [draw_pad(np.random.default_rng(i)) for i in range(50)]
    totals = [sum(pad.shares) for pad in pads]
    rates = [rate for pad in pads for rate in pad.rates]
    assert TOTAL_SHARE[0] <= min(totals) < 0.35
    assert 0.55 < max(totals) <= TOTAL_SHARE[1]
    assert RATES[0] <= min(rates) < 0.02
    assert 5.0 < max(rates) <= RATES[1]


def test_the_pads_of_a_material_stay_the_same_and_its_loads_do_not() -> None:
    one, other = draw_hold(3, 0), draw_hold(3, 1)
    assert one.pad == other.pad
    assert one.loads != other.loads
    assert one.pad != draw_hold(4, 0).pad
    assert all(load.duration > LIFT_END_S for load in one.loads)


def test_a_contact_needs_more_where_it_is_smaller_and_infinitely_much_where_there_is_none() -> None:
    load = replace(draw_hold(3, 0).loads[0], tangential=1.0, torque=2e-3)
    assert load.need(0.5, 3e-3) > load.need(0.5, 6e-3) > 2.0
    assert load.need(0.5, 0.0) == math.inf
