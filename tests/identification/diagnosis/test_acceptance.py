"""The pieces of a diagnosis: candidates, held-out scores, regimes, discrepancy."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vegrip.effects import BUILT_IN, Effect, effect
from vegrip.identification.diagnosis import candidate_fit, diagnose, discrepancy, score_tests, search
from vegrip.identification.diagnosis.acceptance import (
    FORM,
    Verdict,
    amount_covariance,
    gain_beside,
    is_resolved,
    misfit_by_regime,
)
from vegrip.identification.diagnosis.candidate_fit import HELD_OUT, CandidateFit, _is_astray, scores
from vegrip.identification.diagnosis.diagnosis import doubt_form, doubt_timing
from vegrip.identification.diagnosis.discrepancy import (
    LENGTHS,
    Refit,
    _blocks,
    _curve,
    _knots,
    _tents,
    _variables,
    find_discrepancy,
)
from vegrip.identification.diagnosis.score_tests import (
    Candidate,
    Hint,
    moved,
    null,
    screen_candidates,
    trials,
    why_unseen,
)
from vegrip.identification.diagnosis.search import EvidenceThreshold, required_evidence, shortlist
from vegrip.identification.fit import fit
from vegrip.identification.fit.problem import AT
from vegrip.identification.fit.solve import Optimum
from vegrip.model import BASE, paper_model
from vegrip.parameters import Parameter

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
    law = next(p for p in effect("power_law_relaxation").parameters if p.symbol == "alpha_P")
    assert moved(law, 1.0) - moved(law, -1.0) == pytest.approx(2.0 * law.std)


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
        return Hint(Candidate(one, {}, ()), gain, {}, 1.0, np.zeros(1))

    hints = [hint("a", 1000.0), hint("b", 80.0), hint("c", 40.0), hint("displacement_backlash", 30.0)]
    names = [one.candidate.name for one in shortlist(hints)]
    assert names == ["a", "b", "displacement_backlash"]
    assert shortlist([]) == []
    assert shortlist([hint("a", 4.0)]) == []
    for gains, count in (((1000.0, 50.1, 49.9), 2), ((8.1, 7.9), 1), (range(107, 100, -1), 5)):
        assert [one.gain for one in shortlist([hint("a", gain) for gain in gains])] == list(gains)[:count]


def test_discrepancy_has_evidence_only_where_there_is_a_curve() -> None:
    n = 4000
    x = RNG.uniform(0.0, 1.0, n)
    other = RNG.uniform(0.0, 1.0, n)
    J, prior = np.stack([np.ones(n), x], axis=1), np.array([10.0, 10.0])  # what the parameters can do
    knots = np.linspace(0.0, 1.0, 25)
    w = RNG.standard_normal(n) + 2.0 * np.sin(6.0 * x)
    right, share, curve = _curve(w, J, refit(w, J, prior), _tents(x, knots), knots)
    wrong, _, _ = _curve(w, J, refit(w, J, prior), _tents(other, knots), knots)
    straight = RNG.standard_normal(n) + 3.0 * x
    nothing, _, _ = _curve(straight, J, refit(straight, J, prior), _tents(x, knots), knots)
    assert right > 500.0
    assert share > 0.2
    assert abs(wrong) < 10.0
    assert abs(nothing) < 10.0
    assert np.ptp(curve) > 1.0


def refit(w, J, prior) -> Refit:
    return Refit(J.T @ J + np.diag(prior**-2.0), J.T @ w)


def curve_takes(w, J, prior, B, curve) -> float:
    """What a curve leaves less of the sum of squares, the model fitted beside it."""
    wide, none = np.vstack([J, np.diag(1.0 / prior)]), np.zeros(prior.size)
    left = [np.append(r, none) for r in (w, w - B @ curve)]
    costs = [np.sum((r - wide @ np.linalg.lstsq(wide, r, rcond=None)[0]) ** 2) for r in left]
    return costs[0] - costs[1]


@pytest.mark.parametrize("others", [0, 60])
def test_evidence_of_a_curve_is_that_of_the_gaussian_it_is(others) -> None:
    """``ln N(w; 0, 1 + B C B' + J S J')`` less the same without the curve, by dense covariances.

    Of all channels: the ``others`` hold the parameters, though the curve is in one.
    """
    n = 80
    x = np.sort(RNG.uniform(0.0, 1.0, n))
    knots = np.linspace(0.0, 1.0, 13)
    J, prior = np.stack([np.ones(n), x], axis=1), np.array([2.0, 3.0])
    w = np.r_[RNG.standard_normal(n) + np.sin(20.0 * x), RNG.standard_normal(others)]
    J = np.vstack([J, RNG.standard_normal((others, 2))])
    one = _tents(x, knots)
    gain, share, curve = _curve(w[:n], J[:n], refit(w, J, prior), one, knots)
    B = np.vstack([one, np.zeros((others, knots.size))])
    assert share * (w[:n] @ w[:n]) == pytest.approx(curve_takes(w, J, prior, B, curve), rel=1e-6)
    dense = []
    plain = np.eye(w.size) + (J * prior**2) @ J.T
    without = multivariate_normal(cov=plain).logpdf(w)
    for length in LENGTHS:
        C = np.exp(-0.5 * ((knots[:, None] - knots) / length) ** 2)
        for size in np.logspace(-1.5, 1.5, 25):
            both = multivariate_normal(cov=plain + size**2 * B @ C @ B.T).logpdf(w)
            dense.append(both - without)
    assert gain == pytest.approx(max(dense), abs=0.5)  # of sizes on another grid


def test_tents_interpolate() -> None:
    knots = np.array([0.0, 1.0, 3.0])
    values = np.array([0.0, 0.5, 2.0, 5.0])
    assert _tents(values, knots) @ np.array([0.0, 10.0, 30.0]) == pytest.approx([0.0, 5.0, 20.0, 30.0])


def test_a_further_effect_pays_more_than_the_first_and_form_pays_most() -> None:
    adhesion, damping = effect("adhesion"), effect("fast_damping")
    lag, force, slips = (effect("sensor_lag"),), np.array([-2.0, 0.0]), np.array([0.0, 2.0])

    def asked(one, left, misfit, change=force, *, beside=lag, gained=1000.0, is_exact=False) -> float:
        threshold = EvidenceThreshold(gained, np.array([0.8, 0.2]), left, misfit, beside)
        return threshold.of(one, change, is_exact=is_exact)

    assert asked(adhesion, 900.0, 9.0, beside=()) == 8.0
    assert asked(adhesion, 0.0, 1.0) == 20.0  # nothing stands out any more
    assert asked(adhesion, 80.0, 3.0) == 15.0  # of 1000 nats that were gained
    assert asked(adhesion, 120.0, 3.0) == 18.0  # of 120 that are left, which are few
    assert asked(adhesion, 900.0, 3.0) == 15.0  # much is left: another effect may take it
    assert asked(adhesion, 900.0, 3.0, is_exact=True) == 15.0
    assert asked(damping, 100.0, 3.0) == 100.0  # damping beside a lag
    much = {"gained": 1e5, "is_exact": True}
    assert asked(adhesion, 0.0, 1.0, gained=1e5) == 500.0
    assert asked(adhesion, 0.0, 1.0, **much) == pytest.approx(400.0)  # form is mended where it was gained
    assert asked(adhesion, 0.0, 1.0, slips, **much) == pytest.approx(100.0)
    assert asked(adhesion, 0.0, 1.0, slips, gained=1e4, is_exact=True) == 20.0
    assert asked(adhesion, 0.0, 1.0, force + slips, **much) == pytest.approx(250.0)
    assert asked(adhesion, 300.0, 3.0, slips, gained=1e5) == 1500.0
    assert asked(adhesion, 300.0, 3.0, **much) == 100.0  # and some of it stays
    assert asked(adhesion, 900.0, 3.0, **much) == 135.0


@pytest.mark.parametrize("misfit", [1.0, 3.0])
@pytest.mark.parametrize("left", [0.0, 120.0, 900.0, 5e4])
@pytest.mark.parametrize("name", ["adhesion", "fast_damping"])
def test_no_effect_passes_with_less_than_it_has_to_gain_at_the_least(name, left, misfit) -> None:
    """Whatever it changes; and one that leaves noise alone has gained most of what is left."""
    one = effect(name)
    threshold = EvidenceThreshold(1e4, np.array([0.8, 0.2]), left, misfit, (effect("sensor_lag"),))
    bent = threshold.of(one, np.ones(2), is_exact=False)
    exact = [threshold.of(one, np.array(c), is_exact=True) for c in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0))]
    assert threshold.at_least(one) <= min(bent, *(max(pays, left) for pays in exact))
    assert threshold.at_least(one) >= min(bent, 20.0)


def test_what_cannot_gain_what_is_asked_is_given_up_and_not_finished(monkeypatch) -> None:
    """Of 100 nats that are asked the first one gains 150; the other one's fit ends 30 above."""
    costs, bounds = {"a": 850.0, "b": 930.0}, []

    def extend(_, hint, __, least) -> SimpleNamespace:
        bounds.append(least)
        cost = costs[hint.candidate.name]
        optimum = SimpleNamespace(is_given_up=cost > least)
        return SimpleNamespace(evidence=-cost, error=1.0, optimum=optimum, is_finished=False)

    monkeypatch.setattr(search, "extend_problem", extend)
    monkeypatch.setattr(search, "finish_fit", lambda *_: SimpleNamespace(is_finished=True))
    base = SimpleNamespace(evidence=-1000.0, error=2.0, optimum=SimpleNamespace(cost=1000.0))
    hints = [SimpleNamespace(candidate=SimpleNamespace(name=name, effect=None)) for name in costs]
    asked = SimpleNamespace(at_least=lambda _: 100.0)
    fits = search._refitted(base, hints, None, 1, asked=asked)
    assert bounds == [900.0, 900.0]
    assert [one.is_finished for one in fits] == [True, False]


