"""Friction that depends on the slip speed."""

import math

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.model import paper_model, predict

R = 0.01
T = np.arange(0.0, 0.2, 5e-3)
MODEL = paper_model(R).with_effect(effect("rate_dependent_friction"))
for symbol, value in {"r_mu": 0.6, "v_s": 2.0, "beta_v": 0.05, "v_0": 0.1}.items():
    MODEL = MODEL.with_value(symbol, value)


def friction(model, speed):
    done = model.simulate(T, np.full_like(T, 1e-3), slip_speed=speed, plain=True)
    return done.friction_coefficient[-1]


@pytest.mark.parametrize("speed", [0.0, 1e-5, 1e-3, 2e-3, 0.1])
def test_friction_lies_on_the_stribeck_curve(speed) -> None:
    """v_s = 2 mm/s and v_0 = 0.1 mm/s at this radius; mu_s = 0.7, mu_c = 0.42, beta 0.035."""
    curve = 0.42 + 0.28 * math.exp(-((speed / 2e-3) ** 2)) + 0.035 * math.log(1.0 + speed / 1e-4)
    assert friction(MODEL, speed) == pytest.approx(curve)


def test_without_its_logarithm_fast_sliding_has_the_kinetic_coefficient() -> None:
    assert friction(MODEL.with_value("beta_v", 0.0), 1.0) == pytest.approx(0.42)


def test_sliding_force_and_torque_fall_alike() -> None:
    columns = {
        "t": T, "displacement": np.full_like(T, 1e-3), "tangential_force_x": np.full_like(T, 0.3),
        "torque_z": np.full_like(T, 1e-3), "slip_speed": np.full_like(T, 4e-3),
    }  # fmt: skip
    stuck, sliding = (
        predict(MODEL, {**columns, "slip": np.full_like(T, slip)}, plain=True) for slip in (0.0, 1.0)
    )
    ratio = friction(MODEL, 4e-3) / 0.7
    for channel in ("tangential_force", "torque_z"):
        assert sliding[channel] == pytest.approx(ratio * stuck[channel])
