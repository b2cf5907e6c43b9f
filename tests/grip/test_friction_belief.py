"""The belief of the grasp is a joint Gaussian: against dense algebra, and what it must and must not do."""

import math

import numpy as np
import pytest

from vegrip.grip.friction_belief import (
    absorb_evidence,
    absorb_factor,
    begin_belief,
    believed_variance,
    expect_finger,
    widen_belief,
)
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory
from vegrip.types import Floats

LN_MU, STD, OWN = math.log(0.7), 0.4, 0.08


def belief(fingers: int = 5, drift: float = 0.03, shock: float = 0.08) -> GraspMemory:
    g = GraspMemory()
    begin_belief(g, fingers, drift, shock)
    for i in range(fingers):
        expect_finger(g, i, LN_MU, STD, OWN)
    return g


def mean(g: GraspMemory, n: int = 5) -> Floats:
    return np.array(g.belief.mean[:n])


def covariance(g: GraspMemory, n: int = 5) -> Floats:
    P: Floats = np.array(g.belief.p).reshape(BELIEF_MOST, BELIEF_MOST)[:n, :n]
    return P


def dense_update(x: Floats, P: Floats, i: int, y: float, R: float) -> tuple[Floats, Floats]:
    h = np.zeros(len(x))
    h[i] = 1.0
    K = P @ h / (h @ P @ h + R)
    A = np.eye(len(x)) - np.outer(K, h)
    return x + K * (y - x[i]), A @ P @ A.T + R * np.outer(K, K)


def test_the_prior_is_common_to_all_but_for_what_is_each_ones_own() -> None:
    P = covariance(belief())
    assert np.allclose(np.diag(P), STD**2)
    assert np.allclose(P[0, 1:], STD**2 - OWN**2)


def test_factors_are_kalman_updates_of_the_whole_vector() -> None:
    g, rng = belief(), np.random.default_rng(0)
    x, P = mean(g), covariance(g)
    for _ in range(30):
        i, y, R = int(rng.integers(5)), float(rng.normal(-0.5, 0.3)), float(rng.uniform(1e-3, 0.1))
        x, P = dense_update(x, P, i, y, R)
        absorb_factor(g, i, 1.0 / R, y / R)
        assert np.allclose(mean(g), x)
        assert np.allclose(covariance(g), P)
    assert np.all(np.linalg.eigvalsh(covariance(g)) > 0.0)


def test_a_factor_is_taken_back_by_its_inverse() -> None:
    g = belief()
    absorb_factor(g, 1, 50.0, -40.0)
    before, P = mean(g), covariance(g)
    absorb_factor(g, 3, 20.0, -5.0)
    absorb_factor(g, 3, -20.0, 5.0)
    assert np.allclose(mean(g), before)
    assert np.allclose(covariance(g), P)


def test_a_factor_that_would_leave_no_variance_changes_nothing() -> None:
    g = belief()
    kept = list(g.array)
    for precision, weighted in ((-1e3, 0.0), (-1.0 / STD**2, 0.0), (1.0, math.inf), (math.nan, 0.0)):
        absorb_factor(g, 0, precision, weighted)
        assert list(g.array) == kept


def test_one_fingers_slip_lowers_what_every_finger_counts_on() -> None:
    g = belief()
    before = mean(g) - 0.7 * np.sqrt(np.diag(covariance(g)))
    variance = 0.004 * STD**2 / (0.004 + STD**2)
    off = STD**2 / (STD**2 + 0.004) * (math.log(0.3) - LN_MU)
    absorb_evidence(g, 2, LN_MU, STD**2, LN_MU + off, variance)
    after = mean(g) - 0.7 * np.sqrt(np.diag(covariance(g)))
    assert np.all(mean(g) < LN_MU - 0.5)
    assert np.all(after < before)
    assert believed_variance(g, 2) < believed_variance(g, 0) < 0.2**2


def test_a_slip_far_below_what_is_known_is_common_to_all_faces() -> None:
    """Wet faces: what one finger finds far below moves the others nearly as much as itself."""

    def fall(shock: float) -> Floats:
        g = belief(shock=shock)
        for i in range(5):
            absorb_factor(g, i, 1.0 / 0.03**2, LN_MU / 0.03**2)
        start = mean(g)
        absorb_evidence(g, 0, LN_MU, 0.001, LN_MU - 0.4, 0.0005)
        return start - mean(g)

    with_shock, without = fall(0.2), fall(0.0)
    assert np.all(with_shock > without)
    assert np.all(with_shock[1:] > 0.7 * with_shock[0])


def test_forgetting_widens_with_time_and_never_beyond_the_prior() -> None:
    g = belief()
    absorb_factor(g, 0, 1e3, 1e3 * LN_MU)
    known = believed_variance(g, 0)
    g.belief.since = 4.0
    widen_belief(g)
    assert believed_variance(g, 0) == pytest.approx(known + 0.03**2 * 4.0)
    g.belief.since = 1e9
    widen_belief(g)
    assert np.all(np.diag(covariance(g)) <= STD**2 + 1e-12)
    assert np.all(np.linalg.eigvalsh(covariance(g)) > -1e-12)


def test_what_is_no_evidence_changes_nothing() -> None:
    g = belief()
    kept = list(g.array)
    absorb_evidence(g, 0, LN_MU, 0.0, -1.0, 0.1)
    absorb_evidence(g, 0, LN_MU, 0.1, -1.0, math.nan)
    assert list(g.array) == kept


def test_a_slip_counts_for_no_more_than_one_at_four_standard_deviations() -> None:
    """However far below it lies; its precision is that of 0.05 in ln mu."""

    def fall(u: float) -> float:
        g = belief()
        prior, noise = STD**2, 0.05**2
        variance = prior * noise / (prior + noise)
        absorb_evidence(g, 0, LN_MU, prior, variance * (LN_MU / prior + math.log(u) / noise), variance)
        return LN_MU - g.belief.mean[0]

    assert fall(1e-9) == pytest.approx(fall(1e-6))
    assert fall(1e-6) < 4.0 * math.hypot(STD, 0.05)
    assert fall(0.6) < fall(0.4) < fall(1e-6)


def test_a_slip_of_a_light_touch_teaches_nothing() -> None:
    g = belief()
    prior, noise = STD**2, 0.4**2
    variance = prior * noise / (prior + noise)
    absorb_evidence(g, 0, LN_MU, prior, variance * (LN_MU / prior + math.log(0.1) / noise), variance)
    assert np.allclose(mean(g), LN_MU)
    assert np.allclose(np.diag(covariance(g)), prior)
