"""A surface that is not square to the axis of the sensor."""

import math

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.model import paper_model, predict

T = np.arange(0.0, 0.3, 1e-2)
DEPTH = np.full_like(T, 1e-3)
TILT, MU = 0.2, 0.7
MODEL = paper_model(0.01).with_effect(effect("inclination")).with_value("tilt_x", TILT)


def at_slip(angle):
    """Balance of forces on the incline, in components: what the sensor reads when the contact slips.

    The true force is N along the normal and mu N in the surface; its tangential direction is searched so
    that the sensor's tangential reading has the ``angle`` wanted.
    """
    n = np.array([math.sin(TILT), 0.0, math.cos(TILT)])
    uphill, across = np.array([math.cos(TILT), 0.0, -math.sin(TILT)]), np.array([0.0, 1.0, 0.0])
    turns = np.linspace(-math.pi, math.pi, 400001)
    true = n + MU * (np.cos(turns)[:, None] * uphill + np.sin(turns)[:, None] * across)
    off = np.abs(np.angle(np.exp(1j * (np.arctan2(true[:, 1], true[:, 0]) - angle))))
    return true[np.argmin(off)]


def test_indentation_is_along_the_surface_normal() -> None:
    assert MODEL.simulate(T, DEPTH, plain=True).indentation == pytest.approx(DEPTH * math.cos(TILT))


def test_uphill_and_downhill_differ_by_the_sine_on_both_sides() -> None:
    up, down = (
        MODEL.simulate(T, DEPTH, tangential_force=0.1, tangential_direction=angle, plain=True)
        for angle in (0.0, math.pi)
    )
    assert up.friction_coefficient[-1] == pytest.approx(MU * math.cos(TILT) + math.sin(TILT))
    assert down.friction_coefficient[-1] == pytest.approx(MU * math.cos(TILT) - math.sin(TILT))


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.5, 2.5, math.pi, -1.0])
def test_sensor_at_slip_reads_the_balance_of_forces_on_the_incline(angle) -> None:
    first = MODEL.simulate(T, DEPTH, tangential_force=0.1, tangential_direction=angle, plain=True)
    u, N = first.friction_coefficient[-1], first.normal_force
    true = at_slip(angle)
    assert u == pytest.approx(math.hypot(true[0], true[1]), rel=1e-4)
    sliding = MODEL.simulate(T, DEPTH, tangential_force=u * N, tangential_direction=angle, plain=True)
    assert sliding.sensed_force[-1] == pytest.approx(true[2] * N[-1], rel=1e-4)


def test_pull_to_either_side_slips_at_a_different_measured_force() -> None:
    columns = {"t": T, "displacement": DEPTH, "tangential_force_y": 0.0 * T}
    right, left = (
        predict(MODEL, {**columns, "tangential_force_x": pull + 0.0 * T}, plain=True)["tangential_force"][-1]
        for pull in (0.2, -0.2)
    )
    assert right / left == pytest.approx((MU + math.tan(TILT)) / (MU - math.tan(TILT)))


def test_an_incline_steeper_than_the_friction_angle_does_not_hold() -> None:
    model = MODEL.with_value("tilt_x", 0.65).with_value("mu", 0.5)
    down = model.simulate(T, DEPTH, tangential_force=0.1, tangential_direction=math.pi, plain=True)
    assert 0.0 < down.friction_coefficient[-1] < 1e-3
