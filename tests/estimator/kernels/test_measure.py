"""What a measurement is expected to be and what it changes, against the same in matrices."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

WIDE = math.sqrt(3.0)


def section(kernels, m, name):
    at = getattr(kernels, f"{name}0")
    return m[at : at + kernels.N]


def square(kernels, m, name):
    at, n = getattr(kernels, f"{name}0"), kernels.N
    return m[at : at + n * n].reshape(n, n)


@pytest.fixture
def calm(kernels, m, P, rng):
    """Return the memory of a contact from which everything may learn, with a slope to learn along."""
    for name in ("MODE_REST", "MODE_CAUTION", "MODE_TOUCH", "MODE_BLIND", "MODE_TOLERATED"):
        m[getattr(kernels, name)] = 0.0
    m[kernels.MODE_ZERO_KNOWN] = m[kernels.MODE_FELT] = 1.0
    section(kernels, m, "H")[:] = rng.standard_normal(kernels.N) / np.sqrt(np.maximum(np.diag(P), 1e-30))
    return m


def force_at(kernels, m, y):
    """Return the sensed force [N] of a state, without its zero."""
    section(kernels, m, "TRIED")[:] = y
    return kernels.contact(m, kernels.TRIED0)[3]


def test_the_variance_of_what_is_expected_is_that_of_a_linear_form(kernels, calm, P) -> None:
    H = section(kernels, calm, "H")
    assert kernels.spread_of(calm) == pytest.approx(H @ P @ H)
    assert_allclose(section(kernels, calm, "G"), P @ H)


@pytest.mark.parametrize(
    ("changed", "stds", "learned", "zeros", "offset"),
    [
        ({}, 0.5, 0.7, 0.7, 0.7),
        ({}, 2.9, 0.7, 0.7, 0.7),
        ({}, 3.1, 0.0, 0.0, 0.0),
        ({}, 6.9, 0.0, 0.0, 0.0),
        ({"MODE_REST": 1e9}, 0.5, 0.0, 0.7, 0.7),
        ({"MODE_CAUTION": 1.0}, 0.5, 0.0, 0.0, 0.0),
        ({"MODE_ZERO_KNOWN": 0.0}, 0.5, 0.7 * 0.02, 0.7, 0.0),
        ({"MODE_FELT": 0.0}, 0.5, 0.0, 0.7, 0.0),
        ({"MODE_FELT": 0.0, "MODE_TOUCH": 2.1}, 0.5, 0.0, 0.0, 0.0),
        ({"MODE_FELT": 0.0, "MODE_TOUCH": 1.9}, 0.5, 0.0, 0.7, 0.0),
        ({"MODE_BLIND": 1.0}, 0.5, 0.7, 0.0, 0.7),
        ({"MODE_BLIND": 1.0, "MODE_FELT": 0.0}, 0.5, 0.7, 0.0, 0.7),
    ],
)
def test_a_measurement_moves_mean_and_covariance_by_the_gain_that_each_may_have(
    kernels, calm, P, changed, stds, learned, zeros, offset
) -> None:
    """``P' = (1 - K H) P (1 - K H)' + K R K'`` is that of any gain, whatever is only considered."""
    H = section(kernels, calm, "H")
    H[kernels.DELTA] = abs(H[kernels.DELTA])
    for name, value in changed.items():
        calm[getattr(kernels, name)] = value
    before, y, n = P.copy(), section(kernels, calm, "Y").copy(), kernels.N
    spread = kernels.spread_of(calm)
    R = 0.5 * spread
    S = R + spread
    parts = np.ones(n)
    parts[kernels.LEARNED_FROM : kernels.M] = learned
    parts[kernels.M :] = zeros
    parts[kernels.OFFSET] = offset
    parts[list(kernels.KEPT)] = 0.0  # a running maximum follows by itself
    if stds > 3.0:  # Huber's weight
        R, S = R + S * (stds / 3.0 - 1.0), S * stds / 3.0
    K = parts * (before @ H) / S
    kernels.apply_measurement(calm, kernels.CHANNEL_FORCE, stds * math.sqrt(1.5 * spread), 1.5 * spread)
    A = np.eye(n) - np.outer(K, H)
    expected = A @ before @ A.T + R * np.outer(K, K)
    scale = np.sqrt(np.maximum(np.diag(before), 1e-30))
    assert_allclose(P / np.outer(scale, scale), expected / np.outer(scale, scale), rtol=1e-7, atol=1e-9)
    some = slice(kernels.LEARNED_FROM, None)  # the others have bounds
    moved = K * stds * math.sqrt(1.5 * spread)
    assert_allclose((section(kernels, calm, "Y") - y)[some], moved[some], rtol=1e-7, atol=1e-12)
    channel = kernels.CHANNEL0 + kernels.CHANNEL_SIZE * kernels.CHANNEL_FORCE
    assert calm[channel + kernels.CH_STREAK] == calm[channel + kernels.CH_AGE] == 0.0