def test_what_was_gained_is_gained_in_a_channel() -> None:
    """Of 1000 nats the force has 800, one of the slips 200; the other does not count, the radius lost."""
    rows = {"doubtful": np.zeros(2), "slip_std": np.ones(2), "radius_std": np.ones(1)}
    problem = SimpleNamespace(**rows, counted=np.array([True, True, True, False, True]), whitener=None)

    def fitted(residual: list[float], evidence: float) -> CandidateFit:
        optimum = Optimum(np.zeros(0), np.array(residual), np.zeros((5, 0)), 0.0)
        return CandidateFit(problem, optimum, np.zeros(5), evidence, 1.0)

    first, base = fitted([20.0, 40.0, 20.0, 99.0, 0.0], 7.0), fitted([0.0, 20.0, 0.0, 0.0, 9.0], 1007.0)
    asked = required_evidence(first, base, 3.0, (effect("sensor_lag"),))
    assert asked.gained == 1000.0
    assert asked.share == pytest.approx([0.8, 0.8, 0.2, 0.2, 0.0])


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


def test_the_residuals_of_every_channel_stand_one_after_the_other() -> None:
    n, sliding, seen = 7, np.array([1, 4]), np.array([0, 3, 5])
    measured = SimpleNamespace(recording=range(n), sliding=sliding, seen=seen)
    blocks = list(_blocks(SimpleNamespace(measured=measured)))
    assert [one[0] for one in blocks] == ["normal_force", "tangential_force", "contact_radius"]
    assert np.concatenate([np.arange(12)[one[2]] for one in blocks]).tolist() == list(range(12))
    assert [one[1].tolist() for one in blocks] == [list(range(n)), [1, 4], [0, 3, 5]]


@pytest.mark.parametrize("stiffness", [1e-3, 1.0, 1e3])  # [N/m] of a cell, of foam, of rubber
def test_over_which_variables_a_curve_is_looked_for(stiffness) -> None:
    t = np.arange(6.0)
    depth = np.array([-1e-4, 1e-4, 3e-4, 3e-4, 1e-4, -1e-4])
    problem = SimpleNamespace(
        measured=SimpleNamespace(recording=SimpleNamespace(t=t, is_step=False, columns={})),
        stiffness=np.where(depth > 0.0, stiffness, 0.0),
        episodes=np.zeros(6),
        depth=1e-4,
    )
    ones = np.ones(6)
    values = {"normal_force": ones, "time_in_contact": 0.09 * ones, "time": t, "tangential_force": 0.0 * ones}
    values["indentation"] = depth
    rows = np.array([1, 2, 4, 5])
    told = dict(_variables(problem, SimpleNamespace(values=values), None, rows, "normal_force"))
    assert told["contact"].tolist() == [1.0, 1.0, 1.0, 0.0]
    assert told["direction"].tolist() == [stiffness, stiffness, -stiffness, 0.0]
    assert told["below_deepest"] == pytest.approx([0.0, 0.0, 2e-4, 0.0])
    assert told["speed"] == pytest.approx(np.arcsinh([2.0, 1.0, -2.0, -2.0]))
    assert told["time_in_contact"] == pytest.approx(-ones[:4])
    assert told["time"].tolist() == [1.0, 2.0, 4.0, 5.0]


