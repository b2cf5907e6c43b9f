"""The pieces of a diagnosis: candidates, held-out scores, regimes, discrepancy."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vegrip.effects import BUILT_IN, Effect, effect
from vegrip.identification.diagnosis.acceptance import misfit_by_regime
from vegrip.identification.diagnosis.catalogue import Candidate, moved, null, trials, why_unseen
from vegrip.identification.diagnosis.discrepancy import LENGTHS, _curve, _tents, _variables
from vegrip.identification.diagnosis.score_tests import Hint
from vegrip.identification.diagnosis.search import EvidenceThreshold, shortlist
from vegrip.model import BASE, paper_model

RNG = np.random.default_rng(5)
ADDED = [name for name in BUILT_IN if name not in BASE]


@pytest.mark.parametrize("name", ADDED)
def test_every_trial_lies_within_the_bounds_and_is_not_nothing(name) -> None:
    one = effect(name)
    tried = list(trials(one))
    assert 1 <= len(tried) <= 20
    for values in tried:
        for p in one.parameters:
            assert p.low <= values[p.symbol] <= p.high
        assert any(p.null is not None and values[p.symbol] != p.null for p in one.parameters)


@pytest.mark.parametrize("name", ADDED)
def test_absent_means_the_model_without_it(name) -> None:
    t = np.arange(0.0, 2.0, 5e-3)
    depth = 1e-3 * np.sin(2.0 * t)
    model = paper_model(0.01)
    wider = model.with_effect(effect(name))
    for symbol, value in null(effect(name)).items():
        wider = wider.with_value(symbol, value)
    plain, wide = (m.simulate(t, depth, plain=True).sensed_force for m in (model, wider))
    assert wide == pytest.approx(plain, abs=1e-12)


def test_rates_are_tried_over_decades_and_lengths_around_their_value() -> None:
    rate = effect("second_relaxation").parameters[1]
    assert moved(rate, 3.0) / moved(rate, -3.0) == pytest.approx(np.exp(6.0 * rate.std))
    assert moved(rate, 0.0) == rate.default


def test_misfit_by_regime_is_one_for_noise_and_grows_with_a_hidden_mean() -> None:
    regimes = np.repeat(np.arange(100.0), 200)
    noise = RNG.standard_normal(regimes.size)
    assert misfit_by_regime(noise, regimes) == pytest.approx(1.0, abs=0.4)
    assert misfit_by_regime(noise + 0.3, regimes) > 10.0
    regimes[:] = -1.0
    assert misfit_by_regime(noise, regimes) == 1.0


def test_shortlist_keeps_what_is_worth_a_refit() -> None:
    def hint(name: str, gain: float) -> Hint:
        one = effect(name) if name in BUILT_IN else Effect(name, "", (), ())
        return Hint(Candidate(one, {}, ()), gain, {}, 1.0, 1.0, np.zeros(1))

    hints = [hint("a", 1000.0), hint("b", 80.0), hint("c", 40.0), hint("displacement_backlash", 30.0)]
    names = [one.candidate.name for one in shortlist(hints)]
    assert names == ["a", "b", "displacement_backlash"]
    assert shortlist([]) == []
    assert shortlist([hint("a", 4.0)]) == []


def test_discrepancy_has_evidence_only_where_there_is_a_curve() -> None:
    n = 4000
    x = RNG.uniform(0.0, 1.0, n)
    other = RNG.uniform(0.0, 1.0, n)
    J, prior = np.stack([np.ones(n), x], axis=1), np.array([10.0, 10.0])  # what the parameters can do
    knots = np.linspace(0.0, 1.0, 25)
    w = RNG.standard_normal(n) + 2.0 * np.sin(6.0 * x)
    right, share, curve = _curve(w, J, prior, _tents(x, knots), knots)
    wrong, _, _ = _curve(w, J, prior, _tents(other, knots), knots)
    nothing, _, _ = _curve(RNG.standard_normal(n) + 3.0 * x, J, prior, _tents(x, knots), knots)
    assert right > 500.0
    assert share > 0.2
    assert abs(wrong) < 10.0
    assert abs(nothing) < 10.0
    assert np.ptp(curve) > 1.0


def test_evidence_of_a_curve_is_that_of_the_gaussian_it_is() -> None:
    """``ln N(w; 0, 1 + B C B' + J S J')`` less the same without the curve, by dense covariances."""
    n = 300
    x = np.sort(RNG.uniform(0.0, 1.0, n))
    knots = np.linspace(0.0, 1.0, 13)
    J, prior = np.stack([np.ones(n), x], axis=1), np.array([2.0, 3.0])
    w = RNG.standard_normal(n) + np.sin(20.0 * x)
    B = _tents(x, knots)
    gain, _, _ = _curve(w, J, prior, B, knots)
    dense = []
    plain = np.eye(n) + (J * prior**2) @ J.T
    without = multivariate_normal(cov=plain).logpdf(w)
    for length in LENGTHS:
        C = np.exp(-0.5 * ((knots[:, None] - knots) / length) ** 2)
        for size in np.logspace(-2.0, 2.0, 41):
            both = multivariate_normal(cov=plain + size**2 * B @ C @ B.T).logpdf(w)
            dense.append(both - without)
    assert gain == pytest.approx(max(dense), abs=0.5)  # of sizes on another grid


def test_tents_interpolate() -> None:
    knots = np.array([0.0, 1.0, 3.0])
    values = np.array([0.0, 0.5, 2.0, 5.0])
    assert _tents(values, knots) @ np.array([0.0, 10.0, 30.0]) == pytest.approx([0.0, 5.0, 20.0, 30.0])


def test_a_further_effect_pays_more_than_the_first_and_form_pays_most() -> None:
    adhesion, damping = effect("adhesion"), effect("fast_damping")
    assert EvidenceThreshold(0.0, 900.0, 9.0, ()).of(adhesion) == 8.0
    lag = (effect("sensor_lag"),)
    calm, rough = EvidenceThreshold(1000.0, 0.0, 1.0, lag), EvidenceThreshold(1000.0, 100.0, 3.0, lag)
    assert calm.of(adhesion) == 20.0  # nothing stands out any more
    assert rough.of(adhesion) == 15.0  # of 100 nats that are left, and of 1000 that were gained
    assert rough.of(damping) == 100.0  # damping beside a lag
    assert (
        EvidenceThreshold(1000.0, 900.0, 3.0, lag).of(adhesion) == 15.0
    )  # much is left: another effect may take it


@pytest.mark.parametrize(
    ("channels", "sliding", "seen", "reason"),
    [
        (("tangential_force",), 0, 5, "it shows only in slip"),
        (("tangential_force", "torque_z"), 0, 0, "it shows only in slip"),
        (("tangential_force",), 5, 0, ""),
        (("contact_radius",), 5, 0, "it shows only in the radius"),
        (("contact_radius", "torque_z"), 0, 0, "it shows only in the radius"),
        (("contact_radius",), 0, 5, ""),
        (("normal_force", "contact_radius"), 0, 0, ""),
    ],
)
def test_what_a_recording_cannot_show_is_told_by_the_channel_that_would(
    channels, sliding, seen, reason
) -> None:
    measured = SimpleNamespace(
        recording=SimpleNamespace(columns={"normal_force": np.ones(9)}),
        sliding=np.arange(sliding),
        seen=np.arange(seen),
    )
    assert why_unseen(Effect("mine", "", (), (), channels=channels), measured) == reason


@pytest.mark.parametrize("stiffness", [1e-3, 1.0, 1e3])  # [N/m] of a cell, of foam, of rubber
def test_over_which_variables_a_curve_is_looked_for(stiffness) -> None:
    t = np.arange(6.0)
    depth = np.array([-1e-4, 1e-4, 3e-4, 3e-4, 1e-4, -1e-4])
    problem = SimpleNamespace(
        measured=SimpleNamespace(
            motion=SimpleNamespace(displacement=depth), recording=SimpleNamespace(t=t, columns={})
        ),
        stiffness=np.where(depth > 0.0, stiffness, 0.0),
        episodes=np.zeros(6),
        depth=1e-4,
    )
    ones = np.ones(6)
    values = {"normal_force": ones, "time_in_contact": 0.09 * ones, "time": t, "tangential_force": 0.0 * ones}
    rows = np.array([1, 2, 4, 5])
    told = dict(_variables(problem, SimpleNamespace(values=values), None, rows, "normal_force"))
    assert told["contact"].tolist() == [1.0, 1.0, 1.0, 0.0]
    assert told["direction"].tolist() == [stiffness, stiffness, -stiffness, 0.0]
    assert told["below_deepest"] == pytest.approx([0.0, 0.0, 2e-4, 0.0])
    assert told["speed"] == pytest.approx(np.arcsinh([2.0, 1.0, -2.0, -2.0]))
    assert told["time_in_contact"] == pytest.approx(-ones[:4])
    assert told["time"].tolist() == [1.0, 2.0, 4.0, 5.0]