def test_a_measurement_that_contradicts_changes_nothing_and_is_counted(kernels, calm, P) -> None:
    channel = kernels.CHANNEL0 + kernels.CHANNEL_SIZE * kernels.CHANNEL_FORCE
    S = 2.0 * kernels.spread_of(calm)
    y, before, counted = section(kernels, calm, "Y").copy(), P.copy(), calm[channel + kernels.CH_REJECTED]
    for innovation in (7.01, -7.01, math.nan):
        kernels.apply_measurement(calm, kernels.CHANNEL_FORCE, innovation * math.sqrt(S), S)
    assert calm[channel + kernels.CH_REJECTED] == counted + 3
    assert calm[channel + kernels.CH_STREAK] >= 3
    assert_allclose(section(kernels, calm, "Y"), y, rtol=0.0)
    assert_allclose(P, before, rtol=0.0)


def test_what_the_model_leaves_unexplained_is_no_noise_to_the_health(kernels, calm) -> None:
    """Of it, 0.3 of the noise's variance is by chance; the rest is none of the innovation's."""
    noise = calm[kernels.SET_R_FORCE]
    calm[kernels.MODE_UNEXPLAINED] = 0.2 * noise
    assert kernels.force_variance(calm) == pytest.approx(noise)
    calm[kernels.MODE_UNEXPLAINED] = 1.5 * noise
    assert kernels.force_variance(calm) == pytest.approx(2.2 * noise)
    assert calm[kernels.MODE_TOLERATED] == pytest.approx(1.2 * noise)
    cell = kernels.HEALTH0 + kernels.CELL_SIZE * (
        kernels.REGIMES * kernels.CHANNEL_FORCE + int(calm[kernels.MODE_CELL])
    )
    for S, left in ((4.0, 2.8), (1.21, 0.121)):
        calm[cell : cell + kernels.CELL_SIZE] = 0.0
        kernels.apply_measurement(calm, kernels.CHANNEL_FORCE, math.sqrt(noise), S * noise)
        assert calm[cell + kernels.CELL_NIS] == pytest.approx(1.0 / left)
        assert calm[cell + kernels.CELL_MEAN] == pytest.approx(1.0 / math.sqrt(left))


@pytest.mark.parametrize("bent_from", range(6))
def test_the_force_is_regressed_over_the_spread_of_the_state(kernels, m, P, bent_from) -> None:
    """Columns where the force bends: both sides of each, a third of the bend in the mean.

    Those that change the force by a small part of it count as straight.
    """
    kernels.square_root(m, kernels.P0)
    L, M = square(kernels, m, "L").copy(), kernels.M
    y = section(kernels, m, "Y").copy()
    section(kernels, m, "MID")[:] = y
    base = force_at(kernels, m, y)
    up = np.array([force_at(kernels, m, y + WIDE * L[:, j]) - base for j in range(M)])
    down = np.array([base - force_at(kernels, m, y - WIDE * L[:, j]) for j in range(M)])
    kernels.STRAIGHT = sum(sorted(np.abs(up) / base)[bent_from : bent_from + 2]) / 2.0 if bent_from else 0.0
    down = np.where(np.abs(up) <= kernels.STRAIGHT * base, up, down)
    section(kernels, m, "H")[:] = 7.0
    mean, bend = kernels.regress_force(m)
    H = section(kernels, m, "H").copy()
    assert_allclose(L[:M, :M].T @ H[:M], (up + down) / (2.0 * WIDE), rtol=1e-6, atol=1e-9 * base)
    assert mean == pytest.approx(base + np.sum(up - down) / 6.0 + y[kernels.BIAS], rel=1e-9)
    assert bend == pytest.approx(np.sum((up - down) ** 2) / 18.0, rel=1e-6)
    assert (H[kernels.OFFSET], H[kernels.BIAS]) == (0.0, 1.0)
    assert not H[:M][np.diag(L)[:M] == 0.0].any()