X = np.random.default_rng(8).normal(size=(60, 3))
PRIOR = np.array([0.7, 2.0, 0.3])


def test_evidence_of_a_linear_model_is_that_of_the_gaussian_that_it_is(linear) -> None:
    y = RNG.standard_normal(60)
    groups = np.repeat(np.arange(3.0), 20)
    problem = linear(y, X[:, :2], PRIOR[:2])
    found = problem.fitted(groups)
    covariance = np.eye(60) + (X[:, :2] * PRIOR[:2] ** 2) @ X[:, :2].T
    exact = multivariate_normal(cov=covariance).logpdf(y) + 30.0 * np.log(2.0 * np.pi)
    assert found.evidence == pytest.approx(exact, rel=1e-12)
    assert found.heldout_error == pytest.approx(np.sqrt(-2.0 * found.heldout.sum() / 60))
    # in other units of the residual all of it is the same, but for the width that one row has less
    problem.whitener.log_scale[:] = 0.1
    scaled = problem.fitted(groups)
    assert scaled.evidence == pytest.approx(found.evidence - 6.0)
    assert scaled.heldout == pytest.approx(found.heldout - 2.0)


@pytest.mark.parametrize("misfit", [1.0, 3.0])
def test_what_is_held_out_is_scored_by_the_fit_that_hardly_knows_it(linear, misfit) -> None:
    """Foretold by one step where the model is nearly right, fitted where it is not; both exact if linear."""
    y = misfit * RNG.standard_normal(60)
    groups = np.repeat(np.arange(3.0), 20)
    problem = linear(y, X[:, :2], PRIOR[:2])
    A = X[:, :2].T @ X[:, :2] + np.diag(PRIOR[:2] ** -2.0)
    for number, score in enumerate(scores(problem, problem.solved(), A, groups)):
        rows = groups == number
        root = np.where(rows, np.sqrt(1.0 - HELD_OUT), 1.0)
        other = linear(root * y, root[:, None] * X[:, :2], PRIOR[:2]).solved()
        assert score == pytest.approx(-0.5 * np.sum((y - X[:, :2] @ other.u)[rows] ** 2), rel=1e-4)


def test_a_fit_is_made_where_the_step_foretells_much(linear, monkeypatch) -> None:
    """One step may lead far where a model bends: told -1e8 nats of one group, a fit has the word."""
    problem, groups = linear(RNG.standard_normal(60), X[:, :2], PRIOR[:2]), np.repeat(np.arange(3.0), 20)
    A = X[:, :2].T @ X[:, :2] + np.diag(PRIOR[:2] ** -2.0)
    told = scores(problem, problem.solved(), A, groups)
    step = candidate_fit._predicted_gain
    monkeypatch.setattr(
        candidate_fit, "_predicted_gain", lambda best, A, rows: -1e8 if rows[0] else step(best, A, rows)
    )
    assert scores(problem, problem.solved(), A, groups) == pytest.approx(told, rel=1e-4)
    assert scores(problem, problem.solved(), A, np.arange(60.0))[0] == -1e8  # too many folds to fit each


def test_the_gain_that_the_screen_foretells_is_that_of_the_refit_of_a_linear_model(
    linear, monkeypatch
) -> None:
    one = effect("adhesion")
    trial = {p.symbol: p.default if p.null is None else p.null for p in one.parameters} | {"pull": 0.15}
    amount = next(p for p in one.parameters if p.symbol == "pull")
    y = 0.4 * X[:, 2] + RNG.standard_normal(60)
    # the screen takes the optimum's gradient as nothing, which is so with the prior around the optimum
    y = y - X[:, :2] @ np.linalg.lstsq(X[:, :2], y, rcond=None)[0]
    problem = linear(y, X[:, :2], PRIOR[:2])
    optimum = problem.solved()
    candidate = Candidate(one, null(one), (trial,))
    changed = optimum.residual - X[:, 2]
    tried = SimpleNamespace(table=lambda *_: 0.0, raw=lambda table: table, white=lambda _: changed)
    monkeypatch.setattr(score_tests, "_groups", lambda *_: [(tried, [candidate])])
    (hint,) = screen_candidates(problem, optimum, [candidate])
    wide = np.append(PRIOR[:2], amount.std / 0.15)
    refit = linear(y, X, wide).solved()
    assert hint.gain == pytest.approx(optimum.cost - refit.cost, rel=1e-9)
    assert hint.multiple == pytest.approx(refit.u[2], rel=1e-9)
    held = linear(y, X[:, :2], PRIOR[:2])
    held.unknowns.high[0] = optimum.u[0]  # a parameter at its bound imitates as little as one that is known
    less = linear(y, X[:, 1:2], PRIOR[1:2])
    (bound,), (known,) = (
        screen_candidates(*one, [candidate])
        for one in (
            (held, optimum),
            (less, dataclasses.replace(optimum, u=optimum.u[1:], jacobian=-X[:, 1:2])),
        )
    )
    assert (bound.gain, bound.multiple) == pytest.approx((known.gain, known.multiple), rel=1e-9)
    tried.white = lambda _: optimum.residual
    assert screen_candidates(problem, optimum, [candidate]) == []


