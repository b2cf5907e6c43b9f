"""The motion behind a noisy displacement."""

import numpy as np
import pytest

from vegrip.identification.fit.motion import (
    _bends,
    _curvature,
    _hinge,
    _runs,
    _shared,
    motion_of,
    smooth,
    straight,
)

NOISE = 5e-6
T = np.arange(0.0, 6.0, 5e-3)


def path(kind: str) -> np.ndarray:
    if kind == "ramp and hold":
        return np.interp(T, [0.0, 0.5, 0.6, 3.0, 3.2, 6.0], [-1e-4, -1e-4, 1e-3, 1e-3, 0.0, 0.0])
    if kind == "jump":
        return np.where(T > 1.0, 5e-4, -1e-4)
    if kind == "creep":
        return 1e-3 - 3e-4 * np.exp(-3.0 * T)
    return 1e-3 + 2e-4 * np.sin(2.0 * np.pi * 2.0 * T)


def smoothed(kind, seed=0):
    first = np.zeros(T.size)
    first[0] = 1.0
    noise = NOISE * np.random.default_rng(seed).standard_normal(T.size)
    return motion_of(T, first, path(kind) + noise, NOISE)


@pytest.mark.parametrize("kind", ["ramp and hold", "jump", "creep", "sine"])
def test_error_of_the_motion_is_smaller_than_the_noise_and_as_large_as_it_says(kind) -> None:
    motions = [smoothed(kind, seed) for seed in range(5)]
    errors = np.array([m.displacement - path(kind) for m in motions])
    assert errors.std() < 0.8 * NOISE
    z = errors / np.array([m.std for m in motions])
    assert 0.7 < z.std() < 1.3
    assert np.abs(errors).max() < 5.0 * NOISE


def test_a_hold_is_smoothed_much_more_than_a_fast_motion() -> None:
    assert np.median(smoothed("ramp and hold").std[:80]) < 0.3 * NOISE
    assert np.median(smoothed("sine").std) > np.median(smoothed("ramp and hold").std)


@pytest.mark.parametrize("seed", range(5))
def test_the_noise_of_a_hold_adds_up_to_no_way(seed) -> None:
    motion = smoothed("ramp and hold", seed)
    holds = [(30, 90), (150, 580), (660, 1190)]  # clear of the corners, where a bend is looked for
    ways = [float(np.abs(np.diff(motion.displacement[low:high])).sum()) for low, high in holds]
    assert sum(ways) < 1.5 * NOISE * len(holds)


def test_straight_is_what_rests_or_runs_at_one_speed() -> None:
    first = np.zeros(T.size)
    first[0] = 1.0
    noise = NOISE * np.random.default_rng(0).standard_normal(T.size)
    runs = straight(T, first, path("ramp and hold") + noise, NOISE)
    corners = np.isin(np.arange(T.size), [100, 120, 600, 640])
    assert not runs[corners].any()
    assert runs.mean() > 0.85
    assert straight(T, first, 1e-3 * T + noise, NOISE).mean() > 0.97
    assert straight(T, first, path("sine") + noise, NOISE).mean() < 0.1
    missing = np.where(np.arange(T.size) % 3 == 0, np.nan, path("ramp and hold") + noise)
    assert not straight(T, first, missing, NOISE)[corners].any()


def test_a_bend_from_one_episode_to_the_next_is_none() -> None:
    first = np.zeros(T.size)
    first[[0, 600]] = 1.0
    assert straight(T, first, np.where(T < 3.0, 1e-3, T), NOISE).all()


def test_missing_samples_are_bridged_and_less_certain() -> None:
    first = np.zeros(T.size)
    first[0] = 1.0
    holes = path("ramp and hold").copy()
    holes[200:220] = np.nan
    motion = motion_of(T, first, holes, NOISE)
    assert motion.displacement[200:220] == pytest.approx(1e-3, abs=NOISE)
    assert motion.std[210] > motion.std[300]


