"""Confidence of each finger for a wanted probability of the whole grasp."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtri

from vegrip.grip.joint_confidence import each_confidence, joint_confidence, shared_part

probability = st.floats(0.5, 0.999)
correlation = st.floats(0.0, 1.0)


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("fingers", [2, 5])
def test_drawn_errors_keep_the_wanted_probability(fingers: int, rho: float) -> None:
    rng = np.random.default_rng(7)
    n = 200_000
    errors = np.sqrt(rho) * rng.standard_normal((n, 1)) + np.sqrt(1.0 - rho) * rng.standard_normal(
        (n, fingers)
    )
    kept = np.all(errors < ndtri(each_confidence(0.95, fingers, rho)), axis=1).mean()
    assert kept == pytest.approx(0.95, abs=4.0 * np.sqrt(0.95 * 0.05 / n))


def test_one_finger_or_one_error_needs_no_more_than_the_grasp() -> None:
    assert each_confidence(0.95, 1, 0.3) == 0.95
    assert each_confidence(0.95, 5, 1.0) == 0.95


def test_independent_errors_need_the_root() -> None:
    assert each_confidence(0.95, 5, 0.0) == pytest.approx(0.95**0.2, abs=1e-9)


@given(p=probability, rho=correlation, fingers=st.integers(1, 10))
def test_the_confidence_lies_between_its_limits(p: float, rho: float, fingers: int) -> None:
    found = each_confidence(p, fingers, rho)
    assert p - 1e-9 <= found <= p ** (1.0 / fingers) + 1e-9


@given(rho=correlation, fingers=st.integers(1, 8))
def test_a_higher_quantile_is_surer(rho: float, fingers: int) -> None:
    found = [joint_confidence(q, fingers, rho) for q in (0.0, 1.0, 2.0, 3.0)]
    assert found == sorted(found)


def test_the_joint_belief_gives_the_correlation_of_fingers_that_share_it() -> None:
    rng = np.random.default_rng(2)
    std, own = 0.4, 0.08
    common = np.sqrt(std**2 - own**2) * rng.standard_normal(200_000)
    one, other = (common + own * rng.standard_normal(200_000) for _ in range(2))
    assert shared_part(std, own) == pytest.approx(np.corrcoef(one, other)[0, 1], abs=0.002)
    assert shared_part(0.05, 0.08) == shared_part(0.0, 0.08) == 0.0
