"""A step of the filter, against the same in matrices."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose


def test_bends_of_the_past_fade_within_two_seconds(kernels, m) -> None:
    j = kernels.EFFECTS
    m[kernels.L0 + j * kernels.N + j] = m[kernels.F0 + j] = 1.0
    m[kernels.BEND0], m[kernels.BEND_SUM0] = 0.0, 1.0
    for _ in range(1000):
        assert kernels.bend_again(m, 0, 2e-3) == 0.0
    assert m[kernels.BEND_SUM0] == pytest.approx(math.exp(-1.0), rel=2e-3)


def test_bends_add_up_as_standard_deviations_do(kernels, m) -> None:
    j = kernels.EFFECTS
    m[kernels.L0 + j * kernels.N + j] = m[kernels.F0 + j] = 1.0
    m[kernels.BEND0], m[kernels.BEND_SUM0] = 0.25, 0.0
    total = sum(kernels.bend_again(m, 0, 1e-9) for _ in range(7))
    assert total == pytest.approx((7 * math.sqrt(2.0) * 0.5) ** 2)


@pytest.mark.parametrize("kept", [0.0, 0.3, 5.0])
def test_a_state_that_forgets_itself_forgets_its_bends(kernels, m, kept) -> None:
    j = kernels.EFFECTS + 1
    m[kernels.L0 + j * kernels.N + j], m[kernels.F0 + kernels.N + j] = 2.0, 2.0 * kept
    m[kernels.BEND0 + 1], m[kernels.BEND_SUM0 + 1] = 0.0, 1.0
    kernels.bend_again(m, 1, 1e-9)
    assert m[kernels.BEND_SUM0 + 1] == pytest.approx(min(kept, 1.0))
    m[kernels.L0 + j * kernels.N + j] = 0.0  # known exactly
    kernels.bend_again(m, 1, 1e-9)
    assert m[kernels.BEND_SUM0 + 1] == 0.0


@pytest.mark.parametrize("driven", [True, False])
def test_the_covariance_moves_by_the_columns_of_the_root(kernels, m, P, rng, driven) -> None:
    n, ns, first = kernels.N, kernels.NS, kernels.LEARNED_FROM
    A = np.tril(rng.standard_normal((n, n)))
    A[kernels.SPEED] = A[:, kernels.SPEED] = 0.0
    m[kernels.L0 : kernels.L0 + n * n] = A.ravel()
    F = rng.standard_normal((ns, n))
    m[kernels.F0 : kernels.F0 + ns * n] = F.ravel()
    P[:] = A @ A.T
    moved = A.copy()
    moved[kernels.DELTA] = -A[kernels.OFFSET] if driven else A[kernels.DELTA]
    moved[kernels.EFFECTS : kernels.EFFECTS + ns] = F
    expected = moved @ moved.T
    expected[kernels.SPEED] = expected[:, kernels.SPEED] = 0.0
    expected[kernels.SPEED, kernels.SPEED] = m[kernels.MOTION_VAR_SPEED]
    kernels.move_covariance(m, driven)
    assert_allclose(P[:first], expected[:first], atol=1e-12)
    assert_allclose(P[first:], expected[first:], atol=1e-12)


@pytest.mark.parametrize("remembers", [True, False])
def test_the_error_of_the_depth_adds_to_it_and_to_what_it_does_to_the_memory(
    kernels, m, P, monkeypatch, remembers
) -> None:
    """One error moves all; where the motion turned within the step is another for each, but no maximum's."""
    before, error, ns = P.copy(), 4e-12, kernels.NS
    kept = np.array(kernels.KEPT[kernels.EFFECTS : kernels.EFFECTS + ns])
    assert kept.tolist() == [False, True]
    if not remembers:
        kept = np.zeros(ns, bool)
        monkeypatch.setattr(kernels, "KEPT", (False,) * kernels.N)
    h = 3e-4 * np.arange(1.0, ns + 1.0)
    m[kernels.H0 : kernels.H0 + ns], m[kernels.MODE_CORNER] = h, 5e-6
    m[kernels.BEND0 : kernels.BEND0 + ns] = m[kernels.BEND_SUM0 : kernels.BEND_SUM0 + ns] = 0.0
    m[kernels.BEND0] = 0.25  # counts twice, see bend_again
    kernels.add_depth_error(m, error, 2e-3)
    moved = np.zeros(kernels.N)
    moved[kernels.DELTA], moved[kernels.EFFECTS : kernels.EFFECTS + ns] = 2e-6, h
    expected = np.outer(moved, moved)
    effects = np.arange(kernels.EFFECTS, kernels.EFFECTS + ns)
    expected[effects, effects] += np.where(kept, 0.0, (0.4 * h * 5e-6 / 2e-6) ** 2)
    expected[kernels.EFFECTS, kernels.EFFECTS] += 0.5
    assert_allclose(P - before, expected, rtol=1e-6, atol=1e-14)


