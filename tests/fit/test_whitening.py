"""Whitening against the dense covariance matrix."""

import numpy as np
import pytest

from vegrip.fit.motion import motion_of
from vegrip.fit.whitening import ForceNoise, Whitener

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
    whitener = Whitener(T, FIRST, MOTION, STIFFNESS, NOISE, np.ones(N))
    residual = 0.02 * RNG.standard_normal((N, 3))
    white = whitener(residual)
    assert white.T @ white == pytest.approx(residual.T @ np.linalg.solve(dense(), residual), rel=1e-9)
    assert whitener.log_scale == pytest.approx(0.5 * np.linalg.slogdet(dense())[1], rel=1e-9)
    assert whitener(residual[:, 1]) == pytest.approx(white[:, 1], abs=1e-12)


def test_rows_that_do_not_count_leave_the_likelihood_of_the_others() -> None:
    used = np.ones(N)
    used[[5, 6, 30]] = 0.0
    keep = used > 0.5
    whitener = Whitener(T, FIRST, MOTION, STIFFNESS, NOISE, used)
    residual = 0.02 * RNG.standard_normal(N)
    expected = residual[keep] @ np.linalg.solve(dense()[np.ix_(keep, keep)], residual[keep])
    white = whitener(residual)
    assert white @ white == pytest.approx(expected, rel=1e-9)
    assert not white[~keep].any()
