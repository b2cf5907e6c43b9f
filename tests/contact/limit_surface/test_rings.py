import numpy as np
import pytest
from scipy.integrate import quad

from vegrip.contact.limit_surface.reference import ring_mean
from vegrip.errors import DomainError


@pytest.mark.parametrize("q", [1e-3, 0.1, 0.5, 0.9, 1.1, 2.0, 100.0])
def test_ring_mean_is_the_mean_over_the_angle(q: float) -> None:
    def slope(theta: float) -> float:
        return float((q - np.cos(theta)) / np.sqrt(1 + q * q - 2 * q * np.cos(theta)))

    mean, _ = quad(slope, 0, np.pi, epsabs=1e-13, limit=400)
    assert ring_mean(q) == pytest.approx(mean / np.pi, abs=1e-11)


def test_ring_mean_runs_from_none_to_all_of_the_friction() -> None:
    assert ring_mean([0.0, 1.0, np.inf]) == pytest.approx([0.0, 2 / np.pi, 1.0], rel=1e-15)


def test_ring_mean_keeps_its_relative_accuracy_at_small_ratios() -> None:
    q = np.array([1e-12, 1e-8, 1e-4])
    assert ring_mean(q) == pytest.approx(q / 2 * (1 + q**2 / 8), rel=1e-14)


def test_ring_mean_is_continuous_where_its_formula_changes() -> None:
    below, at, above = ring_mean([1 - 1e-12, 1.0, 1 + 1e-12])
    assert below == pytest.approx(at, abs=1e-10)
    assert above == pytest.approx(at, abs=1e-10)


def test_rough_integrand_is_refused() -> None:
    from vegrip.contact.limit_surface.reference import AxisymmetricSurface

    with pytest.raises(DomainError, match="knots"):
        AxisymmetricSurface(lambda r: np.where(r < 0.3, 1.0, 0.5))