@pytest.fixture(autouse=True)
def straight(kernels, monkeypatch):
    monkeypatch.setattr(kernels, "STRAIGHT", kernels.STRAIGHT)


@pytest.mark.parametrize("wide", [1.0, 900.0])
def test_the_expected_force_is_that_of_regressions_about_the_state_after_it(
    kernels, m, P, wide, monkeypatch
) -> None:
    """Iterated posterior linearisation in matrices: over the spread after the sample, where the law bends."""
    d, n = kernels.DELTA, kernels.N
    P[d, :] *= math.sqrt(wide)
    P[:, d] *= math.sqrt(wide)
    monkeypatch.setattr(kernels, "smooth_slopes", lambda _: 0.0)
    m[kernels.MODE_UNEXPLAINED] = m[kernels.MODE_BEND] = 0.0
    m[kernels.MODE_ZERO_KNOWN] = 1.0
    R, y, before = m[kernels.SET_R_FORCE], section(kernels, m, "Y").copy(), P.copy()
    value = force_at(kernels, m, y) + y[kernels.BIAS] + 2.0 * math.sqrt(R)

    def regressed(about, covariance):
        scratch = m.copy()
        scratch[kernels.B0 : kernels.B0 + n * n] = covariance.ravel()
        kernels.square_root(scratch, kernels.B0)
        section(kernels, scratch, "MID")[:] = about
        mean, bend = kernels.regress_force(scratch)
        return mean, bend, section(kernels, scratch, "H").copy()

    about, covariance, rounds, narrow = y, before, 0, False
    while True:
        mean, bend, H = regressed(about, covariance)
        innovation = value - mean - H @ (y - about)
        S = R + bend + H @ before @ H
        rounds += 1
        if rounds == 3 or (rounds == 2 and narrow):
            break
        narrow = bend < 0.01 * R
        about = y + before @ H / S * innovation
        covariance = covariance if narrow else before - np.outer(before @ H, before @ H) / S
    assert (rounds == 2) == (wide == 1.0)
    found, variance = kernels.expect_force(m, value)
    assert found == pytest.approx(innovation, rel=1e-9, abs=1e-12)
    assert variance == pytest.approx(S, rel=1e-9)
    assert_allclose(section(kernels, m, "H"), H, rtol=1e-9)
    assert m[kernels.MODE_SLOPE] == pytest.approx(H[d])
    assert m[kernels.MODE_BEND] == pytest.approx(math.sqrt(bend))


def test_a_bend_that_stays_counts_in_every_sample_and_fades_in_a_twentieth_of_a_second(kernels, m) -> None:
    """``n`` samples that err alike have ``(n sd)^2``, of which ``n sd^2`` are counted already."""
    m[kernels.MODE_BEND], m[kernels.MODE_PERIOD], sd = 0.0, 1e-12, 0.03
    added = sum(kernels.coherent_variance(m, sd**2) for _ in range(9))
    assert added == pytest.approx((9 * sd) ** 2 - 9 * sd**2)
    m[kernels.MODE_PERIOD] = 0.05
    kernels.coherent_variance(m, 0.0)
    assert m[kernels.MODE_BEND] == pytest.approx(4.5 * sd)