def test_episodes_do_not_know_of_each_other() -> None:
    first = np.zeros(T.size)
    first[[0, 600]] = 1.0
    depth = path("sine")
    both = motion_of(T, first, depth, NOISE)
    alone = motion_of(T[:600], first[:600], depth[:600], NOISE)
    assert both.displacement[:600] == pytest.approx(alone.displacement, abs=1e-12)
    for name in ("std", "pull", "push", "start"):
        assert getattr(both, name)[:600] == pytest.approx(getattr(alone, name), rel=1e-6, abs=1e-12), name
    assert (alone.push[-1], *alone.pull[-1]) == (0.0, 0.0, 0.0)  # nothing comes after the last


def test_exact_displacement_is_left_alone() -> None:
    first = np.zeros(T.size)
    first[0] = 1.0
    motion = motion_of(T, first, path("sine"), 0.0)
    assert np.array_equal(motion.displacement, path("sine"))
    assert not motion.std.any()


@pytest.mark.parametrize("frequency", [0.05, 0.2, 0.45])
def test_what_curves_slowly_between_two_bends_is_not_taken_for_straight(frequency) -> None:
    """Taken for straight it is said to be known ten times better than it is."""
    t, noise = np.arange(0.0, 12.0, 0.01), 6.5e-6
    true = 1.5e-3 + 6e-4 * np.sin(2.0 * np.pi * frequency * t)
    first = (np.arange(t.size) == 0).astype(float)
    far = []
    for seed in range(12):
        motion = motion_of(
            t, first, true + noise * np.random.default_rng(seed).standard_normal(t.size), noise
        )
        far.append(np.abs(motion.displacement - true) > 4.0 * motion.std)
    assert np.mean(far) < 0.01


@pytest.mark.parametrize(("length", "second"), [(8.0, 1.0), (1.0, 1024.0), (0.125, 0.25)])
def test_units_of_length_and_time_do_not_matter(length, second) -> None:
    t, first = T[:400], np.r_[1.0, np.zeros(399)]
    depth = path("ramp and hold")[:400] + NOISE * np.random.default_rng(0).standard_normal(400)
    one = motion_of(t, first, depth, NOISE)
    other = motion_of(second * t, first, length * depth, length * NOISE)
    assert other.displacement == pytest.approx(length * one.displacement, abs=1e-6 * length * NOISE)
    assert other.std == pytest.approx(length * one.std, rel=1e-6)


def test_neighbours_share_what_is_theirs_within_an_episode_and_nothing_goes_round_the_end() -> None:
    for begins in ([0], [0, 8]):
        first = np.isin(np.arange(16), begins).astype(float)
        values = np.random.default_rng(1).standard_normal(16)
        episode = np.cumsum(first)
        expected = [
            sum(values[j] for j in range(16) if abs(i - j) <= 2 and episode[i] == episode[j])
            for i in range(16)
        ]
        assert _shared(values, first) == pytest.approx(expected, abs=1e-12)


RNG = np.random.default_rng(2)
UNEVEN = np.cumsum(RNG.uniform(0.5, 1.5, 40))


def test_a_hinge_is_the_coefficient_of_least_squares_with_its_information() -> None:
    y = 3.0 + RNG.standard_normal(40)
    y[[7, 20]] = np.nan
    for low, i, high in ((3, 12, 25), (0, 20, 40)):
        u = UNEVEN[low:high] - UNEVEN[i]
        known = ~np.isnan(y[low:high])
        A = np.stack([np.ones(u.size), u, np.abs(u)], axis=1)[known]
        bend, information = _hinge.py_func(UNEVEN, y, low, i, high)
        assert bend == pytest.approx(np.linalg.lstsq(A, y[low:high][known], rcond=None)[0][2])
        assert information == pytest.approx(1.0 / np.linalg.inv(A.T @ A)[2, 2])
    nothing = np.full(40, np.nan)
    nothing[3] = 1.0
    assert _hinge.py_func(UNEVEN, nothing, 0, 5, 10) == (0.0, 0.0)
    nothing[5] = nothing[7] = 1.0
    assert _hinge.py_func(UNEVEN, nothing, 0, 7, 8) == (0.0, 0.0)  # on one side alone


