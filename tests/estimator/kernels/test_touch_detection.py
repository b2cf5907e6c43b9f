"""The touch is felt by a cumulative sum, and bounds where the zero can be."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.stats import norm, truncnorm


@pytest.mark.parametrize("a", [-6.0, -1.0, 0.0, 2.5, 7.9, 8.1, 20.0])
def test_the_mean_above_a_bound_is_that_of_the_truncated_normal(kernels, a) -> None:
    assert kernels.truncated_mean(a) == pytest.approx(
        math.exp(norm.logpdf(a) - norm.logsf(a)), rel=1e-4 if a > 8.0 else 1e-9
    )


@pytest.mark.parametrize("unit", [1.0, 1e-5])
def test_a_zero_that_is_moved_takes_along_what_is_correlated_with_it(kernels, m, P, rng, unit) -> None:
    A = unit * rng.standard_normal((kernels.N, kernels.N))
    P[:] = A @ A.T
    before, j = P.copy(), kernels.OFFSET
    y = m[kernels.Y0 : kernels.Y0 + kernels.N].copy()
    mean, variance = y[j] + 0.3, 0.25 * P[j, j]
    kernels.move_zero(m, mean, variance)
    gain = before[:, j] / before[j, j]
    assert_allclose(m[kernels.Y0 : kernels.Y0 + kernels.N], y + gain * 0.3, atol=1e-12)
    assert_allclose(P, before + np.outer(gain, gain) * (variance - before[j, j]), atol=1e-9 * unit**2)
    assert P[j, j] == pytest.approx(variance)


@pytest.mark.parametrize(("before", "variance"), [(0.0, 1.0), (1.0, 0.0), (1.0, -1.0)])
def test_a_zero_that_is_known_or_would_have_no_variance_stays(kernels, m, P, before, variance) -> None:
    P[kernels.OFFSET, kernels.OFFSET] = before
    kept = m.copy()
    kernels.move_zero(m, 1.0, variance)
    assert_allclose(m, kept)


def feel(kernels, m, excesses):
    """Let samples come whose force is so many standard deviations above zero."""
    bias = kernels.BIAS
    std = math.sqrt(m[kernels.SET_R_FORCE] + m[kernels.P0 + bias * kernels.N + bias])
    told = []
    for excess in excesses:
        kernels.detect_touch(m, m[kernels.Y0 + bias] + excess * std, math.nan)
        told.append((m[kernels.MODE_TOUCH], m[kernels.MODE_FELT]))
    return told


def test_a_touch_is_felt_by_three_samples_and_lost_after_some_without(kernels, m) -> None:
    m[kernels.MODE_TOUCH] = m[kernels.MODE_FELT] = 0.0
    told = feel(kernels, m, [100.0, 3.0, 100.0, 100.0, 100.0, 100.0])
    assert told == [(3.0, 0.0), (5.0, 0.0), (8.0, 1.0), (11.0, 1.0), (12.0, 1.0), (12.0, 1.0)]
    told = feel(kernels, m, [0.0, -100.0, -100.0, -100.0, -100.0])
    assert told == [(11.0, 1.0), (8.0, 1.0), (5.0, 1.0), (2.0, 1.0), (0.0, 0.0)]
    assert feel(kernels, m, [100.0, 100.0]) == [(3.0, 0.0), (6.0, 1.0)]
    m[kernels.MODE_TOUCH] = 3.5
    assert feel(kernels, m, [-100.0]) == [(0.5, 1.0)]


def test_zeros_are_excluded_until_a_contact_was_felt_and_nothing_is_felt_without_a_displacement(
    kernels, m, monkeypatch
) -> None:
    asked, zero = [], m[kernels.Y0 + kernels.BIAS]
    monkeypatch.setattr(kernels, "exclude_zeros", lambda _m, *given: asked.append(given))
    m[kernels.MODE_TOUCH] = 0.0
    for met, displacement in ((0.0, 1e-3), (1.0, 2e-3), (0.0, math.nan)):
        m[kernels.MODE_MET] = met
        kernels.detect_touch(m, zero, displacement)
    assert asked == [(-1.0, 1e-3)]  # a force of nothing lacks one standard deviation
    m[kernels.MODE_BLIND] = 1.0
    kept = m.copy()
    kernels.detect_touch(m, zero + 1.0, 1e-3)
    assert np.array_equal(m, kept)


def test_a_force_of_the_noise_alone_is_no_touch_and_a_missing_one_changes_nothing(kernels, m) -> None:
    m[kernels.MODE_TOUCH] = m[kernels.MODE_FELT] = 0.0
    feel(kernels, m, np.random.default_rng(0).standard_normal(20000))
    assert m[kernels.MODE_FELT] == 0.0
    kept = m.copy()
    kernels.detect_touch(m, math.nan, 1e-3)
    assert_allclose(m, kept)


def test_the_unseen_depth_has_a_force_of_three_standard_deviations_in_the_softest_tip(kernels, m) -> None:
    first = kernels.LEARNED_FROM
    m[kernels.P0 + first * kernels.N + first] = 0.05**2  # so wide that softer differs from stiffer
    depth, at = kernels.unseen_depth(m), kernels.TRIED0 + kernels.DELTA
    kernels.copy_state(m)

    def force(x):
        m[at] = x
        return kernels.contact(m, kernels.TRIED0)[3]

    threshold = 3.0 * math.sqrt(m[kernels.SET_R_FORCE])
    here = brentq(lambda x: force(x) - threshold, 0.0, 2e-3)
    shares = []
    for j in range(kernels.LEARNED_FROM, kernels.M):
        keep = m[kernels.TRIED0 + j]
        m[kernels.TRIED0 + j] = keep + 2.0 * math.sqrt(m[kernels.P0 + j * kernels.N + j])
        shares.append(force(here) / threshold - 1.0)
        m[kernels.TRIED0 + j] = keep
    assert 0.05 < math.hypot(*shares) < 2.0
    assert force(depth) == pytest.approx(threshold * (1.0 + math.hypot(*shares)), rel=0.02)


@pytest.mark.parametrize("stds", [1.4, 1.6, 20.0])
def test_a_depth_without_a_force_excludes_zeros_that_are_poorly_known(kernels, m, P, stds) -> None:
    """What lies below the bound is cut off: mean and variance of a truncated normal variable."""
    noise, j = math.sqrt(m[kernels.SET_R_DISPLACEMENT]), kernels.OFFSET
    P[j, :], P[:, j] = 0.0, 0.0
    std = stds * noise
    P[j, j] = std**2
    zero = m[kernels.Y0 + j] = 0.0
    bound = 0.5 * std
    m[kernels.MODE_ZERO_MEAN], m[kernels.MODE_ZERO_VAR] = zero, std**2
    m[kernels.MODE_FREE_DEPTH] = bound
    kernels.exclude_zeros(m, 1.0, -1.0)
    if stds < 1.5:
        assert (m[kernels.Y0 + j], P[j, j]) == (zero, std**2)
        return
    cut = truncnorm(0.5, np.inf, scale=std)
    assert m[kernels.Y0 + j] == pytest.approx(cut.mean(), rel=1e-6)
    assert P[j, j] == pytest.approx(cut.var(), rel=1e-6)


@pytest.mark.parametrize(
    ("excess", "depth", "moves"), [(-1.0, 2e-3, True), (0.1, 2e-3, False), (-1.0, 1e-5, False)]
)
def test_the_free_depth_is_where_the_tip_was_without_a_force(kernels, m, P, excess, depth, moves) -> None:
    j = kernels.OFFSET
    P[j, j], m[kernels.Y0 + j], m[kernels.MODE_FREE_DEPTH] = 1e-8, 1e-3, -math.inf
    m[kernels.MOTION_POSITION], m[kernels.MOTION_VAR_POSITION] = 3e-3, 1e-14
    unseen = kernels.unseen_depth(m)
    kernels.exclude_zeros(m, excess, depth)
    expected = depth - 2e-7 - unseen if moves else -math.inf
    assert m[kernels.MODE_FREE_DEPTH] == pytest.approx(expected)


@pytest.mark.parametrize("stds", [-3.1, -2.9])
def test_a_bound_cuts_something_off_from_three_standard_deviations_below_the_zero_on(
    kernels, m, P, stds
) -> None:
    j, zero, std = kernels.OFFSET, 1e-3, 1e-4
    P[j, :], P[:, j] = 0.0, 0.0
    P[j, j], m[kernels.Y0 + j] = std**2, zero
    m[kernels.MOTION_POSITION], m[kernels.MOTION_VAR_POSITION] = 1.0, 0.0
    m[kernels.MODE_FREE_DEPTH] = bound = zero + stds * std
    m[kernels.MODE_ZERO_MEAN], m[kernels.MODE_ZERO_VAR] = (zero, std**2) if stds > -3.0 else (7.0, 7.0)
    kernels.exclude_zeros(m, 1.0, 0.0)
    assert (m[kernels.MODE_ZERO_MEAN], m[kernels.MODE_ZERO_VAR]) == (zero, std * std)
    cut = truncnorm(stds if stds > -3.0 else -np.inf, np.inf, loc=zero, scale=std)
    assert (m[kernels.Y0 + j], P[j, j]) == pytest.approx((cut.mean(), cut.var()), rel=1e-6)
    P[j, j], m[kernels.Y0 + j], m[kernels.MODE_FREE_DEPTH] = std**2, zero, -math.inf
    kernels.exclude_zeros(m, -1.0, bound)
    assert (m[kernels.MODE_FREE_DEPTH] > -math.inf) == (stds > -3.0)
