"""Friction is learned from slipping and from not slipping, and from nothing else."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.estimator.compiled import module_for
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.messages import ContactEstimate, FingertipState
from vegrip.model import ContactModel

Record = Callable[..., list[FingertipState]]
Run = Callable[[ContactEstimator, list[FingertipState]], ContactEstimate]
KNOTS, DEPTHS = [0.0, 0.3, 0.8, 3.0], [-1e-4, -1e-4, 9e-4, 9e-4]
QUIET = SensorNoise(1e-5, 1e-8, 1e-9, 1e-12)


def test_a_slip_tells_the_friction_coefficient(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    true = model.with_value("mu", 1.1)
    e = run(estimator, press(true, KNOTS, DEPTHS, share=0.3, slip_after=2.0))
    assert e.friction_coefficient.value == pytest.approx(1.1, rel=0.06)
    assert e.friction_coefficient.std < 0.12


@pytest.mark.parametrize("learns", [True, False])
def test_while_a_finger_is_felt_to_slide_its_bound_is_not_above_zero(
    model: ContactModel, press: Record, *, learns: bool
) -> None:
    """Whatever friction is believed, and whether it is learned: a finger that slides has no margin."""
    fixed = model if learns else model.with_value("mu", 5.0, std=0.0)
    e = ContactEstimator(fixed, SensorNoise())
    for state in press(model, KNOTS, DEPTHS, share=0.2):
        e.assimilate(state)
    held = e.slip_margin()
    e.assimilate(dataclasses.replace(state, stamp=state.stamp + 2_000_000, slip=1.0))
    felt = e.slip_margin()
    assert held.lower_bound > 0.0
    assert held.earliest_slip > 0.0
    assert felt.lower_bound <= 0.0
    assert felt.earliest_slip == 0.0
    e.assimilate(dataclasses.replace(state, stamp=state.stamp + 4_000_000, slip=0.0))
    assert e.slip_margin().lower_bound > 0.0


def test_sticking_at_a_high_load_excludes_small_coefficients_only(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    """Truncated prior, integrated directly: mean and std of ln mu given ln mu > ln u."""
    true = model.with_value("mu", 1.0)
    run(estimator, press(true, KNOTS, DEPTHS, share=0.8, noise=QUIET))
    found = estimator.value("mu")
    prior, s = math.log(model.values["mu"].value), model.values["mu"].std

    def moment(n: int) -> float:
        def density(x: float) -> float:
            return float(x**n * norm.pdf(x, prior, s) * norm.cdf((x - math.log(0.8)) / 0.06))

        return quad(density, -3.0, 3.0, points=[math.log(0.8)])[0]

    mean = moment(1) / moment(0)
    std = math.sqrt(moment(2) / moment(0) - mean**2)
    assert math.log(found.value) == pytest.approx(mean, abs=0.03)
    assert found.std == pytest.approx(std, rel=0.1)


def test_the_same_hold_seen_again_and_again_is_one_piece_of_evidence(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    true = model.with_value("mu", 0.8)
    run(estimator, press(true, KNOTS, DEPTHS, share=0.8))
    after_one = estimator.value("mu").value
    for n in range(20):
        again = press(true, [0.0, 0.3, 0.5, 0.8], [-1e-4, 9e-4, 9e-4, -1e-4], share=0.8, seed=n)
        start = round((4.0 + n) * 1e9)
        for state in again:
            estimator.update(shifted(state, start))
    assert estimator.value("mu").value < 1.15 * after_one


def shifted(state: FingertipState, by: int) -> FingertipState:
    return dataclasses.replace(state, stamp=state.stamp + by)


def test_unsensed_slip_teaches_nothing(
    estimator: ContactEstimator, model: ContactModel, press: Record
) -> None:
    for state in press(model, KNOTS, DEPTHS, share=0.95):
        estimator.update(dataclasses.replace(state, slip=math.nan))
    assert estimator.value("mu").value == pytest.approx(model.values["mu"].value, rel=1e-12)


def test_a_light_touch_teaches_nothing(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    """At a few millinewtons the noise of the load alone reaches any utilisation."""
    run(estimator, press(model, [0.0, 0.2, 0.4, 2.0], [-1e-4, -1e-4, 8e-5, 8e-5]))
    assert estimator.value("mu").value == pytest.approx(model.values["mu"].value, rel=0.02)


def test_friction_is_forgotten_up_to_the_prior(
    estimator: ContactEstimator, model: ContactModel, press: Record, run: Run
) -> None:
    true = model.with_value("mu", 1.1)
    states = press(true, KNOTS, DEPTHS, share=0.3, slip_after=2.0)
    run(estimator, states)
    known = estimator.value("mu").std
    for seconds in (100, 10_000, 1_000_000):
        last = shifted(states[-1], seconds * 1_000_000_000)
        estimator.update(last)
        assert known < estimator.value("mu").std <= model.values["mu"].std * (1.0 + 1e-9)
        known = 0.9 * estimator.value("mu").std


def test_learned_friction_covers_the_truth(model: ContactModel, compiled: ContactEstimator) -> None:
    """200 fingers, 12 loadings each, straight through the learner: 95 % intervals cover 90 .. 99 %."""
    places = compiled.layout.places()
    start = places["FRICTION"][0]
    learn = module_for(model, compiled.layout, plain=True).learn_friction
    rng = np.random.default_rng(1)
    prior, s = math.log(model.values["mu"].value), model.values["mu"].std
    inside = 0
    for _ in range(200):
        m = compiled._blank.copy()
        ln_mu = prior + s * rng.standard_normal()
        for _ in range(12):
            limit = math.exp(ln_mu + 0.06 * rng.standard_normal())
            peak = math.exp(ln_mu) * rng.uniform(0.3, 1.3)
            for u in np.linspace(0.05, peak, 12):
                slips = u >= limit
                for _ in range(4):
                    learn(m, 0.3, min(u, limit), 0.02, float(slips), True, True)
                if slips:
                    break
            learn(m, 0.05, 0.02, 0.02, 0.0, True, True)
        inside += abs(m[start] - ln_mu) <= 1.96 * math.sqrt(m[start + 1])
    assert 0.90 <= inside / 200 <= 0.99


@pytest.mark.parametrize("scatter", [0.03, 0.06, 0.1])
@pytest.mark.parametrize("slips", [1, 5])
def test_of_a_face_that_has_slipped_the_next_slip_comes_above_what_a_grip_counts_on(
    model: ContactModel, compiled: ContactEstimator, scatter: float, slips: int
) -> None:
    """What is stated is the mean of a face, which slips scatter about; a grip counts on a margin besides."""
    start = compiled.layout.places()["FRICTION"][0]
    learn = module_for(model, compiled.layout, plain=True).learn_friction
    rng, faces = np.random.default_rng(2), 400
    prior, s = math.log(model.values["mu"].value), model.values["mu"].std
    told = compiled.settings.friction_scatter
    off, beyond, std = np.empty(faces), np.empty(faces), np.empty(faces)
    for face in range(faces):
        m = compiled._blank.copy()
        mean = prior + s * rng.standard_normal()
        for _ in range(slips):
            limit = math.exp(mean + scatter * rng.standard_normal())
            for u in np.linspace(0.05, 1.0, 6) * limit:
                for _ in range(4):
                    learn(m, 0.02, u, 0.02, float(u >= 0.999 * limit), True, True)
            learn(m, 0.05, 0.02, 0.02, 0.0, True, True)
        off[face], std[face] = m[start] - mean, math.sqrt(m[start + 1])
        beyond[face] = mean + scatter * rng.standard_normal() - m[start]
    if slips == 1:
        assert np.median(std) == pytest.approx(math.hypot(told, 0.02), rel=0.05)
    if scatter <= told:
        assert np.mean(np.abs(off) < 1.96 * std) >= 0.9
    grip = GripSettings()
    counted = math.log(1.0 - grip.wanted_margin) - norm.ppf(grip.probability) * std
    assert np.mean(beyond < counted) <= 1.0 - grip.probability


def test_the_utilisation_owes_nothing_to_what_is_believed_of_friction(
    estimator: ContactEstimator, model: ContactModel, press: Record
) -> None:
    states = press(model, [0.0, 0.3, 0.8, 1.5], [-1e-4, -1e-4, 9e-4, 9e-4], share=0.5)
    told = []
    for mean, variance in ((math.log(0.7), 0.01), (math.log(0.5), 0.09), (math.log(1.8), 0.04)):
        estimator.reset()
        for state in states[:-1]:
            estimator.assimilate(state)
        for base in ("", "BASE_"):
            estimator.named[f"FRI_{base}{'LN' if base else 'LN_MU'}"] = mean
            estimator.named[f"FRI_{base}VAR"] = variance
        estimator.assimilate(states[-1])
        told.append(estimator.named["REP_GAUGE"] * estimator.named["REP_MU"])
    assert told[0] == pytest.approx(0.5 * model.values["mu"].value, rel=0.1)
    assert told[1] == pytest.approx(told[0], rel=0.01)
    assert told[2] == pytest.approx(told[0], rel=0.01)
