"""Whitening against the dense covariance matrix."""

import numpy as np
import pytest

from vegrip.identification.fit.motion import motion_of
from vegrip.identification.fit.noise import innovations
from vegrip.identification.fit.whitening import (
    ForceNoise,
    Sensitivity,
    Whitener,
    by_position,
    by_speed,
    follows,
    gains,
)

N = 60
T = np.cumsum(np.r_[0.0, np.random.default_rng(3).uniform(3e-3, 7e-3, N - 1)])
FIRST = np.r_[1.0, np.zeros(N - 1)]
NOISE = ForceNoise(0.01, 0.005, 2.0)
RNG = np.random.default_rng(4)
MOTION = motion_of(
    T, FIRST, np.interp(T, [0.0, 0.1, 1.0], [0.0, 5e-4, 5e-4]) + 5e-6 * RNG.standard_normal(N), 5e-6
)
STIFFNESS = np.linspace(0.0, 3e3, N)


def chain_covariance() -> np.ndarray:
    """Covariance of the smoothed position's error, by multiplying out the chain."""
    dd, dv, vv = MOTION.start[0]
    here = np.array([[dd, dv], [dv, vv]])
    across = [here]  # of each earlier state with the present one
    out = np.zeros((N, N))
    for i in range(N):
        for j, block in enumerate(across):
            out[j, i] = out[i, j] = block[0, 0]
        if i + 1 < N:
            dt = T[i + 1] - T[i]
            g = np.array([0.0, dt])
            G = np.array([[1.0, dt], [0.0, 1.0]]) - np.outer(g, MOTION.pull[i])
            here = G @ here @ G.T + np.outer(g, g) * MOTION.push[i] ** 2
            across = [block @ G.T for block in across] + [here]
    return out


def dense() -> np.ndarray:
    slow = NOISE.slow**2 * np.exp(-np.abs(T[:, None] - T) / NOISE.time)
    return STIFFNESS[:, None] * chain_covariance() * STIFFNESS + slow + NOISE.white**2 * np.eye(N)


def test_chain_has_the_variance_of_the_smoother() -> None:
    assert np.sqrt(np.diag(chain_covariance())) == pytest.approx(MOTION.std, rel=1e-3)


def test_sum_of_squares_and_determinant_are_those_of_the_dense_matrix() -> None:
    whitener = Whitener(T, FIRST, MOTION, by_position(STIFFNESS), NOISE, np.ones(N))
    residual = 0.02 * RNG.standard_normal((N, 3))
    white = whitener(residual)
    assert white.T @ white == pytest.approx(residual.T @ np.linalg.solve(dense(), residual), rel=1e-9)
    assert whitener.log_scale.sum() == pytest.approx(0.5 * np.linalg.slogdet(dense())[1], rel=1e-9)
    assert whitener(residual[:, 1]) == pytest.approx(white[:, 1], abs=1e-12)


def test_rows_that_do_not_count_leave_the_likelihood_of_the_others() -> None:
    used = np.ones(N)
    used[[5, 6, 30]] = 0.0
    keep = used > 0.5
    whitener = Whitener(T, FIRST, MOTION, by_position(STIFFNESS), NOISE, used)
    residual = 0.02 * RNG.standard_normal(N)
    expected = residual[keep] @ np.linalg.solve(dense()[np.ix_(keep, keep)], residual[keep])
    white = whitener(residual)
    assert white @ white == pytest.approx(expected, rel=1e-9)
    assert not white[~keep].any()


