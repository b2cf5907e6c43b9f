"""The paper's fits: golden coefficients, and the properties that make them what they are."""

import numpy as np
import pytest
from scipy.optimize import minimize

from vegrip.contact.paper.tables import (
    CANONICAL_K,
    RadiusFit,
    Weights,
    fit_power,
    fit_radius,
    fit_radius_directly,
)
from vegrip.contact.pressure import coefficient
from vegrip.errors import DomainError

DIGITS = 6e-7

# samples, weights, A, B, largest error of 1/sqrt(C), a/a0 at k = 2 and k = 4
GOLDEN_RADIUS = [
    (CANONICAL_K, "equal", 0.489281, 0.513983, 8.5e-3, 1.010375, 1.148058),
    (CANONICAL_K, "y", 0.504458, 0.524327, 6.7e-3, 1.008251, 1.148883),
    (CANONICAL_K, "y^2", 0.519550, 0.534980, 5.3e-3, 1.006474, 1.149873),
    (np.linspace(2, 4, 5), "y^2", 0.533128, 0.541112, 3.9e-3, 1.003500, 1.149778),
    (np.linspace(2, 4, 9), "y^2", 0.525831, 0.538093, 4.3e-3, 1.005206, 1.149906),
    (np.array([2.0, 3.0, 4.0]), "y^2", 0.536580, 0.539590, 4.2e-3, 1.001388, 1.148832),
]

# samples, B, ln A, A, alpha, beta, k(h=1), k(h=1.3)
GOLDEN_POWER = [
    (CANONICAL_K, -1.790844, 0.543762, 1.722474, 1.354774, -0.558396, 1.99508, 3.85296),
    (np.arange(2, 11), -1.800139, 0.557029, 1.745479, 1.362657, -0.555513, 2.00268, 3.85452),
    (np.arange(1, 11), -1.842654, 0.634857, 1.886752, 1.411332, -0.542695, 2.05588, 3.89757),
]


def largest_error(fit: RadiusFit, k: np.ndarray) -> float:
    return float(np.max(np.abs(fit.inverse_root(k) - coefficient(k) ** -0.5)))


@pytest.mark.parametrize(("k", "weights", "A", "B", "error", "at_2", "at_4"), GOLDEN_RADIUS)
def test_radius_fit_has_the_golden_digits(
    k: np.ndarray, weights: Weights, A: float, B: float, error: float, at_2: float, at_4: float
) -> None:
    fit = fit_radius(k, weights)
    assert pytest.approx((A, B), abs=DIGITS) == (fit.A, fit.B)
    assert (float(fit.radius_ratio(2)), float(fit.radius_ratio(4))) == pytest.approx((at_2, at_4), abs=DIGITS)
    assert largest_error(fit, k) == pytest.approx(error, abs=6e-5)


@pytest.mark.parametrize(("k", "B", "ln_A", "A", "alpha", "beta", "at_1", "at_end"), GOLDEN_POWER)
def test_power_fit_has_the_golden_digits(
    k: np.ndarray, B: float, ln_A: float, A: float, alpha: float, beta: float, at_1: float, at_end: float
) -> None:
    fit = fit_power(k)
    assert (fit.B, np.log(fit.A), fit.A, fit.alpha, fit.beta) == pytest.approx(
        (B, ln_A, A, alpha, beta), abs=DIGITS
    )
    assert fit.exponent([1.0, 1.3]) == pytest.approx([at_1, at_end], abs=6e-6)


def test_direct_fits_have_the_golden_digits() -> None:
    two = fit_radius_directly()
    assert pytest.approx((0.520087, 0.535629), abs=DIGITS) == (two.A, two.B)
    assert largest_error(two, CANONICAL_K) == pytest.approx(5.3e-3, abs=6e-5)
    three = fit_radius_directly(offset=True)
    assert pytest.approx((0.730568, 0.803602, 0.963640), abs=2e-6) == (three.A, three.B, three.D)
    assert largest_error(three, CANONICAL_K) == pytest.approx(7.0e-4, abs=6e-6)


def test_weighted_fit_is_the_least_of_its_weighted_sum() -> None:
    y = 1 - coefficient(CANONICAL_K) ** -0.5

    def cost(p: np.ndarray) -> float:
        return float(np.sum((y * (p[0] - p[1] * CANONICAL_K - np.log(y))) ** 2))

    best = minimize(cost, [-0.5, 0.5], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-18}).x
    fit = fit_radius()
    assert (np.log(fit.A), fit.B) == pytest.approx(best, abs=1e-6)


def test_two_parameters_cannot_pass_through_one_at_the_first_exponent() -> None:
    assert fit_radius().radius_ratio(2) - 1 == pytest.approx(0.0065, abs=5e-5)
    assert fit_radius_directly(offset=True).radius_ratio(2) == pytest.approx(1, abs=1e-3)


def test_equation_40_undoes_equation_38() -> None:
    fit = fit_power()
    k = np.linspace(2, 10, 17)
    assert fit.exponent(1.5 / fit.coefficient(k)) == pytest.approx(k, rel=1e-12)


def test_fits_are_not_extrapolated() -> None:
    with pytest.raises(DomainError):
        fit_radius().radius_ratio(4.5)
    with pytest.raises(DomainError):
        fit_power().exponent(1.5)
    assert fit_power().exponent(1.1e-3) < 0.1
    with pytest.raises(DomainError):
        fit_power().exponent(0.9e-3)
