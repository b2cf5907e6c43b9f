"""Friction that grows while the contact rests."""

import math

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.friction_prior import COULOMB
from vegrip.messages import FingertipState
from vegrip.model import paper_model

T = np.arange(0.0, 4.0, 1e-2)
MODEL = paper_model(0.01).with_effect(effect("friction_ageing"))
for symbol, value in {"beta_t": 0.05, "t_0": 0.2, "D_c": 0.1}.items():
    MODEL = MODEL.with_value(symbol, value)


def friction(depth, speed=0.0):
    return MODEL.simulate(T, depth, slip_speed=speed, plain=True).friction_coefficient


def test_friction_grows_with_the_logarithm_of_the_time_in_contact() -> None:
    touched = np.where(T > 0.5, 1e-3, -1e-3)
    age = np.where(T > 0.5, T - 0.5, 0.0)
    assert friction(touched) == pytest.approx(0.7 * (1.0 + 0.05 * np.log(1.0 + age / 0.2)), rel=1e-12)


def test_a_new_contact_is_a_fresh_one() -> None:
    lifted = np.where((T > 1.0) & (T < 2.0), -1e-3, 1e-3)
    assert friction(lifted)[T < 3.0][-1] == pytest.approx(
        0.7 * (1.0 + 0.05 * math.log1p(1.0 / 0.2)), rel=2e-3
    )


def test_sliding_renews_the_contact_down_to_an_age_of_distance_over_speed() -> None:
    speed = np.where(T > 2.0, 1e-3, 0.0)  # D_c = 0.1 mm is slid in 0.1 s
    mu = friction(np.full_like(T, 1e-3), speed)
    assert mu[T <= 2.0][-1] == pytest.approx(0.7 * (1.0 + 0.05 * math.log1p(2.0 / 0.2)))
    assert mu[-1] == pytest.approx(0.7 * (1.0 + 0.05 * math.log1p(0.1 / 0.2)))
    between = np.argmin(np.abs(T - 2.1))
    age = 0.1 + (2.0 - 0.1) * math.exp(-1.0)
    assert mu[between] == pytest.approx(0.7 * (1.0 + 0.05 * math.log1p(age / 0.2)))


@pytest.mark.slow
def test_estimate_and_forecast_carry_the_age_of_the_contact() -> None:
    """Friction falls with age (beta < 0), the force does not relax: the slip time has a closed form."""
    model = MODEL.with_value("beta_t", -0.04)
    for symbol in list(model.values):
        model = model.with_value(symbol, 0.0 if symbol == "c1" else model.values[symbol].value, std=0.0)
    model = model.with_value("mu", 0.7, std=1e-6)
    settings = EstimatorSettings(regrasp=0.0, friction_drift=0.0, offset=0.0, friction=COULOMB)
    estimator = ContactEstimator(model, SensorNoise(), settings)
    N = model.simulate([0.0, 1.0], [1e-3, 1e-3], plain=True).normal_force[-1]
    pull = 0.62 * N
    for i in range(101):
        depth = 1e-3 if i > 0 else -1e-3
        estimate = estimator.update(
            FingertipState(
                i * 10_000_000,
                "index",
                i,
                max(depth * N / 1e-3, 0.0),
                pull * (i > 0),
                0.0,
                displacement=depth,
            )
        )
    age = 1.0
    assert estimate.friction_coefficient.value == pytest.approx(
        0.7 * (1.0 - 0.04 * math.log1p(age / 0.2)), rel=1e-3
    )
    ends = 0.2 * math.expm1((1.0 - 0.62 / 0.7) / 0.04)  # where 0.7 (1 - 0.04 ln(1 + t / t_0)) = 0.62
    assert estimator.slip_margin().time_to_slip == pytest.approx(ends - age, rel=0.1)
