"""Laws of the exact limit surface."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vegrip.contact.limit_surface import reference
from vegrip.errors import DomainError

exponents = st.floats(1.0, 50.0)
distances = st.floats(0.01, 20.0)
quarter = st.floats(0.0, np.pi / 2)


@settings(max_examples=40, deadline=None)
@given(k=st.floats(1.0, 8.0), d=st.floats(0.01, 20.0))
def test_two_independent_quadratures_agree(
    area_integral: Callable[..., tuple[float, float]], k: float, d: float
) -> None:
    assert np.hstack(reference.point(k, d)) == pytest.approx(area_integral(k, d), abs=2e-9)


@settings(max_examples=60, deadline=None)
@given(k=exponents, d=distances)
def test_force_is_the_derivative_of_the_dissipation(k: float, d: float) -> None:
    h = 1e-5 * d
    low, high = reference.support(k, [d - h, d + h])
    f, _ = reference.point(k, d)
    # f has a steep, not quite smooth, slope where the slip centre crosses the edge
    assert (high - low) / (2 * h) == pytest.approx(float(f), abs=1e-6)


@settings(max_examples=60, deadline=None)
@given(k=exponents, d=distances, e=distances, s=st.floats(0.0, 1.0))
def test_dissipation_is_convex(k: float, d: float, e: float, s: float) -> None:
    one, two, between = reference.support(k, [d, e, s * d + (1 - s) * e])
    assert between <= s * one + (1 - s) * two + 1e-10 * between


@settings(max_examples=60, deadline=None)
@given(k=exponents, d=distances, e=distances)
def test_no_point_of_the_surface_does_more_power_than_its_own_slip(k: float, d: float, e: float) -> None:
    f, m = reference.point(k, e)
    assert d * f + m <= reference.support(k, d) * (1 + 1e-11)


@settings(max_examples=60, deadline=None)
@given(k=exponents, d=distances, factor=st.floats(1.0, 10.0))
def test_flatter_pressure_holds_more(k: float, d: float, factor: float) -> None:
    sharp, flat = reference.support([k, k * factor], d)
    assert flat >= sharp * (1 - 1e-11)


@settings(max_examples=30, deadline=None)
@given(k=exponents, psi=quarter)
def test_radius_and_slip_centre_belong_together(k: float, psi: float) -> None:
    f, m = reference.point(k, reference.cor_distance(k, psi))
    assert np.arctan2(m, f) == pytest.approx(psi, abs=1e-9)
    assert reference.radius(k, psi) == pytest.approx(np.hypot(f, m), rel=1e-12)


def test_pure_force_and_pure_torsion_are_the_ends() -> None:
    k = np.array([1.0, 2.0, 50.0, np.inf])
    assert reference.point(k, np.inf) == (pytest.approx(np.ones(4)), pytest.approx(np.zeros(4)))
    f, m = reference.point(k, 0.0)
    assert f == pytest.approx(np.zeros(4), abs=1e-15)
    assert m == pytest.approx(reference.torsion_limit(k), rel=1e-12)
    assert reference.cor_distance(k, 0.0) == pytest.approx(np.full(4, np.inf))
    assert reference.cor_distance(k, np.pi / 2) == pytest.approx(np.zeros(4), abs=1e-15)


def test_large_exponents_tend_to_uniform_pressure() -> None:
    d = np.array([0.1, 0.5, 0.99, 1.0, 1.5, 10.0])
    uniform = np.stack(reference.point(np.inf, d))
    apart = [np.abs(np.stack(reference.point(k, d)) - uniform).max() for k in (10.0, 100.0, 1000.0, 1e6)]
    assert np.all(np.diff(apart) < 0)
    assert apart[-1] < 1e-10


def test_uniform_pressure_is_the_mean_over_the_disc() -> None:
    # far away every point slips across the line to the COR but for its angle: f -> 1 - <y^2>/(2 d^2)
    f, _ = reference.point(np.inf, 1e3)
    assert 1 - f == pytest.approx(0.25 / 2e6, rel=1e-5)


@pytest.mark.parametrize("d", [1 - 1e-9, 1 - 1e-14, 1.0, 1 + 1e-14, 1 + 1e-9])
def test_surface_is_smooth_where_the_slip_centre_crosses_the_edge(d: float) -> None:
    at_edge = 9 * np.pi / 32, 9 * np.pi / 128
    assert np.hstack(reference.point(2, d)) == pytest.approx(at_edge, abs=1e-8)


@pytest.mark.parametrize(("k", "d"), [(0.99, 1.0), (np.nan, 1.0), (2.0, -0.1), (2.0, np.nan)])
def test_outside_the_domain_is_refused(k: float, d: float) -> None:
    with pytest.raises(DomainError):
        reference.point(k, d)


@pytest.mark.parametrize("psi", [-0.1, 1.6, np.nan])
def test_load_angles_beyond_a_quarter_turn_are_refused(psi: float) -> None:
    with pytest.raises(DomainError):
        reference.radius(2.0, psi)
