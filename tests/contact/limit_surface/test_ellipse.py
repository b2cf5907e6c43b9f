"""The usual ellipse (f)^2 + (m/m_max)^2 = 1 is outside the surface everywhere: unsafe for slip margins."""

import numpy as np
import pytest

from vegrip.contact.limit_surface import fast, reference


@pytest.mark.parametrize(("k", "percent"), [(2, 6.00), (3, 6.27), (4, 6.39), (8, 6.54)])
def test_surface_falls_short_of_the_ellipse_by_the_known_percentage(k: int, percent: float) -> None:
    f, m = reference.point(k, np.tan(np.linspace(0.01, 1.56, 400)))
    short = 1 - np.hypot(f, m / reference.torsion_limit(k))
    assert short.min() > 0
    assert 100 * short.max() == pytest.approx(percent, abs=0.01)


@pytest.mark.parametrize("k", [1.0, 2.0, 8.0, 50.0])
def test_fast_surface_stays_inside_the_ellipse(k: float) -> None:
    psi = np.linspace(0.01, 1.56, 200)
    ellipse = 1 / np.hypot(np.cos(psi), np.sin(psi) / fast.torsion_limit(k))
    assert np.all(fast.radii(np.full_like(psi, k), psi) < ellipse)