def test_slopes_are_averaged_where_the_tip_rests_and_nowhere_else(kernels, calm, P, rng) -> None:
    d, near = kernels.DELTA, math.sqrt(calm[kernels.SET_R_DISPLACEMENT])
    calm[kernels.MODE_REGIME], calm[kernels.MODE_PERIOD] = kernels.REGIME_HOLD, 2e-3
    calm[kernels.RATIO_COUNT], calm[kernels.RATIO_PLACE] = 0.0, -1.0
    place, some, places = calm[kernels.Y0 + d], slice(kernels.EFFECTS, kernels.M), []
    H = section(kernels, calm, "H")
    given = rng.standard_normal((30, kernels.N)) + 5.0
    for k, h in enumerate(given):
        H[:] = h
        places.append(place + 0.5 * near * (-1) ** k)
        calm[kernels.Y0 + d] = places[-1]
        spread = kernels.spread_of(calm)
        gained = kernels.smooth_slopes(calm)
        assert gained == pytest.approx(H @ P @ H - spread)
        mean = np.mean(given[: k + 1, some] / given[: k + 1, d : d + 1], axis=0)
        assert_allclose(H[some], h[d] * mean, rtol=1e-9)
        assert calm[kernels.RATIO_PLACE] == pytest.approx(np.mean(places), rel=1e-12)
    calm[kernels.RATIO_COUNT] = 1e9
    kernels.smooth_slopes(calm)
    assert calm[kernels.RATIO_COUNT] == pytest.approx(500.0)  # a second of samples
    calm[kernels.MODE_PERIOD], calm[kernels.RATIO_COUNT] = 1e-12, 1e9
    kernels.smooth_slopes(calm)
    assert calm[kernels.RATIO_COUNT] == 1e4  # of 10 kHz at most
    for name, value in (
        ("Y", place + 9.0 * near),
        ("MODE_REGIME", kernels.REGIME_LOADING),
        ("MODE_ZERO_KNOWN", 0.0),
    ):
        here = calm.copy()
        here[kernels.Y0 + d if name == "Y" else getattr(kernels, name)] = value
        here[kernels.H0 : kernels.H0 + kernels.N] = given[0]
        kernels.smooth_slopes(here)
        assert here[kernels.RATIO_COUNT] == 0.0
        assert_allclose(here[kernels.H0 : kernels.H0 + kernels.N], given[0], rtol=1e-12)


@pytest.mark.parametrize("blind", [0.0, 1.0])
def test_slopes_of_force_and_radius_are_the_derivatives(kernels, m, P, blind, monkeypatch) -> None:
    m[kernels.MODE_BLIND] = blind
    y = section(kernels, m, "Y").copy()
    asked = kernels.LEARNED_FROM if blind else kernels.M
    section(kernels, m, "TRIED")[:] = y
    assert kernels.force_gradient(m, kernels.TRIED0) == pytest.approx(force_at(kernels, m, y))
    slope = section(kernels, m, "H").copy()
    noted = []
    monkeypatch.setattr(kernels, "apply_measurement", lambda *given: noted.append(given[1:]))
    kernels.measure_radius(m, 5e-3)
    by_radius = section(kernels, m, "H").copy()

    def radius_at(state):
        section(kernels, m, "TRIED")[:] = state
        return kernels.radius_of(m, kernels.TRIED0)

    for function, found, count in ((force_at, slope, asked), (radius_at, by_radius, kernels.M)):
        for j in range(kernels.N):
            h = 1e-4 * math.sqrt(P[j, j])
            step = np.zeros(kernels.N)
            step[j] = h
            of = (lambda s: force_at(kernels, m, s)) if function is force_at else radius_at
            exact = (of(y + step) - of(y - step)) / (2.0 * h) if h and j < count and kernels.FELT[j] else 0.0
            if j == kernels.BIAS:
                exact = 1.0 if function is force_at else 0.0
            assert found[j] * math.sqrt(P[j, j]) == pytest.approx(
                exact * math.sqrt(P[j, j]), rel=2e-2, abs=1e-9
            ), j
    ((channel, innovation, variance),) = noted
    assert channel == kernels.CHANNEL_RADIUS
    assert innovation == pytest.approx(5e-3 - radius_at(y))
    assert variance == pytest.approx(m[kernels.SET_R_RADIUS] + by_radius @ P @ by_radius)


def test_a_radius_that_is_measured_in_the_air_says_nothing(kernels, m, monkeypatch) -> None:
    noted = []
    monkeypatch.setattr(kernels, "apply_measurement", lambda *given: noted.append(given))
    for depth in (-1e-4, 0.0):
        m[kernels.Y0 + kernels.DELTA] = depth
        kernels.measure_radius(m, 5e-3)
    assert noted == []


