"""The coupling of radius and profile, exactly, against golden numbers and a bracketing root search."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import gamma

from vegrip.contact.coupling import (
    exponent_after_creep,
    exponent_from_coefficient,
    radius_ratio,
    saturating_exponent,
)
from vegrip.contact.pressure import coefficient, torsion_limit
from vegrip.contact.prony import Creep
from vegrip.errors import DomainError

# t, a/a0, C_k, k, p_max/pbar0, m_max/(mu N a0) under a step of load, h of the paper
GOLDEN = np.array(
    [
        (0, 1, 1.5, 2, 1.5, 0.589049),
        (0.05, 1.021311, 1.438055, 2.149693, 1.378668, 0.608266),
        (0.1, 1.039214, 1.388933, 2.295040, 1.286089, 0.624676),
        (0.2, 1.067060, 1.317388, 2.568902, 1.157008, 0.650711),
        (0.5, 1.111902, 1.213273, 3.209266, 0.981354, 0.694113),
        (1, 1.134233, 1.165968, 3.695187, 0.906320, 0.716520),
        (2, 1.139908, 1.154387, 3.848553, 0.888406, 0.722311),
        (np.inf, 1.140175, 1.153846, 3.856149, 0.887574, 0.722585),
    ]
)
T, A_RATIO, C, K, P_MAX, M_MAX = GOLDEN.T
DIGITS = 6e-7


def plain_coefficient(k: float) -> float:
    return 1.5 * k * gamma(3 / k) / (gamma(1 / k) * gamma(2 / k))


def test_creep_of_the_paper_has_the_golden_digits() -> None:
    h = Creep([0.3], [3.1])(T)
    k, saturated = exponent_after_creep(h)
    assert k == pytest.approx(K, abs=DIGITS)
    assert not saturated.any()
    assert coefficient(k) == pytest.approx(C, abs=DIGITS)
    assert radius_ratio(k) == pytest.approx(A_RATIO, abs=DIGITS)
    assert coefficient(k) / h == pytest.approx(P_MAX, abs=DIGITS)
    assert torsion_limit(k) * np.sqrt(h) == pytest.approx(M_MAX, abs=DIGITS)


@given(st.floats(0.25, 170))
def test_the_exponent_undoes_the_coefficient(k: float) -> None:
    assert exponent_from_coefficient(coefficient(k)) == pytest.approx(k, rel=1e-10)


@given(st.floats(1.001, 20))
def test_the_exponent_solves_the_formula_of_the_paper(C: float) -> None:
    assert plain_coefficient(float(exponent_from_coefficient(C))) == pytest.approx(C, rel=1e-12)


@given(st.floats(1.0002, 900), st.floats(1.0001, 1.1))
def test_a_flatter_pressure_has_a_larger_exponent(C: float, factor: float) -> None:
    assert exponent_from_coefficient(C) > exponent_from_coefficient(C * factor)


def test_no_creep_gives_back_the_first_exponent() -> None:
    k0 = np.array([1.0, 2.0, 3.5])
    assert exponent_after_creep(1.0, k0).k == pytest.approx(k0, rel=1e-12)


def test_creep_beyond_the_uniform_pressure_is_marked_as_saturated() -> None:
    k, saturated = exponent_after_creep([1.4, 1.4999, 1.5, 2.0])
    assert saturated.tolist() == [False, True, True, True]
    assert np.all(k[1:] == k[1])
    assert 170 < k[1] < 190


def test_a_coefficient_below_the_uniform_one_is_refused_unless_saturating() -> None:
    with pytest.raises(DomainError, match=r"C_k is 0\.9"):
        exponent_from_coefficient([1.5, 0.9])
    assert saturating_exponent([1.5, 1.0001, 0.9]).saturated.tolist() == [False, False, True]
    assert coefficient(exponent_from_coefficient(999.9)) == pytest.approx(999.9)
    with pytest.raises(DomainError, match="1000"):
        exponent_from_coefficient(1000.1)
    with pytest.raises(DomainError):
        saturating_exponent(np.nan)


def test_the_patch_cannot_outgrow_the_uniform_pressure() -> None:
    assert radius_ratio(np.inf) == pytest.approx(np.sqrt(1.5), rel=1e-15)


def test_figure_5_ends_lower_than_figure_8() -> None:
    assert coefficient(4) / radius_ratio(4) ** 2 == pytest.approx(0.872704, abs=DIGITS)
    assert P_MAX[-1] > 0.872704