def test_a_window_bends_from_so_many_standard_errors_on_and_none_that_holds_a_bend_or_a_beginning() -> None:
    t, first, i = np.arange(60.0), np.zeros(60), 30
    first[0] = 1.0
    _, information = _hinge.py_func(t, np.zeros(60), i - 8, i, i + 9)
    none = np.zeros(60, dtype=bool)
    for stds, bends in ((3.9, False), (4.1, True)):
        y = 0.5 * t + stds * 0.2 / np.sqrt(information) * np.abs(t - i)
        found = _bends.py_func(t, first, y, 0.2, 8, 4.0, none)
        assert found.any() == bends
        assert found.sum() in (0, 17)
    assert np.flatnonzero(found).tolist() == list(range(i - 8, i + 9))
    for at, any_left in ((i - 9, True), (i - 8, False), (i + 8, False), (i + 9, True)):
        known = none.copy()
        known[at] = True
        assert _bends.py_func(t, first, y, 0.2, 8, 4.0, known).any() == any_left
    for at, any_left in ((i - 8, True), (i - 7, False), (i + 8, False), (i + 9, True)):
        begins = first.copy()
        begins[at] = 1.0
        assert _bends.py_func(t, begins, y, 0.2, 8, 4.0, none).any() == any_left


def test_what_square_and_cube_explain_is_the_fall_of_the_sum_of_squares() -> None:
    t, y = np.linspace(5.0, 9.0, 30), 1e3 + RNG.standard_normal(30)
    y[4] = np.nan
    known = ~np.isnan(y)
    rests = [np.polyfit(t[known] - 7.0, y[known], degree, full=True)[1][0] for degree in (1, 3)]
    assert _curvature(t, y) == pytest.approx(rests[0] - rests[1], rel=1e-6)
    for count, fits in ((3, False), (4, True)):
        few = np.full(30, np.nan)
        few[[3, 9, 20, 25][:count]] = [0.0, 5.0, -3.0, 8.0][:count]
        assert (_curvature(t, few) > 1.0) == fits


def test_runs_lie_within_an_episode_and_have_five_samples_at_least() -> None:
    wanted, first = np.ones(40, dtype=bool), np.isin(np.arange(40), [0, 12]).astype(float)
    wanted[[5, 20, 25, 31]] = False
    assert _runs(wanted, first) == [(0, 5), (6, 12), (12, 20), (26, 31), (32, 40)]


def test_the_smoother_is_the_mean_of_the_dense_posterior() -> None:
    """Position and speed at first and an acceleration for every step, all measurements at once."""
    n, R = 9, 0.3
    t = UNEVEN[:n]
    for begins in ([0], [0, 5]):
        first = np.isin(np.arange(n), begins).astype(float)
        y, q = RNG.standard_normal(n), RNG.uniform(0.1, 2.0, n)
        y[[3, 6]] = np.nan
        told = smooth.py_func(t, first, y, R, q)
        for low, high in zip(begins, [*begins[1:], n], strict=True):
            k, dt = high - low, np.diff(t[low:high])
            prior = 1.0 / np.array([1e6 * R, 1e6 * R / dt[0] ** 2, *q[low : high - 1]])
            H, speed = np.zeros((k, k + 1)), np.zeros(k + 1)
            H[0, 0], speed[1] = 1.0, 1.0
            for i in range(k - 1):
                H[i + 1] = H[i] + dt[i] * speed
                speed[2 + i] = dt[i]
            known = ~np.isnan(y[low:high])
            P = np.linalg.inv(np.diag(prior) + H[known].T @ H[known] / R)
            mean = P @ H[known].T @ (y[low:high][known] - y[low]) / R
            mean[0] += y[low]
            assert told[0][low:high] == pytest.approx(H @ mean, rel=1e-6)
            assert told[1][low:high] == pytest.approx(np.diag(H @ P @ H.T), rel=1e-3)
            assert told[2][low : high - 1] == pytest.approx(mean[2:] ** 2, rel=1e-5, abs=1e-12)
            share = 1.0 - np.diag(P)[2:] / q[low : high - 1]
            assert told[3][low : high - 1] == pytest.approx(share, rel=1e-5, abs=1e-9)
            assert told[2][high - 1] == told[3][high - 1] == 0.0
