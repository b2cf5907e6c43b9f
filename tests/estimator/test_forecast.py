"""Time to slip and least force against long simulations and direct search."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

from vegrip.contact.limit_surface.fast import gauge
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.friction_prior import COULOMB
from vegrip.messages import NAN, ContactEstimate, FingertipState
from vegrip.model import ContactModel

Record = Callable[..., list[FingertipState]]
Run = Callable[[ContactEstimator, list[FingertipState]], ContactEstimate]
KNOTS, DEPTHS = [0.0, 0.3, 0.5, 0.6], [-1e-4, -1e-4, 9e-4, 9e-4]


def loaded(states: list[FingertipState], force: float) -> list[FingertipState]:
    return [
        dataclasses.replace(s, tangential_force_x=force, tangential_force_y=0.0, slip=NAN) for s in states
    ]


def test_time_to_slip_agrees_with_simulating_the_hold(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    e = run(estimator, loaded(press(model, KNOTS, DEPTHS), 0.0))
    mu, N = e.friction_coefficient.value, e.normal_force.value
    fitted = model
    for symbol in ("K", "p", "c1", "nu1"):
        fitted = fitted.with_value(symbol, estimator.value(symbol).value)
    load = 0.85 * mu * N
    last = press(model, KNOTS, DEPTHS)[-1]
    estimator.update(dataclasses.replace(last, stamp=last.stamp + 1, tangential_force_x=load, slip=math.nan))
    margin = estimator.slip_margin()
    t = np.concatenate([np.linspace(0.0, 0.6, 601), 0.6 + np.geomspace(1e-4, 10.0, 4000)])
    held = fitted.simulate(t, np.interp(t, KNOTS, DEPTHS)).normal_force[600:]
    crossing = t[600:][np.flatnonzero(held <= held[0] * 0.85)[0]] - 0.6
    assert margin.time_to_slip == pytest.approx(crossing, rel=0.15)
    assert margin.earliest_slip <= margin.time_to_slip


def test_a_light_load_never_slips_and_a_heavy_one_already_has(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    run(estimator, loaded(press(model, KNOTS, DEPTHS), 0.05))
    assert estimator.slip_margin().time_to_slip == math.inf
    estimator.reset()
    run(estimator, loaded(press(model, KNOTS, DEPTHS), 5.0))
    margin = estimator.slip_margin()
    assert margin.time_to_slip == margin.earliest_slip == 0.0
    assert margin.margin.value < 0.0
    assert margin.force_reserve < 0.0


def test_least_force_grows_with_load_and_margin(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    found = []
    for load in (0.1, 0.2, 0.4):
        estimator.reset()
        run(estimator, loaded(press(model, KNOTS, DEPTHS), load))
        found.append([estimator.least_force(margin) for margin in (0.1, 0.3, 0.5)])
    table = np.array(found)
    assert np.all(np.diff(table, axis=0) > 0.0)
    assert np.all(np.diff(table, axis=1) > 0.0)


def test_least_force_without_uncertainty_is_the_limit_surface_itself(
    model: ContactModel, press: Record, run: Run
) -> None:
    """Pure force, everything known, no horizon: N = f / (mu (1 - margin)) ."""
    sure = model
    for symbol in model.values:
        sure = sure.with_value(symbol, model.values[symbol].value, std=1e-6)
    noise = SensorNoise(1e-5, 1e-8, 1e-9, 1e-12)
    settings = EstimatorSettings(friction=COULOMB, horizon=0.0, offset=1e-6, force_bias=1e-3)
    estimator = ContactEstimator(sure, noise, settings)
    run(estimator, loaded(press(sure, KNOTS, DEPTHS, noise=noise), 0.3))
    for margin in (0.1, 0.4):
        wanted = 0.3 / (model.values["mu"].value * (1.0 - margin))
        assert estimator.least_force(margin) == pytest.approx(wanted, rel=2e-3)


def test_least_force_with_torque_meets_the_margin_where_it_says(
    model: ContactModel, press: Record, run: Run
) -> None:
    sure = model
    for symbol in model.values:
        sure = sure.with_value(symbol, model.values[symbol].value, std=1e-6)
    noise = SensorNoise(1e-5, 1e-8, 1e-9, 1e-12)
    estimator = ContactEstimator(
        sure, noise, EstimatorSettings(friction=COULOMB, horizon=0.0, offset=1e-6, force_bias=1e-3)
    )
    states = [
        dataclasses.replace(s, torque_z=5e-4) for s in loaded(press(sure, KNOTS, DEPTHS, noise=noise), 0.2)
    ]
    e = run(estimator, states)
    N = estimator.least_force(0.25)
    # along the model's own loading: the relaxed force stays, N_e moves
    K, p, x_ref = sure.values["K"].value, sure.values["p"].value, sure.reference_depth
    elastic = K * (e.indentation.value / x_ref) ** p + (N - e.normal_force.value)
    x = x_ref * (elastic / K) ** (1.0 / p)
    a, mu = math.sqrt(2.0 * sure.tip_radius * x), sure.values["mu"].value
    k = e.pressure_exponent.value
    assert gauge(k, 0.2 / (mu * N), 5e-4 / (mu * N * a)) == pytest.approx(0.75, rel=0.02)


def test_the_horizon_asks_for_more_force(model: ContactModel, press: Record, run: Run) -> None:
    found = []
    for horizon in (0.0, 0.2, 2.0):
        estimator = ContactEstimator(
            model, SensorNoise(), EstimatorSettings(friction=COULOMB, horizon=horizon)
        )
        run(estimator, loaded(press(model, KNOTS, DEPTHS), 0.3))
        found.append(estimator.least_force(0.3))
    assert found == sorted(found)
    assert found[2] > 1.05 * found[0]


def test_no_force_suffices_for_an_absurd_load(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    run(estimator, loaded(press(model, KNOTS, DEPTHS), 1e6))
    assert estimator.least_force(0.3) == math.inf


@pytest.mark.other_model
def test_the_ellipse_asks_for_less_force_under_force_and_torque_and_as_much_under_either(
    model: ContactModel, press: Record, run: Run
) -> None:
    """The ellipse lies outside the surface, except at its two ends."""
    sure = model
    for symbol in model.values:
        sure = sure.with_value(symbol, model.values[symbol].value, std=1e-6)
    noise = SensorNoise(1e-5, 1e-8, 1e-9, 1e-12)
    found = {}
    for surface in ("exact", "ellipse"):
        settings = EstimatorSettings(
            friction=COULOMB, horizon=0.0, offset=1e-6, force_bias=1e-3, surface=surface
        )
        estimator = ContactEstimator(sure, noise, settings)
        for load, torque in ((0.3, 0.0), (0.0, 8e-4), (0.25, 5e-4)):
            estimator.reset()
            states = loaded(press(sure, KNOTS, DEPTHS, noise=noise), load)
            run(estimator, [dataclasses.replace(s, torque_z=torque) for s in states])
            found[surface, load] = estimator.least_force(0.2)
    assert found["ellipse", 0.3] == pytest.approx(found["exact", 0.3], rel=1e-5)
    assert found["ellipse", 0.0] == pytest.approx(found["exact", 0.0], rel=1e-5)
    assert 0.93 < found["ellipse", 0.25] / found["exact", 0.25] < 0.99


def test_a_surer_grip_asks_for_more_force_and_half_sure_for_the_estimate(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    run(estimator, loaded(press(model, KNOTS, DEPTHS), 0.3))
    found = [estimator.least_force(0.1, confidence) for confidence in (0.5, 0.8, 0.95, 0.99)]
    assert found == sorted(found)
    assert estimator.least_force(0.1) == found[2]
    spread = estimator.value("mu").std
    assert found[2] / found[0] > math.exp(1.6 * spread)
