"""The pressure family against tanh-sinh quadrature of its definition with 30 digits."""

import math
from functools import cache

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from vegrip.contact import pressure
from vegrip.contact.prony import Relaxation
from vegrip.errors import DomainError

# k, C_k, m_max / (mu N a)
GOLDEN = [
    (1, 3.000000000, 0.500000000),
    (2, 1.500000000, 0.589048623),
    (3, 1.240490015, 0.620245007),
    (4, 1.144139645, 0.635409814),
    (5, 1.096798233, 0.644067431),
    (6, 1.069761192, 0.649519053),
    (7, 1.052775813, 0.653189662),
    (8, 1.041372703, 0.655785467),
    (9, 1.033331524, 0.657691796),
    (10, 1.027441490, 0.659134464),
    (50, 1.001261682, 0.666263664),
    (math.inf, 1.0, 0.666666667),
]
DIGITS = 6e-10

# k, C_k, a / a_0 with six digits
GOLDEN_TABLE_2 = [
    (2.0, 1.5, 1.0),
    (2.2, 1.419976, 1.027792),
    (2.4, 1.358721, 1.050704),
    (2.5, 1.333283, 1.060680),
    (2.6, 1.310606, 1.069817),
    (2.8, 1.272006, 1.085928),
    (3.0, 1.240490, 1.099636),
    (3.2, 1.214373, 1.111398),
    (3.4, 1.192453, 1.121566),
    (3.5, 1.182783, 1.126142),
    (3.6, 1.173852, 1.130418),
    (3.8, 1.157913, 1.138171),
    (4.0, 1.144140, 1.145002),
]
exponents = st.floats(0.5, 100)


@cache
def moment(k: float, power: int) -> float:
    """``int_0^1 [1 - r^k]^(1/k) r^power dr``, 30 digits."""
    with mpmath.workdps(30):
        order = mpmath.mpf(k)
        return float(mpmath.quad(lambda r: (1 - r**order) ** (1 / order) * r**power, [0, 0.5, 1]))


@pytest.mark.parametrize(("k", "C", "m"), GOLDEN)
def test_coefficient_and_torsion_limit_have_the_golden_digits(k: float, C: float, m: float) -> None:
    assert pressure.coefficient(k) == pytest.approx(C, abs=DIGITS)
    assert pressure.torsion_limit(k) == pytest.approx(m, abs=DIGITS)


@pytest.mark.parametrize(("k", "C", "ratio"), GOLDEN_TABLE_2)
def test_table_2_follows_from_quadrature(k: float, C: float, ratio: float) -> None:
    assert pressure.coefficient(k) == pytest.approx(C, abs=6e-7)
    assert 1 / (2 * moment(k, 1)) == pytest.approx(C, abs=6e-7)
    assert math.sqrt(1.5 * 2 * moment(k, 1)) == pytest.approx(ratio, abs=6e-7)


@given(exponents)
def test_both_forms_of_the_paper_agree_with_ours(k: float) -> None:
    text = 1.5 * k * math.gamma(3 / k) / (math.gamma(1 / k) * math.gamma(2 / k))
    footnote = 3 * math.gamma(3 / k) / (math.gamma(1 / k) * math.gamma(1 + 2 / k))
    assert pressure.coefficient(k) == pytest.approx(text, rel=1e-12)
    assert pressure.coefficient(k) == pytest.approx(footnote, rel=1e-12)


def test_the_excess_keeps_its_digits_where_the_coefficient_is_nearly_one() -> None:
    for k in (1e2, 1e4, 1e6):
        with mpmath.workdps(60):
            u = 1 / mpmath.mpf(k)
            exact = mpmath.gamma(1 + 3 * u) / mpmath.gamma(1 + u) / mpmath.gamma(1 + 2 * u) - 1
        assert pressure.coefficient_excess(k) == pytest.approx(float(exact), rel=1e-15 * k + 1e-12)
        series = math.pi**2 / 3 / k**2 - 6 * float(mpmath.zeta(3)) / k**3
        assert pressure.coefficient_excess(k) == pytest.approx(series, rel=20 / k**2 + 1e-9)


