"""Rolling on an elastic joint under tangential load."""

import math

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.model import paper_model, predict

T = np.arange(0.0, 0.3, 1e-2)
DEPTH = np.full_like(T, 1e-3)
RHO, MU = 0.15, 0.7
MODEL = paper_model(0.01).with_effect(effect("rolling")).with_value("rho", RHO)
K = MODEL.values["K"].value


def test_sensor_reads_normal_and_tangential_force_in_the_frame_it_has_rolled_to() -> None:
    """True normal force N and friction F, turned by th: (T, y) = rotation of (F, N)."""
    pull = 0.4 * K
    done = MODEL.simulate(T, DEPTH, tangential_force=pull, plain=True)
    th, N, y = RHO * pull / K, done.normal_force, done.sensed_force
    F = (pull - N * math.sin(th)) / math.cos(th)
    assert y == pytest.approx(N * math.cos(th) - F * math.sin(th))


def test_slip_is_coulombs_in_the_frame_of_the_surface() -> None:
    """Turn what the sensor reads at slip, (T, y), back by th: friction over normal force is mu."""
    columns = {"t": T, "displacement": DEPTH, "tangential_force_x": 0.1 * K + 0.0 * T}
    limit = predict(MODEL, columns, plain=True)["tangential_force"]
    y = MODEL.simulate(T, DEPTH, tangential_force=limit, plain=True).sensed_force
    th = RHO * limit / K
    assert limit * np.cos(th) - y * np.sin(th) == pytest.approx(MU * (limit * np.sin(th) + y * np.cos(th)))


def test_sensed_force_falls_with_the_square_of_the_tangential_force() -> None:
    steps = [MODEL.simulate(T, DEPTH, tangential_force=f * K, plain=True) for f in (0.0, 0.02, 0.04)]
    rest, one, two = (done.sensed_force[-1] for done in steps)
    assert (rest - two) / (rest - one) == pytest.approx(4.0, rel=5e-3)


def test_a_stiffer_joint_rolls_less() -> None:
    soft, stiff = (MODEL.with_value("rho", rho) for rho in (0.2, 0.02))
    mu = [model.simulate(T, DEPTH, plain=True).friction_coefficient[-1] for model in (soft, stiff)]
    assert mu[0] > mu[1] > MU