def test_a_depth_that_is_known_exactly_adds_nothing(kernels, m, P) -> None:
    before = P.copy()
    m[kernels.H0], m[kernels.MODE_CORNER] = 0.0, 5e-6
    m[kernels.BEND0] = m[kernels.BEND_SUM0] = 0.0
    kernels.add_depth_error(m, 0.0, 2e-3)
    assert_allclose(P, before)


@pytest.mark.parametrize("blind", [0.0, 1.0])
def test_the_change_of_the_memory_is_that_of_the_law(kernels, m, blind) -> None:
    """F and H: differences of the law itself, to one side where it is straight and to both where it bends.

    A bend moves the mean by a sixth of it and adds its variance, but of no maximum; without a displacement
    parameters count as known.
    """
    m[kernels.MODE_BLIND] = blind
    dt, depth, error = 2e-3, m[kernels.Y0 + kernels.OFFSET] + 9.2e-4, 1e-6
    kernels.square_root(m, kernels.P0)
    kernels.effects_ahead(m, dt, depth, error)
    H = m[kernels.H0 : kernels.H0 + kernels.NS].copy()
    F = m[kernels.F0 : kernels.F0 + kernels.NS * kernels.N].reshape(kernels.NS, kernels.N).copy()

    def ahead(y, end):
        m[kernels.TRIED0 : kernels.TRIED0 + kernels.N] = y
        end = end - y[kernels.OFFSET]
        kernels.propagate(m, kernels.TRIED0, end, y[kernels.SPEED], dt, kernels.TRIAL0)
        return m[kernels.TRIAL0 : kernels.TRIAL0 + kernels.NS].copy()

    y = m[kernels.Y0 : kernels.Y0 + kernels.N].copy()
    assert_allclose(H, ahead(y, depth + error) - ahead(y, depth), rtol=1e-9)
    L = m[kernels.L0 : kernels.L0 + kernels.N**2].reshape(kernels.N, kernels.N).copy()
    ns, kept = kernels.NS, np.array(kernels.KEPT[kernels.EFFECTS : kernels.EFFECTS + kernels.NS])
    mean, bend = m[kernels.NEXT0 : kernels.NEXT0 + ns].copy(), m[kernels.BEND0 : kernels.BEND0 + ns].copy()
    wide, here, seen = math.sqrt(3.0), ahead(y, depth), set()
    bent = np.zeros((2, ns))
    for j in range(kernels.N):
        known = blind and kernels.LEARNED_FROM <= j < kernels.M
        if j == kernels.BIAS or L[j, j] == 0.0 or known:
            assert not F[:, j].any()
        else:
            rise = (ahead(y + wide * L[:, j], depth) - here) / wide
            fall = (here - ahead(y - wide * L[:, j], depth)) / wide
            straight = np.all(wide * np.abs(rise) <= 0.02 * np.abs(here))
            if not straight:
                bent += [np.where(kept, 0.0, wide * (rise - fall)) ** n / (6.0, 18.0)[n - 1] for n in (1, 2)]
            assert_allclose(F[:, j], rise if straight else 0.5 * (rise + fall), rtol=1e-9, atol=1e-12)
            seen.add(bool(straight))
    assert seen == {True, False}
    assert_allclose(mean, here + bent[0], rtol=1e-9)
    assert_allclose(bend, bent[1], rtol=1e-6)
    assert np.all((np.abs(bent) > 0.0) == ~kept)


@pytest.mark.parametrize("dt", [1e-3, 10.0, 1e9])
@pytest.mark.parametrize(("rest", "faster"), [(0.0, 1.0), (20.0, 1.0), (1e9, 100.0)])
def test_zeros_drift_a_hundred_times_the_variance_in_a_long_rest(kernels, m, P, rest, faster, dt) -> None:
    m[kernels.MODE_REST] = rest
    before = np.diag(P).copy()
    kernels.add_random_walks(m, dt)
    for j in range(kernels.LEARNED_FROM, kernels.N):
        quick = faster if j >= kernels.M else 1.0
        limit = max(before[j], quick * m[kernels.PRIOR0 + j])
        grown = min(before[j] + quick * dt * m[kernels.DRIFT0 + j], limit)
        assert P[j, j] == pytest.approx(grown, rel=1e-9, abs=0.0)


def test_without_a_displacement_the_tip_goes_on_at_its_speed(kernels, m) -> None:
    m[kernels.MOTION_SPEED] = 3e-2
    m[kernels.Y0 + kernels.OFFSET] = 2e-5
    assert kernels.predicted_depth(m, kernels.Y0, math.nan, 2e-3) == pytest.approx(
        m[kernels.Y0 + kernels.DELTA] + 6e-5
    )
    assert kernels.predicted_depth(m, kernels.Y0, 1e-3, 2e-3) == pytest.approx(9.8e-4)