@pytest.mark.parametrize(
    ("pull", "std", "resolved"),
    [(0.31, 0.1, True), (0.29, 0.1, False), (0.0, 1e-9, False), (5.0, 3.0, False)],
)
def test_an_effect_is_resolved_where_an_amount_is_three_standard_errors_from_nothing(
    pull, std, resolved
) -> None:
    one = dataclasses.replace(effect("adhesion"), min_amounts={}, min_displacement_noises={})
    names = [p.symbol for p in one.parameters]
    known = [p.std if p.null is None or p.symbol != "pull" else std for p in one.parameters]
    unknowns = SimpleNamespace(names=names, std=np.full(len(names), 1e9))
    values = {p.symbol: p.default if p.null is None else p.null for p in one.parameters} | {"pull": pull}
    u = np.array([values[name] for name in names])
    fit = SimpleNamespace(
        problem=SimpleNamespace(unknowns=unknowns, depth=1e-3,
                                measured=SimpleNamespace(noise=SimpleNamespace(displacement=1e-6))),
        optimum=SimpleNamespace(u=u),
        information=np.diag(np.array(known) ** -2.0),
        value=values.__getitem__,
    )  # fmt: skip
    candidate = Candidate(one, null(one), ())
    at = names.index("pull")
    assert amount_covariance(candidate, fit)[at, at] == pytest.approx(std**2)
    assert is_resolved(candidate, fit) == resolved
    # nor is it where it is below what it must be at least, by itself or in noises of the displacement
    for more in ({"min_amounts": {"pull": pull}}, {"min_displacement_noises": {"pull": 1e3 * pull}}):
        assert not is_resolved(Candidate(dataclasses.replace(one, **more), null(one), ()), fit)
    less = {"min_amounts": {"pull": 0.9 * pull}, "min_displacement_noises": {"pull": 900.0 * pull}}
    assert is_resolved(Candidate(dataclasses.replace(one, **less), null(one), ()), fit) == resolved


@pytest.mark.parametrize(("along", "resolved"), [(4.0, True), (2.0, False)])
def test_amounts_that_stand_for_each_other_are_resolved_together(along, resolved) -> None:
    """A layer and its core: their sum is known to a tenth, their difference not at all."""
    one = effect("layer_over_core")
    names = [p.symbol for p in one.parameters]
    values = {"R_H": 0.05 * along, "K_c": 0.05 * along, "x_c": 1.0}
    J = np.array([[10.0, 10.0, 0.0], [0.1, -0.1, 0.0], [0.0, 0.0, 1.0]])
    fit = SimpleNamespace(
        problem=SimpleNamespace(
            unknowns=SimpleNamespace(names=names, std=np.full(3, 1e9)),
            depth=1e-3,
            measured=SimpleNamespace(noise=SimpleNamespace(displacement=1e-6)),
        ),
        optimum=SimpleNamespace(u=np.array([values[name] for name in names])),
        information=J.T @ J,
        value=values.__getitem__,
    )
    assert is_resolved(Candidate(one, null(one), ()), fit) == resolved


@pytest.mark.parametrize(
    ("zeros", "astray"), [((0.06, 0.0), True), ((0.0, -0.06), True), ((0.04, 0.01), False)]
)
def test_a_fit_is_astray_where_a_zero_of_the_displacement_has_moved_far(zeros, astray) -> None:
    names = ["K", "zero_displacement", "zero_displacement_2", "zero_normal_force"]
    fit = SimpleNamespace(
        problem=SimpleNamespace(unknowns=SimpleNamespace(names=names)),
        optimum=SimpleNamespace(u=np.array([7.0, *zeros, 9.0])),
    )
    assert _is_astray(fit) == astray


def test_knots_of_a_curve_span_its_rows_and_stand_where_they_are() -> None:
    x = np.r_[np.zeros(50), np.linspace(0.0, 0.1, 100), np.linspace(0.1, 1.0, 20)]
    knots = _knots(x, 20)
    assert (knots[0], knots[-1]) == (0.0, 1.0)
    assert 15 <= knots.size <= 22
    assert np.diff(knots).max() < 0.101  # evenly
    assert np.count_nonzero(knots < 0.1) > 5  # and dense
    assert np.diff(knots).min() > 0.2 / 20


def test_only_what_contends_is_fitted_to_the_end(monkeypatch) -> None:
    """From four tenths of what the best one gains; the others stay as they are."""
    gains = {"a": 100.0, "b": 40.1, "c": 39.9, "d": -5.0}
    bounds = []

    def extend(_, hint, __, least) -> SimpleNamespace:
        bounds.append(least)
        optimum = SimpleNamespace(is_given_up=False)
        return SimpleNamespace(evidence=gains[hint.candidate.name] - 7.0, error=1.0, optimum=optimum)

    monkeypatch.setattr(search, "extend_problem", extend)
    monkeypatch.setattr(
        search, "finish_fit", lambda _, rough, __: SimpleNamespace(evidence=rough.evidence + 1e3)
    )

    def bounds_of(names: str, error: float = 5.1) -> list[float]:
        base = SimpleNamespace(evidence=-7.0, error=error, optimum=SimpleNamespace(cost=1000.0))
        bounds.clear()
        hints = [SimpleNamespace(candidate=SimpleNamespace(name=name)) for name in names]
        fits = search._refitted(base, hints, None, 1)
        expected = {"a": 1093.0, "b": 1033.1, "c": 32.9, "d": -12.0}
        assert [one.evidence for one in fits] == pytest.approx([expected[name] for name in names])
        return bounds

    assert bounds_of("abcd") == [math.inf, 960.0, 960.0, 960.0]
    assert bounds_of("dcab") == [math.inf, 1000.0, pytest.approx(1000.0 - 0.4 * 39.9), 960.0]
    assert bounds_of("abcd", 4.9) == [math.inf] * 4  # near the noise all are fitted


@pytest.mark.parametrize(
    ("passing", "given_up", "again"), [("a", "bc", ""), ("b", "b", "b"), ("", "bc", "bc")]
)
def test_what_was_given_up_is_fitted_to_the_end_where_nothing_else_passes(
    monkeypatch, passing, given_up, again
) -> None:
    anew = []

    def fit(name: str, *, is_given_up: bool) -> SimpleNamespace:
        optimum = SimpleNamespace(is_given_up=is_given_up, residual=np.zeros(1))
        new = SimpleNamespace(name=name, optimum=optimum)
        new.without_derivatives = lambda: new
        return new

    def extend(_, hint, __, least) -> SimpleNamespace:
        assert least == 92.0
        anew.append(hint.candidate.name)
        return fit(hint.candidate.name, is_given_up=False)

    hints = [SimpleNamespace(candidate=SimpleNamespace(name=name, effect=None), gain=9.0) for name in "abc"]
    replaced = {
        "candidates": lambda *_: ([], {}),
        "screen_candidates": lambda *_: hints,
        "shortlist": lambda hints: hints,
        "required_evidence": lambda *_: SimpleNamespace(
            of=lambda *_, **__: 8.0, at_least=lambda _: 8.0, left=0.0
        ),
        "_refitted": lambda *_: [fit(name, is_given_up=name in given_up) for name in "abc"],
        "extend_problem": extend,
        "judge_candidate": lambda one, *_: Verdict(1.0, 1.0, () if one.name in passing else ("error",)),
    }
    for name, function in replaced.items():
        monkeypatch.setattr(search, name, function)
    base = SimpleNamespace(
        problem=SimpleNamespace(model=SimpleNamespace(values={}), measured=None),
        optimum=SimpleNamespace(residual=np.zeros(1), cost=100.0),
        error=9.0,
        whitened=lambda _: np.zeros(1),
    )
    found = SimpleNamespace(
        accepted=[], dropped=[], out_of_sight={}, steps=[], misfit=lambda _: 1.0, leaves_noise=lambda _: True
    )
    step = search._step(base, None, found, 1, lambda _: None)
    assert "".join(anew) == again
    assert sorted(one.candidate.name for one in step.tried) == ["a", "b", "c"]
    assert all(not one.fitted.optimum.is_given_up for one in step.tried) == bool(again)