@given(exponents, st.floats(1e-9, 1e3), st.floats(1e-6, 1e-1))
def test_the_pressure_carries_the_normal_force(k: float, N: float, a: float) -> None:
    def ring(s: float) -> float:  # r = a (1 - s^2): the steep edge becomes smooth
        r = a * (1 - s * s)
        return float(pressure.pressure(r, N, a, k)) * 2 * math.pi * r * 2 * a * s

    assert quad(ring, 0, 1, limit=200)[0] == pytest.approx(N, rel=1e-6)


@given(exponents, st.floats(1.001, 2))
def test_larger_exponents_are_flatter_and_hold_more_torque(k: float, factor: float) -> None:
    assert pressure.coefficient(k * factor) < pressure.coefficient(k)
    assert pressure.torsion_limit(k * factor) > pressure.torsion_limit(k)


def test_the_uniform_limit_is_reached_continuously() -> None:
    assert pressure.coefficient(1e8) == pytest.approx(pressure.coefficient(math.inf), abs=1e-12)
    assert pressure.torsion_limit(1e8) == pytest.approx(2 / 3, abs=1e-8)
    assert np.all(pressure.profile([0, 0.5, 0.99, 1], math.inf) == 1)


def test_exponent_one_is_a_cone() -> None:
    r = np.linspace(0, 1, 5)
    assert pressure.pressure(r, np.pi, 1.0, 1) == pytest.approx(3 * (1 - r), abs=1e-12)


def test_exponent_two_is_the_pressure_of_hertz() -> None:
    r = np.linspace(0, 2e-3, 7)
    hertz = 3 * 5.0 / (2 * np.pi * 2e-3**2) * np.sqrt(1 - (r / 2e-3) ** 2)
    assert pressure.pressure(r, 5.0, 2e-3, 2) == pytest.approx(hertz, rel=1e-13)


def test_there_is_no_pressure_outside_the_patch() -> None:
    assert np.all(pressure.pressure([1.001e-3, 5.0], 3.0, 1e-3, [2, 4]) == 0)
    assert np.all(pressure.matthews_pressure([1.001e-3, 5.0], 3.0, 1e-3, 2) == 0)


@pytest.mark.parametrize("n", [1, 1.5, 3, 10])
def test_matthews_carries_the_normal_force(n: float) -> None:
    with mpmath.workdps(20):
        q = 1 / (2 * mpmath.mpf(n))
        total = mpmath.quad(lambda r: (1 + q) * (1 - r * r) ** q * 2 * r, [0, 1])
    assert float(total) == pytest.approx(1, rel=1e-12)
    r = np.array([0.0, 0.4, 0.9])
    expected = (2 * n + 1) / (2 * n) * (1 - r**2) ** (1 / (2 * n))
    assert pressure.matthews_pressure(r, np.pi, 1.0, n) == pytest.approx(expected, rel=1e-13)


def test_matthews_without_hardening_is_hertz() -> None:
    r = np.linspace(0, 1, 9)
    matthews = pressure.matthews_pressure(r, 2.0, 1.0, 1)
    assert matthews == pytest.approx(pressure.pressure(r, 2.0, 1.0, 2), abs=1e-12)


def test_after_a_step_the_pressure_fades_like_the_force() -> None:
    g = Relaxation([0.3], [3.1])
    t = np.array([0.0, 0.5, np.inf])
    peak = pressure.pressure_after_step(0.0, t, np.pi, 1.0, 2, g)
    assert peak == pytest.approx([1.5, 1.145512, 1.05], abs=6e-7)


@pytest.mark.parametrize("k", [0.0, -1.0, math.nan])
def test_an_exponent_that_is_not_positive_is_refused(k: float) -> None:
    with pytest.raises(DomainError, match="exponent"):
        pressure.coefficient(k)


def test_a_uniform_pressure_reaches_to_the_edge_and_no_other_does() -> None:
    """Hardening without end is a uniform pressure, N/(pi a^2) up to r = a."""
    edge, beyond = pressure.matthews_pressure([3e-3, 3.001e-3], 2.0, 3e-3, math.inf)
    assert edge == pytest.approx(2.0 / (math.pi * 9e-6), rel=1e-12)
    assert beyond == 0.0
    assert pressure.matthews_pressure(3e-3, 2.0, 3e-3, 5.0) == 0.0
