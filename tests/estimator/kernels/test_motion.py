"""The motion of the tip is followed by the Kalman filter of a constant speed, in matrices."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

DT = 2e-3


def put(kernels, m, position, speed, cov):
    m[kernels.MOTION_POSITION], m[kernels.MOTION_SPEED] = position, speed
    m[kernels.MOTION_VAR_POSITION], m[kernels.MOTION_COV], m[kernels.MOTION_VAR_SPEED] = (
        cov[0, 0],
        cov[0, 1],
        cov[1, 1],
    )
    m[kernels.MOTION_RESTLESS] = 2.0


def got(kernels, m):
    cov = m[kernels.MOTION_COV]
    return np.array([m[kernels.MOTION_POSITION], m[kernels.MOTION_SPEED]]), np.array(
        [[m[kernels.MOTION_VAR_POSITION], cov], [cov, m[kernels.MOTION_VAR_SPEED]]]
    )


def white(q, dt):
    """Covariance that white acceleration of density ``q`` adds in ``dt``."""
    return q * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])


COV = np.array([[3e-12, 4e-10], [4e-10, 2e-6]])
MEAN = np.array([1e-3, 2e-2])


def test_a_step_moves_mean_and_covariance(kernels, m) -> None:
    put(kernels, m, *MEAN, COV)
    F = np.array([[1.0, DT], [0.0, 1.0]])
    kernels.predict_motion(m, DT)
    mean, cov = got(kernels, m)
    assert_allclose(mean, F @ MEAN, rtol=1e-12)
    assert_allclose(cov, F @ COV @ F.T + white(2.0 * m[kernels.SET_ACCELERATION], DT), rtol=1e-12)


def updated(mean, cov, displacement, R):
    S = cov[0, 0] + R
    gain = cov[:, 0] / S
    return mean + gain * (displacement - mean[0]), cov - np.outer(gain, cov[0])


@pytest.mark.parametrize("stds", [-2.9, -0.5, 2.9])
def test_a_displacement_that_is_near_is_taken_in(kernels, m, stds) -> None:
    put(kernels, m, *MEAN, COV)
    R = m[kernels.SET_R_DISPLACEMENT]
    seen = MEAN[0] + stds * math.sqrt(COV[0, 0] + R)
    assert kernels.surprise_of(m, seen) == pytest.approx(stds**2)
    m[kernels.MODE_SINCE_JERK] = 7.0
    kernels.follow_motion(m, seen, DT)
    mean, cov = got(kernels, m)
    expected = updated(MEAN, COV, seen, R)
    assert_allclose(mean, expected[0], rtol=1e-12)
    assert_allclose(cov, expected[1], rtol=1e-9)
    assert m[kernels.MODE_CORNER] == pytest.approx(seen - MEAN[0])
    assert m[kernels.MODE_SINCE_JERK] == 7.0
    assert m[kernels.MOTION_RESTLESS] == pytest.approx(2.0 * (1.0 + 0.03 * (stds**2 - 1.0)))


@pytest.mark.parametrize("stds", [-40.0, 3.1])
def test_a_jerk_opens_the_filter_by_the_acceleration_that_explains_it(kernels, m, stds) -> None:
    put(kernels, m, *MEAN, COV)
    m[kernels.MOTION_RESTLESS] = 1e-3
    R = m[kernels.SET_R_DISPLACEMENT]
    off = stds * math.sqrt(COV[0, 0] + R)
    kernels.follow_motion(m, MEAN[0] + off, DT)
    wide = COV + white(3.0 * off**2 / DT**3, DT)
    assert wide[0, 0] == pytest.approx(COV[0, 0] + off**2)  # one standard deviation more is what was seen
    mean, cov = got(kernels, m)
    expected = updated(MEAN, wide, MEAN[0] + off, R)
    assert_allclose(mean, expected[0], rtol=1e-9)
    assert_allclose(cov, expected[1], rtol=1e-6)
    assert m[kernels.MODE_SINCE_JERK] == 0.0
    assert m[kernels.MOTION_RESTLESS] == 1.0  # a jerk ends a calm


def test_a_jerk_at_the_same_instant_opens_nothing(kernels, m) -> None:
    put(kernels, m, *MEAN, COV)
    kernels.follow_motion(m, MEAN[0] + 1e-3, 0.0)
    assert_allclose(got(kernels, m)[1], updated(MEAN, COV, 0.0, m[kernels.SET_R_DISPLACEMENT])[1], rtol=1e-9)


def test_how_restless_it_is_stays_between_a_ten_thousandth_and_a_hundred(kernels, m) -> None:
    for nis, end in ((0.0, 1e-4), (1e9, 100.0)):
        for _ in range(2000):
            kernels.adapt_process_noise(m, nis)
        assert m[kernels.MOTION_RESTLESS] == end
    m[kernels.MOTION_RESTLESS] = 2.0
    kernels.adapt_process_noise(m, 1e4)  # counts as five standard deviations
    assert m[kernels.MOTION_RESTLESS] == pytest.approx(2.0 * (1.0 + 0.03 * 24.0))
    m[kernels.MOTION_RESTLESS] = 100.0
    kernels.adapt_process_noise(m, 1.0)
    assert m[kernels.MOTION_RESTLESS] == 100.0  # noise as expected changes nothing


def test_it_begins_at_rest(kernels, m) -> None:
    kernels.begin_motion(m, 5e-4)
    speed = m[kernels.PRIOR0 + kernels.SPEED]
    mean, cov = got(kernels, m)
    assert_allclose(mean, [5e-4, 0.0])
    assert_allclose(cov, [[m[kernels.SET_R_DISPLACEMENT], 0.0], [0.0, speed]])
    assert m[kernels.MOTION_RESTLESS] == 1.0