@pytest.mark.parametrize(("cost", "steps"), [(901.0, []), (899.0, [40])])
def test_the_last_steps_of_a_fit_far_from_the_base_are_made_anew(cost, steps, monkeypatch) -> None:
    taken = []
    monkeypatch.setattr(candidate_fit, "evaluate_candidate", lambda _, optimum, __: optimum)
    monkeypatch.setattr(candidate_fit, "refine_optimum", lambda _, u, count, **__: taken.append((u, count)))
    rough = SimpleNamespace(problem=None, optimum=SimpleNamespace(cost=cost, u="here"))
    found = candidate_fit.finish_fit(SimpleNamespace(optimum=SimpleNamespace(cost=1000.0)), rough, None)
    assert taken == [("here", count) for count in steps]
    assert (found is rough) == (not steps)


@pytest.mark.parametrize(
    ("name", "amounts"),
    [("adhesion", {"pull": 0.15}), ("rate_dependent_friction", {"r_mu": 0.6}), ("adhesion", {"neck": 0.7})],
)
def test_the_prior_counts_how_far_an_amount_is_from_nothing(name, amounts) -> None:
    """In standard deviations; what only shapes an effect, or is absent, costs nothing."""
    one = effect(name)
    trial = {p.symbol: p.default if p.null is None else p.null for p in one.parameters} | amounts
    known = {p.symbol: p for p in one.parameters if p.symbol in amounts and p.null is not None}
    far = [
        np.log(amounts[n] / p.null) if p.transform == "log" else amounts[n] - p.null for n, p in known.items()
    ]
    expected = sum((one / p.std) ** 2 for one, p in zip(far, known.values(), strict=True))
    assert score_tests._prior(Candidate(one, null(one), ()), trial) == pytest.approx(expected)


def test_a_step_of_the_screen_starts_a_refit_within_the_bounds_and_from_what_is_there() -> None:
    """From the multiple that the screen asks for, no less than a fiftieth and no more than thirty times."""
    one = effect("adhesion")
    names = ("K", *(p.symbol for p in one.parameters))
    k = SimpleNamespace(names=names, start=np.full(len(names), 9.0))
    known = SimpleNamespace(problem=SimpleNamespace(unknowns=SimpleNamespace(names=("p", "K"))),
                            optimum=SimpleNamespace(u=np.array([1.0, 0.7])))  # fmt: skip
    trial = null(one) | {"pull": 0.05, "neck": 0.3}
    for multiple, factor, pull in [
        (2.0, 1.0, 0.1),
        (2.0, 0.3, 0.03),
        (1e-9, 1.0, 0.001),
        (99.0, 1.0, 1.5),
        (-2.0, 1.0, 1e-3 * 0.1),  # as near to its bound as a thousandth of two standard deviations
    ]:
        hint = Hint(Candidate(one, null(one), (trial,)), 9.0, trial, multiple, np.zeros(1))
        u = candidate_fit._start(SimpleNamespace(unknowns=k), known, hint, factor)
        told = dict(zip(names, u, strict=True))
        assert told["K"] == 0.7
        assert told["pull"] == pytest.approx(pull)
        assert told["neck"] == pytest.approx(np.log(0.3))
    assert u[names.index("n_v")] == pytest.approx(0.5)
    declared = candidate_fit._as_declared(hint)
    assert (declared.multiple, declared.trial["neck"], declared.trial["pull"]) == (1.0, 0.2, 0.05)


@pytest.mark.parametrize(
    ("name", "astray", "costs", "starts", "best"),
    [
        ("inertia", False, [50.0], [1.0], 50.0),  # half of what is foretold is there
        ("inertia", False, [56.0, 54.0], [1.0, 0.3], 54.0),
        ("inertia", False, [54.0, 56.0], [1.0], 54.0),
        ("inertia", False, [70.0, 60.0], [1.0, 0.3], 60.0),
        ("inertia", False, [101.0, 102.0, 99.0], [1.0, 0.3, 0.01], 99.0),  # led astray
        ("inertia", True, [50.0, 40.0], [1.0, "unshifted"], 40.0),
        ("adhesion", False, [50.0, 45.0], [1.0, "declared"], 45.0),  # its shape may have a better place
        ("adhesion", False, [50.0, 55.0], [1.0, "declared"], 50.0),
    ],
)
def test_a_refit_is_tried_from_other_starts_where_the_first_leads_nowhere(
    monkeypatch, name, astray, costs, starts, best
) -> None:
    """The base costs 100 and the screen foretells a gain of 90."""
    one, left, seen = effect(name), list(costs), []
    trial = null(one)
    hint = Hint(Candidate(one, trial, (trial,)), 90.0, trial, 3.0, np.zeros(1))
    base = SimpleNamespace(
        problem=SimpleNamespace(unknowns=SimpleNamespace(names=("K",))),
        optimum=SimpleNamespace(cost=100.0, jacobian=np.ones((3, 1))),
    )

    def refine(_problem, start, evaluations, known, near, least):
        assert least == min([math.inf, *costs[: len(seen)]])  # another start has to lead lower
        seen.append(start)
        assert near == pytest.approx(0.02)
        assert evaluations == (40 if start in ("unshifted", 0.01) else 20)
        assert (known is None) == (start == "unshifted")
        return SimpleNamespace(cost=left.pop(0), u=start)

    monkeypatch.setattr(candidate_fit, "_problem", lambda *_: SimpleNamespace(model=None))
    monkeypatch.setattr(
        candidate_fit, "_start", lambda _, __, h, factor: "declared" if h.multiple == 1.0 else factor
    )
    monkeypatch.setattr(candidate_fit, "_unshifted", lambda *_: "unshifted")
    monkeypatch.setattr(candidate_fit, "_is_astray", lambda _: astray)
    monkeypatch.setattr(candidate_fit, "has_play", lambda _: False)
    monkeypatch.setattr(candidate_fit, "refine_optimum", refine)
    monkeypatch.setattr(candidate_fit, "evaluate_candidate", lambda _, optimum, __: optimum)
    assert candidate_fit.extend_problem(base, hint, None).cost == best
    assert seen == starts