@pytest.mark.parametrize("share", [0.3, 1.7])
def test_without_a_displacement_the_force_is_linearised_where_it_is(kernels, m, P, share) -> None:
    y = section(kernels, m, "Y").copy()
    m[kernels.MODE_BLIND], m[kernels.MODE_UNEXPLAINED] = 1.0, 0.0
    R, base = m[kernels.SET_R_FORCE], force_at(kernels, m, y)
    P[kernels.BIAS, kernels.BIAS] = R
    value = share * base + y[kernels.BIAS]
    innovation, S = kernels.expect_force_alone(m, value)
    at, H = section(kernels, m, "TRIED").copy(), section(kernels, m, "H").copy()
    threshold = 3.0 * math.sqrt(R + P[kernels.BIAS, kernels.BIAS])
    here = force_at(kernels, m, at)
    assert abs(here - share * base) < 1e-6
    assert_allclose(np.delete(at, kernels.DELTA), np.delete(y, kernels.DELTA))
    assert innovation == pytest.approx(
        value - here - y[kernels.BIAS] - H[: kernels.M] @ (y - at)[: kernels.M]
    )
    assert pytest.approx(R + H @ P @ H) == S
    assert m[kernels.MODE_SLOPE] == H[kernels.DELTA]
    for stds, moves in ((2.9, False), (3.1, True)):
        kernels.expect_force_alone(m, base + y[kernels.BIAS] + stds / 3.0 * threshold)
        assert (m[kernels.TRIED0 + kernels.DELTA] != y[kernels.DELTA]) == moves
    for force in (
        0.9 * threshold,
        base + 0.9 * threshold,
        base - 0.9 * threshold,
    ):  # too little, or there already
        section(kernels, m, "TRIED")[:] = y
        kernels.linearise_at_force(m, kernels.TRIED0, force, threshold)
        assert m[kernels.TRIED0 + kernels.DELTA] == y[kernels.DELTA]


@pytest.mark.parametrize("known", [0.0, 1.0])
def test_a_force_that_is_refused_anyhow_is_regressed_once(kernels, m, monkeypatch, known) -> None:
    """From ten standard deviations on, and a slope is averaged where the force is three of them or more.

    A bend counts again once the zero is known, and one of a hundredth of the noise is regressed once more.
    """
    rounds, smoothed, spread = [], [], 3e-3
    m[kernels.MODE_UNEXPLAINED], m[kernels.MODE_ZERO_KNOWN] = 0.0, known
    m[kernels.Y0 + kernels.BIAS] = bias = 0.5
    monkeypatch.setattr(kernels, "spread_of", lambda _: spread)
    monkeypatch.setattr(kernels, "coherent_variance", lambda *_: 2e-3)
    monkeypatch.setattr(kernels, "smooth_slopes", lambda _: smoothed.append(0) or 5e-3)
    section(kernels, m, "G")[:] = section(kernels, m, "H")[:] = 0.0
    R = m[kernels.SET_R_FORCE]
    for expected, off, slope, bend, count, averaged in (
        (2.9, 9.9, 1.0, 0.0, 2, False), (3.1, 9.9, 1.0, 0.0, 2, True), (3.1, 10.1, 1.0, 0.0, 1, True),
        (3.1, -10.1, 1.0, 0.0, 1, True), (3.1, 9.9, 0.0, 0.0, 2, False), (2.9, 9.9, 1.0, 0.0099, 2, False),
        (2.9, 9.9, 1.0, 0.0101, 3, False),
    ):  # fmt: skip
        rounds.clear()
        smoothed.clear()
        m[kernels.H0 + kernels.DELTA], S = slope, R * (1.0 + bend) + spread
        mean = bias + expected * math.sqrt(S + 2e-3 * known)
        regressed = mean, bend * R
        monkeypatch.setattr(kernels, "regress_force", lambda _, told=regressed: rounds.append(0) or told)
        found, variance = kernels.expect_force(m, mean + off * math.sqrt(S))
        assert (len(rounds), bool(smoothed)) == (count, averaged)
        assert found == pytest.approx(off * math.sqrt(S))
        assert variance == pytest.approx(S + 2e-3 * known + (5e-3 if averaged else 0.0))
        if not averaged:
            assert m[kernels.RATIO_PLACE] == -m[kernels.SET_TIP_RADIUS]
