"""The root of the covariance, and the state with its bounds."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose


def root_of(kernels, m):
    kernels.square_root(m, kernels.P0)
    return m[kernels.L0 : kernels.L0 + kernels.N**2].reshape(kernels.N, kernels.N)


def test_the_root_is_that_of_what_is_felt(kernels, m, P, rng) -> None:
    felt = np.array(kernels.FELT, bool)
    A = rng.standard_normal((kernels.N, kernels.N))
    P[:] = A @ A.T
    L = root_of(kernels, m)
    assert_allclose(L[np.ix_(felt, felt)], np.linalg.cholesky(P[np.ix_(felt, felt)]), atol=1e-12)
    assert not L[~felt].any()
    assert not L[:, ~felt].any()


def test_what_is_known_exactly_has_a_column_of_zeros(kernels, m, P, rng) -> None:
    A = rng.standard_normal((kernels.N, kernels.N))
    P[:] = A @ A.T
    P[-1], P[:, -1] = P[-2], P[:, -2]  # moves with the one before
    P[-1, -1] = P[-2, -2]
    P[0], P[:, 0] = 0.0, 0.0
    L = root_of(kernels, m)
    felt = np.array(kernels.FELT, bool)
    assert not L[:, 0].any()
    assert L[-1, -1] == 0.0
    assert_allclose((L @ L.T)[np.ix_(felt, felt)], P[np.ix_(felt, felt)], atol=1e-9)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_step_along_the_root_is_the_kurtosis_of_a_normal_variable(kernels, m, sign) -> None:
    L = root_of(kernels, m)
    j = kernels.LEARNED_FROM
    kernels.shift_along_root(m, kernels.Y0, j, sign)
    shift = m[kernels.TRIED0 : kernels.TRIED0 + kernels.N] - m[kernels.Y0 : kernels.Y0 + kernels.N]
    assert_allclose(shift, sign * math.sqrt(3.0) * L[:, j], atol=1e-14)


def test_a_parabola_has_the_variance_that_its_bend_adds(kernels) -> None:
    """``y = b x^2``, x normal: Var y = 2 b^2; rise and fall over sqrt(3) differ by 6 b."""
    assert kernels.bend_variance(6.0 * 0.7) == pytest.approx(2.0 * 0.7**2)


def test_learned_parameters_are_read_from_the_state(kernels, m) -> None:
    for j, place in enumerate(kernels.LEARNED[: kernels.N_LEARNED]):
        m[kernels.Y0 + kernels.LEARNED_FROM + j] = 0.3 + 0.1 * j
        kernels.put_learned(m, kernels.Y0)
        u = 0.3 + 0.1 * j
        assert m[kernels.VALUES0 + place] == pytest.approx(math.exp(u) if kernels.LEARNED_LOG[j] else u)


def test_the_state_stays_within_its_bounds(kernels, m) -> None:
    R, y = m[kernels.SET_TIP_RADIUS], kernels.Y0
    for given, kept in ((1e3, 3.0 * R), (-1e3, -100.0 * R), (0.5 * R, 0.5 * R)):
        m[y + kernels.DELTA] = given
        for j in range(kernels.LEARNED_FROM, kernels.M):
            m[y + j] = given
        kernels.bound_state(m)
        assert m[y + kernels.DELTA] == kept
        for j in range(kernels.LEARNED_FROM, kernels.M):
            assert m[y + j] == min(max(given, m[kernels.LOW0 + j]), m[kernels.HIGH0 + j])


def test_a_variance_grows_to_its_limit_and_never_shrinks(kernels, m, P) -> None:
    P[3, 3] = 2.0
    kernels.walk_within(m, 3, 0.5, 4.0)
    assert P[3, 3] == 2.5
    kernels.walk_within(m, 3, 9.0, 4.0)
    assert P[3, 3] == 4.0
    kernels.walk_within(m, 3, 9.0, 1.0)
    assert P[3, 3] == 4.0


def test_sections_are_cleared_and_copied_whole(kernels, m) -> None:
    y = slice(kernels.Y0, kernels.Y0 + kernels.N)
    kernels.copy_state(m)
    assert_allclose(m[kernels.TRIED0 : kernels.TRIED0 + kernels.N], m[y])
    before = m.copy()
    kernels.clear_section(m, kernels.Y0 + 1, kernels.Y0 + 3)
    before[kernels.Y0 + 1 : kernels.Y0 + 3] = 0.0
    assert_allclose(m, before)


def test_the_difference_step_is_a_thousandth_of_the_spread(kernels, m, P) -> None:
    P[3, 3], m[kernels.Y0 + 3] = 4.0, 1.0
    assert kernels.difference_step(m, kernels.Y0, 3) == pytest.approx(2e-3)
    P[3, 3], m[kernels.Y0 + 3] = -1.0, -5.0
    assert kernels.difference_step(m, kernels.Y0, 3) == pytest.approx(5e-8)