@pytest.mark.parametrize(
    ("episodes", "groups"),
    [
        (np.repeat([0, 1, 2], 20), np.repeat([0.0, 1.0, 2.0], 20)),
        (np.repeat([0, 1], 30), np.repeat(np.arange(10.0), 6)),
        (np.zeros(60, int), np.repeat(np.arange(10.0), 6)),
    ],
)
def test_episodes_are_held_out_or_tenths_of_what_has_too_few(episodes, groups) -> None:
    rows = np.r_[np.arange(60), 7, 59]
    told = candidate_fit.held_out_groups(SimpleNamespace(episodes=episodes, rows=rows))
    assert told.tolist() == groups[rows].tolist()


def test_a_regime_is_a_phase_a_depth_a_time_in_contact_a_half_and_a_channel(monkeypatch) -> None:
    rng, n = np.random.default_rng(3), 400
    depth, contact = rng.uniform(0.0, 1e-3, n), rng.choice([0.1, 0.29, 0.31, 1.4, 1.6, 9.0], n)
    depth[0], phase, episodes = 1e-3, rng.integers(0, 6, n), np.arange(n) // 100
    features = SimpleNamespace(phase=phase, values={"indentation": depth, "time_in_contact": contact})
    monkeypatch.setattr(candidate_fit, "features_of", lambda *_: features)
    sliding, seen = np.arange(0, n, 4), np.arange(0, n, 5)
    counted = np.ones(n + 180, bool)
    counted[::7] = False
    problem = SimpleNamespace(
        table=lambda _: None,
        episodes=episodes,
        rows=np.r_[np.arange(n), sliding, seen],
        measured=SimpleNamespace(recording=range(n), sliding=sliding, seen=seen),
        counted=counted,
    )
    told = candidate_fit.regime_map(problem, None)
    assert np.all((told == -1.0) == ~counted)
    edges = np.array([0.25, 0.5, 0.75]) * 0.93e-3
    rows, block = problem.rows, np.repeat([0, 1, 2], [n, 100, 80])
    late = (contact[:, None] > [0.3, 1.5]).sum(axis=1)
    deep = (depth[:, None] > edges).sum(axis=1)
    expected = list(zip(phase[rows], deep[rows], late[rows], episodes[rows] >= 2, block, strict=True))
    by_number = {}
    for number, one, is_counted in zip(told, expected, counted, strict=True):
        if is_counted:
            by_number.setdefault(number, set()).add(one)
    assert all(len(ones) == 1 for ones in by_number.values())
    assert len(by_number) == len({one for one, kept in zip(expected, counted, strict=True) if kept})


@pytest.mark.parametrize(
    ("columns", "name", "reason"),
    [
        ({}, "temperature_shift", "no temperature was recorded"),
        ({"temperature": 20.0 + 0.29 * np.tile([1.0, -1.0], 9)}, "temperature_shift", "hardly changed"),
        ({"temperature": 20.0 + 0.31 * np.tile([1.0, -1.0], 9)}, "temperature_shift", ""),
        ({}, "cross_talk", "no tangential force was recorded"),
        ({"tangential_force_y": np.ones(18)}, "cross_talk", ""),
    ],
)
def test_an_effect_needs_the_channel_it_takes(columns, name, reason) -> None:
    measured = SimpleNamespace(
        recording=SimpleNamespace(columns=columns), sliding=np.ones(1), seen=np.ones(1)
    )
    told = why_unseen(effect(name), measured)
    assert reason in told
    assert bool(told) == bool(reason)


@pytest.mark.parametrize(
    ("deepest", "told"), [(-1e-2, ""), (-1e-5, "hardly moves in the air"), (1e-3, "hardly")]
)
def test_friction_of_the_guide_is_looked_for_where_the_drive_moves_in_the_air(tip, deepest, told) -> None:
    measured = fit(tip(5, kinds=("hold",))).problem.measured
    depth = np.linspace(0.0, deepest, len(measured.recording))
    columns = {**measured.recording.columns, "displacement": depth}
    moved = dataclasses.replace(measured, recording=dataclasses.replace(measured.recording, columns=columns))
    said = why_unseen(effect("guide_friction"), moved)
    assert told in said
    assert bool(told) == bool(said)


def declared_as(**given):
    return Parameter(
        **{"symbol": "a", "unit": "1", "default": 0.2, "std": 0.5, "low": 0.0, "high": 9.0, "doc": ""} | given
    )


def test_an_effect_is_tried_at_each_amount_and_over_its_shapes() -> None:
    amount = declared_as(null=0.0)
    rate = declared_as(symbol="r", default=2.0, low=0.1, transform="log")
    other = declared_as(symbol="q", default=3.0, low=0.1, transform="log")
    plain = declared_as(symbol="s", default=1.0)

    def tried(*parameters, **more):
        return list(trials(Effect("mine", "", (), (), parameters=parameters, **more)))

    assert tried(amount) == [{"a": 0.2}]
    assert tried(amount, trial_sizes=(1.0, 60.0)) == [{"a": 0.2}, {"a": 9.0}]
    assert tried(declared_as(null=0.2, default=0.2)) == [{"a": 0.7}]  # a deviation from nothing
    assert tried(declared_as(null=0.2, default=0.2, high=0.5)) == [{"a": 0.5}]
    five = [one["r"] for one in tried(amount, rate)]
    assert five == pytest.approx(2.0 * np.exp(0.5 * np.array([-3.0, -1.5, 0.0, 1.5, 3.0])))
    nine = {(one["r"], one["q"]) for one in tried(amount, rate, other, plain)}
    assert len(nine) == 9
    assert max(nine) == pytest.approx((2.0 * np.e, 3.0 * np.e))
    assert [one["s"] for one in tried(amount, plain)] == pytest.approx([0.0, 0.25, 1.0, 1.75, 2.5])
    assert [one["s"] for one in tried(amount, plain, trial_shapes=(("s", (4.0, 5.0)),))] == [4.0, 5.0]