def test_speed_play_and_what_gaps_hide_are_in_the_covariance() -> None:
    """Against the dense matrix of ``k tip + h (speed before + speed after) / 2 + m s``, the tip held."""
    h, moving = np.linspace(5.0, 0.0, N), np.ones(N, dtype=bool)
    moving[20:35] = moving[50:] = False
    bend = 1e-3 * RNG.uniform(0.0, 1.0, N)
    memory, gaps = 0.02 * RNG.uniform(-1.0, 1.0, N), np.array([12, 40])
    memory[: gaps[0]] = 0.0
    sensitivity = Sensitivity(STIFFNESS, h, moving, bend, memory, gaps)
    whitener = Whitener(T, FIRST, MOTION, sensitivity, NOISE, np.ones(N))
    error, after = np.zeros((N, 2 + N)), np.zeros((N, 2 + N))  # in terms of 2 + N independent numbers
    dd, dv, vv = MOTION.start[0]
    root = np.linalg.cholesky(np.array([[dd, dv], [dv, vv]]))
    error[0, :2], after[0, :2] = root
    for i, dt in enumerate(np.diff(T)):
        error[i + 1] = error[i] + dt * after[i]
        after[i + 1] = after[i] - dt * (MOTION.pull[i] @ np.stack([error[i], after[i]]))
        after[i + 1, 2 + i] += MOTION.push[i] * dt
    tip, before = error.copy(), np.vstack([after[:1], after[:-1]])
    for i in range(1, N):
        tip[i] = error[i] if moving[i] else tip[i - 1]
    makes = STIFFNESS[:, None] * tip + 0.5 * h[:, None] * (before + after)
    slow = NOISE.slow**2 * np.exp(-np.abs(T[:, None] - T) / NOISE.time)
    gap = np.searchsorted(gaps, np.arange(N), side="right")
    hidden = np.where(gap[:, None] == gap, np.outer(memory, memory), 0.0)
    covariance = makes @ makes.T + slow + hidden + np.diag(NOISE.white**2 + bend**2)
    residual = 0.02 * RNG.standard_normal(N)
    white = whitener(residual)
    assert white @ white == pytest.approx(residual @ np.linalg.solve(covariance, residual), rel=1e-9)
    assert whitener.log_scale.sum() == pytest.approx(0.5 * np.linalg.slogdet(covariance)[1], rel=1e-9)
    assert whitener.std == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-9)


def test_tip_behind_a_play_rests_until_the_gap_is_crossed() -> None:
    motion = np.interp(np.arange(60), [0, 20, 40, 59], [0.0, 1e-3, 2e-4, 1e-3])
    width, first = 2e-4, np.r_[1.0, np.zeros(59)]

    def indentation(moved: np.ndarray) -> np.ndarray:
        tip = [motion[0] + moved[0] - width / 2.0]
        for at in (motion + moved)[1:]:
            tip.append(min(max(tip[-1], at - width / 2.0), at + width / 2.0))
        return np.array(tip)

    resting = np.flatnonzero(~follows(indentation, first, motion, 5e-6))
    assert resting.tolist() == [*range(21, 26), *range(41, 45)]  # 0.04 mm a step
    assert follows(indentation, first, motion, 1e-3).all()  # a play within the noise is none


def test_drag_is_as_uncertain_as_the_speed_and_most_where_the_motion_bends() -> None:
    steady = by_speed(lambda speed: 7.0 * speed, T, FIRST, MOTION)
    assert steady[0] == pytest.approx(7.0, rel=1e-6)
    dry = by_speed(lambda speed: 0.05 * np.tanh(speed / 1e-3), T, FIRST, MOTION)
    assert abs(T[int(np.argmax(dry[1]))] - 0.1) < 0.01  # where the ramp ends
    assert dry[1].max() == pytest.approx(0.05 / np.sqrt(12.0), rel=0.4)


def test_a_wandering_zero_alone_is_whitened_as_by_the_whole_filter() -> None:
    used = np.ones(N)
    used[[3, 30]] = 0.0
    columns = 0.02 * RNG.standard_normal((N, 2))
    whole = Whitener(T, FIRST, MOTION, by_position(np.zeros(N)), NOISE, used)
    white, scale = innovations(T, FIRST, NOISE.white**2, NOISE.slow**2, NOISE.time, used, columns)
    assert white == pytest.approx(whole(columns), abs=1e-12)
    assert scale == pytest.approx(whole.log_scale.sum(), rel=1e-12)


def test_compiled_gains_are_those_of_plain_python_which_would_complain_of_a_row_beyond_the_last() -> None:
    first, follow = FIRST.copy(), np.ones(N)
    first[20], follow[30:35] = 1.0, 0.0
    given = (
        *(T, first, MOTION.pull, np.stack([STIFFNESS, np.linspace(5.0, 0.0, N), 0.02 * follow], axis=1)),
        *(
            follow,
            (np.arange(N) != 40).astype(float),
            NOISE.time,
            MOTION.push,
            np.tile(MOTION.start[0], (N, 1)),
            np.full(N, NOISE.white**2),
        ),
        *(NOISE.slow**2, np.r_[0.0, np.ones(N - 1)]),
    )
    for ours, plain in zip(gains(*given), gains.py_func(*given), strict=True):
        assert ours == pytest.approx(plain, rel=1e-9)
