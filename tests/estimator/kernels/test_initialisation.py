"""How a contact begins: what is known of it, and what may be."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose


@pytest.mark.parametrize("stds", [3.9, 4.1])
def test_a_touch_is_sure_from_four_standard_deviations(kernels, m, P, stds) -> None:
    b, d = kernels.BIAS, kernels.DELTA
    std = math.sqrt(m[kernels.SET_R_FORCE] + P[b, b])
    assert kernels.is_touching(m, m[kernels.Y0 + b] + stds * std) == (stds > 4.0)
    m[kernels.Y0 + d] = stds * math.sqrt(P[d, d])
    assert kernels.is_touching(m, math.nan) == (stds > 4.0)


def test_bounds_of_a_memory_are_the_quantities_that_they_are_named_after(kernels) -> None:
    assert [kernels.bounding_quantity(code, 1.0, 2.0, 3.0) for code in (0, 1, 2, 3)] == [0.0, 2.0, 3.0, 1.0]


def test_a_contact_that_begins_in_the_air_knows_its_depth_by_the_zero(kernels, m, P) -> None:
    before, d = P.copy(), kernels.DELTA
    depth = m[kernels.Y0 + kernels.OFFSET] - 5e-4
    kernels.begin_contact(m, m[kernels.Y0 + kernels.BIAS], depth)
    assert m[kernels.Y0 + d] == pytest.approx(-5e-4)
    rest = list(range(kernels.LEARNED_FROM, kernels.N))
    assert_allclose(P[d, rest], -before[kernels.OFFSET, rest])
    assert_allclose(P[rest, d], P[d, rest])
    zero = before[kernels.OFFSET, kernels.OFFSET]
    assert P[d, d] == pytest.approx(zero + m[kernels.SET_R_DISPLACEMENT])
    assert m[kernels.MOTION_POSITION] == depth
    assert m[kernels.Y0 + kernels.SPEED] == m[kernels.MODE_ZERO_KNOWN] - 1.0 == 0.0
    memory = slice(kernels.EFFECTS, kernels.EFFECTS + kernels.NS)
    assert not P[memory].any()
    assert not P[:, memory].any()
    assert_allclose(m[kernels.Y0 :][memory], m[kernels.START0 :][memory])


def test_a_contact_that_begins_under_a_force_has_its_memory_in_the_middle_of_what_it_may_be(
    kernels, m, P
) -> None:
    """What has relaxed lies evenly between nothing and c1 N_e: mean c1 N_e / 2, variance (c1 N_e)^2 / 12."""
    depth = m[kernels.Y0 + kernels.OFFSET] + 8e-4
    kernels.begin_contact(m, 1.0, depth)
    assert m[kernels.MODE_ZERO_KNOWN] == 0.0
    assert m[kernels.MODE_MET] == 1.0
    _, elastic_force, _, _ = kernels.contact(m, kernels.Y0)
    z = kernels.EFFECTS
    whole = kernels.bound_scale(m, 0) * elastic_force
    assert m[kernels.Y0 + z] == pytest.approx(0.5 * whole)
    assert kernels.midpoint_variance(m, 0) == pytest.approx(whole**2 / 12.0)
    others = [j for j in range(kernels.M) if kernels.is_not_effect_state(j)]
    slopes = np.array([slope(kernels, m.copy(), j) for j in others])
    assert_allclose(P[z, others], slopes @ P[np.ix_(others, others)], rtol=2e-2, atol=1e-12)
    spread = slopes @ P[np.ix_(others, others)] @ slopes
    assert P[z, z] == pytest.approx(whole**2 / 12.0 + spread, rel=2e-2)
    assert_allclose(P[:, z], P[z], atol=1e-15)


@pytest.mark.parametrize("force", [0.05, 0.6, 3.0])
def test_a_contact_that_begins_without_a_displacement_is_as_deep_as_its_force_says(kernels, m, force) -> None:
    begun, d = m.copy(), kernels.DELTA
    kernels.set_unknown_history(m, force, math.nan)
    begun[kernels.Y0 + d] = m[kernels.Y0 + d]
    assert kernels.contact(begun, kernels.Y0)[3] == pytest.approx(force, rel=1e-6)


def test_a_contact_that_is_felt_is_a_hundredth_of_its_usual_depth_at_least(kernels, m) -> None:
    m[kernels.Y0 + kernels.DELTA] = -1e-3
    kernels.set_unknown_history(m, 1.0, 0.0)
    assert m[kernels.Y0 + kernels.DELTA] == 0.01 * m[kernels.SET_DEPTH]


def slope(kernels, m, j):
    """Return how the middle of the first memory moves with coordinate ``j``."""
    at, h = kernels.Y0 + j, 1e-5 * max(abs(m[kernels.Y0 + j]), 1e-3)
    ends = []
    for sign in (1.0, -1.0):
        changed = m.copy()
        changed[at] += sign * h
        kernels.set_midpoint_states(changed, kernels.Y0)
        ends.append(changed[kernels.Y0 + kernels.EFFECTS])
    return (ends[0] - ends[1]) / (2.0 * h)


def test_a_speed_that_is_surely_zero_moves_no_memory_of_which_nothing_is_known(kernels, m, P) -> None:
    speed = kernels.SPEED
    m[kernels.Y0 + speed] = 0.0
    P[speed, :] = P[:, speed] = 0.0
    kernels.set_unknown_history(m, 1.0, m[kernels.Y0 + kernels.OFFSET] + 8e-4)
    slopes = m[kernels.F0 : kernels.F0 + kernels.N**2].reshape(kernels.N, kernels.N)[: kernels.NS]
    assert_allclose(slopes[:, speed], 0.0)
    assert np.abs(slopes[:, kernels.DELTA]).max() > 0.0
    assert np.isfinite(P).all()
    assert not P[speed].any()


def test_a_belief_that_was_put_aside_comes_back_whole(kernels, m) -> None:
    before = m.copy()
    kernels.keep_belief(m)
    belief = [slice(kernels.Y0, kernels.Y0 + kernels.N), slice(kernels.P0, kernels.P0 + kernels.N**2)]
    for part in belief:
        m[part] = 7.0
    kernels.return_belief(m)
    for part in belief:
        assert_allclose(m[part], before[part])


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_is_not_finite_begins_anew_and_is_counted(kernels, m, value) -> None:
    kernels.keep_finite(m)
    assert m[kernels.COUNT_OVERFLOWS] == 0.0
    m[kernels.P0 + 5] = value
    with np.errstate(invalid="ignore"):
        kernels.keep_finite(m)
    assert m[kernels.COUNT_OVERFLOWS] == 1.0
    assert np.isfinite(m[kernels.Y0 : kernels.Y0 + kernels.N]).all()
    assert np.isfinite(m[kernels.P0 : kernels.P0 + kernels.N**2]).all()