def test_a_fit_that_is_kept_without_derivatives_is_judged_as_with_them(small) -> None:
    """Those of the optimum are taken anew, at the cost of a run of the model for each unknown."""
    whole = small.search.steps[0].base
    lean = whole.without_derivatives()
    assert lean.optimum.jacobian.nbytes == 0
    assert (lean.information == whole.information).all()
    again = dataclasses.replace(lean)  # without what was computed before
    scale = np.sqrt(np.diag(whole.information))
    assert again.complete.jacobian / scale == pytest.approx(whole.optimum.jacobian / scale, abs=1e-3)
    assert again.heldout == pytest.approx(whole.heldout, abs=0.1)  # [nats]
    assert again.information / np.outer(scale, scale) == pytest.approx(
        whole.information / np.outer(scale, scale), abs=5e-3
    )


def test_the_screen_points_where_a_refit_ends(small) -> None:
    """Its gain is half the fall of the squares by one column more, the prior of its amount beside it."""
    step = small.search.steps[0]
    hint = next(one for one in step.hints if one.candidate.name == "adhesion")
    base, rows = step.base, step.base.optimum.residual.size
    J, std = base.optimum.jacobian, base.problem.unknowns.std
    wide = np.vstack([J, np.diag(1.0 / std)])
    within = score_tests.widened(base.problem, [hint.candidate])
    s = within.white(within.raw(within.table(base.optimum.u, hint.trial))) - base.optimum.residual
    padded = np.append(s, np.zeros(std.size))
    p = padded - wide @ np.linalg.lstsq(wide, padded, rcond=None)[0]
    asked = sum(
        (hint.trial[q.symbol] / q.std) ** 2 for q in hint.candidate.effect.parameters if q.null is not None
    )
    along = p[:rows] @ base.optimum.residual
    assert hint.multiple == pytest.approx(-along / (p @ p + asked), rel=1e-6)
    assert hint.gain == pytest.approx(0.5 * along**2 / (p @ p + asked), rel=1e-6)
    assert hint.signature == pytest.approx(p[:rows] / np.sqrt(p @ p), abs=1e-6)
    assert [one.gain for one in step.hints] == sorted((one.gain for one in step.hints), reverse=True)