@pytest.mark.parametrize("driven", [True, False])
def test_what_the_indentation_does_from_sample_to_sample_is_known_without_its_slow_error(
    kernels, m, P, driven
) -> None:
    """Driven, displacement and force tell of it; else what is not the error of the zero of the force."""
    if driven:
        weights = 1.0 / m[kernels.SET_R_DISPLACEMENT], m[kernels.MODE_SLOPE] ** 2 / m[kernels.SET_R_FORCE]
        assert kernels.indentation_noise(m, driven) == pytest.approx(sum(weights) ** -0.5)
        return
    d, b = kernels.DELTA, kernels.BIAS
    P[d, d], P[b, b], P[d, b] = 25e-12, 4e-4, 6e-8
    assert kernels.indentation_noise(m, driven) == pytest.approx(4e-6)
    P[b, b] = 1e-4  # no covariance, but by rounding there may be less left than nothing
    assert kernels.indentation_noise(m, driven) == 0.0


@pytest.mark.parametrize("noises", [3.0, 2.0, -1.0])
def test_a_running_maximum_follows_but_for_two_and_a_half_deviations_of_its_noise(kernels, m, noises) -> None:
    i = kernels.KEPT.index(True) - kernels.EFFECTS
    here, dt = kernels.Y0 + kernels.EFFECTS + i, 2e-3
    y = m[kernels.Y0 : kernels.Y0 + kernels.N].copy()

    def peak(depth):
        m[kernels.TRIED0 : kernels.TRIED0 + kernels.N] = np.where(kernels.KEPT, 0.0, y)
        kernels.propagate(m, kernels.TRIED0, depth, y[kernels.SPEED], dt, kernels.TRIAL0)
        return m[kernels.TRIAL0 + i]

    depth = y[kernels.DELTA]
    now, noise = peak(depth), peak(depth + kernels.indentation_noise(m, True)) - peak(depth)
    assert noise > 0.0
    m[kernels.OLD0 : kernels.OLD0 + kernels.N] = y
    m[kernels.OLD0 + kernels.EFFECTS + i] = m[here] = now - noises * noise
    before = m.copy()
    kernels.follow_extremes(m, dt, True)
    assert m[here] == pytest.approx(now - min(noises, 2.5) * noise if noises > 0.0 else now + noise)
    changed = np.flatnonzero(
        m[kernels.Y0 : kernels.Y0 + kernels.N] != before[kernels.Y0 : kernels.Y0 + kernels.N]
    )
    assert set(changed) <= {kernels.EFFECTS + i}
    before = m.copy()
    kernels.follow_extremes(m, 0.0, True)
    assert np.array_equal(m, before)


@pytest.mark.parametrize(
    ("old", "now", "kept"), [(0.3, 0.2, 0.225), (0.21, 0.2, 0.21), (0.1, 0.2, 0.175), (0.19, 0.2, 0.19)]
)
def test_an_extreme_moves_as_far_as_two_and_a_half_deviations_of_its_noise_let_it(
    kernels, m, monkeypatch, old, now, kept
) -> None:
    """Either way; a hundredth of the memory is one deviation."""
    i = kernels.KEPT.index(True) - kernels.EFFECTS

    def propagate(m, _y, _delta, _speed, _dt, into):
        m[into + i] = now + (0.01 if into == kernels.TRIAL0 else 0.0)

    monkeypatch.setattr(kernels, "propagate", propagate)
    m[kernels.OLD0 + kernels.EFFECTS + i] = old
    kernels.follow_extremes(m, 2e-3, True)
    assert m[kernels.Y0 + kernels.EFFECTS + i] == pytest.approx(kept)


def test_a_step_moves_to_where_the_displacement_leads(kernels, m, P) -> None:
    """Mean: the law at the new depth; variance of the depth: those of displacement and zero."""
    dt, d = 2e-3, kernels.DELTA
    m[kernels.MOTION_SPEED] = 4e-3
    P[kernels.OFFSET] = P[:, kernels.OFFSET] = 0.0
    depth = m[kernels.Y0 + kernels.OFFSET] + 9.5e-4
    y = m[kernels.Y0 : kernels.Y0 + kernels.N].copy()
    kernels.predict(m, dt, depth)
    assert m[kernels.Y0 + d] == pytest.approx(9.5e-4)
    assert m[kernels.Y0 + kernels.SPEED] == 4e-3
    assert P[d, d] == pytest.approx(m[kernels.SET_R_DISPLACEMENT] + P[kernels.OFFSET, kernels.OFFSET])
    assert_allclose(m[kernels.OLD0 : kernels.OLD0 + kernels.N], y)
    assert_allclose(m[kernels.Y0 + kernels.LEARNED_FROM : kernels.Y0 + kernels.N], y[kernels.LEARNED_FROM :])
    before = P.copy()
    m[kernels.MOTION_VAR_SPEED], m[kernels.SET_ACCELERATION] = 1e-6, 3e-3
    start = m[kernels.Y0 + d]
    kernels.predict(m, dt, math.nan)
    assert m[kernels.Y0 + d] == pytest.approx(start + dt * 4e-3)
    assert P[d, d] - before[d, d] == pytest.approx(dt**2 * 1e-6 + dt**3 * 1e-3)
    assert P[kernels.SPEED, kernels.SPEED] == 1e-6