@pytest.mark.parametrize(
    ("gains", "change", "told"),
    [
        ({}, None, None),
        ({"time": 20.0}, None, None),
        ({"time": 20.5, "speed": 12.0}, None, ("time", "normal_force", 20.5, "")),
        ({"time": 21.0, "times": 22.0}, None, ("time", "normal_force", 22.0, "normal_force")),
        ({"time": 21.0, "speed": 30.0}, 30.0, ("speed", "normal_force", 30.0, "")),
        ({"time": 21.0, "speed": 30.0}, 31.0, ("time", "normal_force", 31.0, "")),
        ({"time": 21.0, "slip": 30.0}, None, ("speed", "tangential_force", 30.0, "")),
    ],
)
def test_the_variable_with_most_evidence_is_told_and_a_change_where_it_has_more(
    monkeypatch, gains, change, told
) -> None:
    """A stiffness that changes is looked for over what is slow, on rows of which there are enough."""
    n, values = 100, {"time": np.arange(120.0), "speed": np.arange(120.0)[::-1], "contact": np.ones(120)}
    loads = np.full(120, 3.0)
    rows = {"normal_force": np.arange(n), "tangential_force": np.arange(20), "contact_radius": np.arange(19)}
    looked = []

    def curve(w, _J, _prior, B, knots):
        assert w.size == B.shape[0] == (n if w[0] == 0.0 else 20)
        assert knots.size <= (w.size // 5) + 2
        name = "time" if B[0, 0] > 0.0 else "speed"
        if w[0] != 0.0:
            name = "slip" if name == "speed" else "none"
        name += "s" if B.max() == 3.0 else ""
        looked.append(name)
        return gains.get(name, -1.0), 0.5, np.zeros(knots.size)

    def blocks(_):
        yield "normal_force", rows["normal_force"], slice(0, 100)
        yield "tangential_force", rows["tangential_force"], slice(100, 120)
        yield "contact_radius", rows["contact_radius"], slice(120, 139)

    residual = np.repeat([0.0, 1.0, 2.0], [100, 20, 19])
    fitted = SimpleNamespace(
        problem=SimpleNamespace(
            table=lambda _: None,
            unknowns=SimpleNamespace(std=np.ones(1), prior=0.0),
            measured=SimpleNamespace(recording=SimpleNamespace(is_step=False)),
        ),
        optimum=SimpleNamespace(u=np.zeros(1), residual=residual, jacobian=np.ones((139, 1))),
    )
    monkeypatch.setattr(
        discrepancy, "features_of", lambda *_: SimpleNamespace(values={"normal_force": loads[:100]})
    )
    monkeypatch.setattr(discrepancy, "_blocks", blocks)
    monkeypatch.setattr(
        discrepancy, "_variables", lambda _, __, ___, at, ____: [(k, v[at]) for k, v in values.items()]
    )
    monkeypatch.setattr(discrepancy, "_whitened", lambda _, B, *__: B)
    monkeypatch.setattr(discrepancy, "_curve", curve)
    place = None if change is None else SimpleNamespace(gain=change, variable="time")
    monkeypatch.setattr(discrepancy, "find_change", lambda *_: place)
    found = find_discrepancy(fitted, with_changes=True)
    assert looked == ["time", "times", "speed", "none", "slip"]
    if told is None:
        assert found is None
        return
    assert (found.variable, found.channel, found.gain, found.times) == told
    assert (found.change is None) == (change is None or change == 30.0)
    assert set(found.others) == {"time", "speed"} - {found.variable}


@pytest.mark.parametrize(
    ("plain", "expensive", "mode", "rows", "carried"),
    [
        (True, False, "c", 20_000, False),
        (True, True, "c", 20_000, False),
        (False, True, "c", 20_000, False),
        (False, False, "c", 20_000, True),
        (False, False, "c", 20_001, False),
        (False, False, "numba", 20_001, True),
    ],
)
def test_a_candidate_runs_in_the_model_that_has_everything_beside_others_alone(
    monkeypatch, plain, expensive, mode, rows, carried
) -> None:
    """What slows that down, or stands beside the plain model, runs in a model of its own.

    So does what has many rows to run, where a model is compiled quickly.
    """
    model = paper_model(8e-3) if plain else paper_model(8e-3).with_effect(effect("inertia"))
    one = dataclasses.replace(effect("adhesion"), expensive=expensive)
    measured = SimpleNamespace(recording=range(rows))
    problem = SimpleNamespace(model=model, measured=measured, zeros="recording", symbols=("K", "p"))
    monkeypatch.setattr(candidate_fit, "carrier", lambda *_: "carrier")
    monkeypatch.setattr(candidate_fit, "kernel_mode", lambda: mode)
    monkeypatch.setattr(
        candidate_fit, "Problem", lambda model, _, **given: SimpleNamespace(model=model, **given)
    )
    made = candidate_fit._problem(SimpleNamespace(problem=problem), Candidate(one, null(one), ()))
    assert made.within == ("carrier" if carried else None)
    assert made.symbols == ("K", "p", *(p.symbol for p in one.parameters))
    assert made.like is problem
    assert "adhesion" in {each.name for each in made.model.effects}


@pytest.mark.parametrize(("scatter", "counts"), [(0.19, False), (0.21, True)])
def test_a_curve_over_temperature_and_those_of_slip_are_looked_for_where_they_are_measured(
    scatter, counts
) -> None:
    t, ones = np.arange(6.0), np.ones(6)
    warm = 20.0 + scatter * np.tile([1.0, -1.0], 3)
    slip = np.array([0.0, 1e-4, -1e-3, np.nan, 0.0, 0.0])
    problem = SimpleNamespace(
        measured=SimpleNamespace(recording=SimpleNamespace(t=t, is_step=False, columns={"slip_speed": slip})),
        stiffness=ones, episodes=np.zeros(6), depth=1e-3,
    )  # fmt: skip
    values = dict.fromkeys(("normal_force", "time_in_contact", "time", "tangential_force"), ones)
    features = SimpleNamespace(values=values | {"temperature": warm, "indentation": 1e-4 * t})
    table = np.zeros((6, len(AT)))
    table[:, AT["torque_z"]], table[:, AT["tangential_force"]] = -2e-3, -0.5
    table[:, AT["contact_radius"]] = 4e-3
    told = dict(_variables(problem, features, table, np.array([0, 1, 2, 3]), "tangential_force"))
    assert ("temperature" in told) == counts
    assert told["torque_share"] == pytest.approx(np.full(4, 0.25 * np.pi))  # half a newton each
    assert told["slip_speed"] == pytest.approx(np.log10([1e-3, 0.101, 1.001, 1e-3]))
    force = dict(_variables(problem, features, table, np.arange(4), "normal_force"))
    assert not {"slip_speed", "torque_share"} & set(force)


def test_what_was_accepted_is_told_in_si(small) -> None:
    told = small.in_si()
    assert set(told) == {"pull", "neck"}
    assert told["pull"] == (pytest.approx(0.06, rel=0.2), "N")
    assert told["neck"][1] == "m"
    shown = small.result.as_dict()["parameters"]["pull"]
    K, share = small.result.std["K"], shown["std"] / shown["value"]
    assert shown["si"]["value"] == pytest.approx(told["pull"][0])
    assert abs(share - K) <= shown["si"]["std"] / shown["si"]["value"] <= share + K


def test_what_acts_in_the_air_is_not_named_for_the_form_of_a_law_of_the_contact(tip) -> None:
    """The neck of the bench is another than ours: what it leaves is straight in the depth, but not in air."""
    found = diagnose(tip(13, kinds=("hold", "ramp", "hold"), pull=0.1))
    assert found.named == ["adhesion"]
    tried = {one["name"]: one["failed"] for one in found.rounds if one["round"] == 2}
    assert "air" in tried["approach_tilt"]


@pytest.mark.parametrize(
    ("gain", "failed", "says"), [(38.0, ("evidence",), True), (12.0, ("evidence",), False), (38.0, (), False)]
)
def test_a_lag_that_gains_too_little_to_be_named_is_said(gain, failed, says) -> None:
    lag, other = effect("sensor_lag"), effect("rate_stiffening")
    fitted = SimpleNamespace(value={"tau": 0.0123}.__getitem__)
    tried = [
        SimpleNamespace(
            candidate=Candidate(one, null(one), ()), verdict=Verdict(gain, 0.0, failed), fitted=fitted
        )
        for one in (other, lag)
    ]
    doubts = doubt_timing(SimpleNamespace(steps=[None, SimpleNamespace(tried=tried)]))
    assert [("12 ms late" in one.text, one.is_grave) for one in doubts] == [(True, False)] * says


@pytest.mark.parametrize(("failed", "says"), [((FORM,), True), (("evidence", FORM), False), ((), False)])
def test_what_fails_only_by_the_form_of_what_is_accepted_is_said(failed, says) -> None:
    one, taken = (SimpleNamespace(name=name) for name in ("friction_ageing", "cross_talk"))
    tried = [SimpleNamespace(candidate=one, verdict=Verdict(218.1, 233.7, failed))]
    found = SimpleNamespace(
        steps=[None, SimpleNamespace(tried=tried)], accepted=[SimpleNamespace(candidate=taken)]
    )
    said = [one.text for one in doubt_form(found)]
    assert len(said) == says
    assert all("friction_ageing would gain 218 nats beside cross_talk" in text for text in said)


def test_what_another_form_of_an_accepted_effect_gains_is_no_gain(linear) -> None:
    """A change along a direction that accepted effects may have anyhow leaves nothing to be gained."""
    y = 3.0 * X[:, 2]
    problem = linear(y, X[:, :2], PRIOR[:2])
    base = SimpleNamespace(optimum=problem.solved())
    new = SimpleNamespace(optimum=SimpleNamespace(residual=base.optimum.residual - 3.0 * X[:, 2]))
    base.whitened = lambda other: other.optimum.residual
    basis, _ = np.linalg.qr(X[:, :2])
    alone = gain_beside(base, new, basis)
    assert alone == pytest.approx(0.5 * np.sum((y - basis @ (basis.T @ y)) ** 2), rel=1e-2)
    assert gain_beside(base, new, np.linalg.qr(X[:, :3])[0]) == pytest.approx(0.0, abs=1e-6)
    # with a prior: a form that would have to act sixty times as much explains nothing
    of_std = {
        std: np.linalg.qr(np.vstack([X[:, :3], np.diag([0.0, 0.0, 1.0 / std])]))[0] for std in (0.05, 1e3)
    }
    assert gain_beside(base, new, of_std[0.05]) > 0.8 * alone
    assert gain_beside(base, new, of_std[1e3]) < 0.01 * alone
