"""Laws of the exact limit surface."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from vegrip.contact.limit_surface import fast, reference
from vegrip.contact.limit_surface.reference import AxisymmetricSurface, ring_mean
from vegrip.errors import DomainError

exponents = st.floats(1.0, 50.0)
distances = st.floats(0.01, 20.0)
quarter = st.floats(0.0, np.pi / 2)


@settings(max_examples=40, deadline=None)
@given(k=st.floats(1.0, 8.0), d=st.floats(0.01, 20.0))
def test_two_independent_quadratures_agree(
    area_integral: Callable[..., tuple[float, float]], k: float, d: float
) -> None:
    """The other one loses digits where a ray ends on the edge of the contact, near d = 1."""
    error = 2e-9 if abs(d - 1.0) > 0.05 else 3e-7
    assert np.hstack(reference.point(k, d)) == pytest.approx(area_integral(k, d), abs=error)


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


PSI = np.linspace(0, np.pi / 2, 9)


def test_thin_ring_carries_torque_at_its_radius() -> None:
    ring = AxisymmetricSurface(lambda r: np.where((r > 0.999) & (r < 1), 1.0, 0.0), knots=(0, 0.999, 1))
    assert ring.point(0.0)[1] == pytest.approx(0.9995, abs=1e-6)


def test_matthews_profile_of_first_order_is_hertz() -> None:
    surface = AxisymmetricSurface(lambda r: (1 - r**2) ** (1 / 2))
    f, m = surface.point(1.0)
    assert (f, m) == (pytest.approx(9 * np.pi / 32), pytest.approx(9 * np.pi / 128))


def test_profile_in_pieces_is_the_sum_of_its_pieces() -> None:
    # a disc of half the radius on a disc: the friction of a sum of pressures is the sum of the frictions
    stepped = AxisymmetricSurface(lambda r: np.where(r < 0.5, 3.0, 1.0), knots=(0, 0.5, 1))
    disc = AxisymmetricSurface(np.ones_like)
    inner = 2.0 * 0.25 / (2.0 * 0.25 + 1.0)
    for d in (0.2, 0.5, 0.8, 2.0):
        assert stepped.support(d) == pytest.approx(
            inner * 0.5 * disc.support(d / 0.5) + (1 - inner) * disc.support(d), rel=1e-10
        )


def test_pressure_nearer_to_the_centre_holds_less() -> None:
    flat = AxisymmetricSurface(np.ones_like).radius(PSI)
    peaked = AxisymmetricSurface(lambda r: (1 - r) ** 2).radius(PSI)
    assert np.all(peaked[1:] < flat[1:])
    assert (peaked[0], flat[0]) == pytest.approx((1.0, 1.0))


@pytest.mark.parametrize(
    ("profile", "knots"),
    [
        (lambda r: 0.5 - r, (0, 1)),
        (np.zeros_like, (0, 1)),
        (np.ones_like, (0.1, 1)),
        (np.ones_like, (0, 0.5)),
        (lambda r: np.abs(r - 0.5) - 0.1, (0, 0.4, 0.5, 0.6, 1)),
        (np.ones_like, (0, 0.7, 0.3, 1)),
        (np.ones_like, (0, 0.5, 0.5, 1)),
        (lambda r: np.full_like(r, np.inf), (0, 1)),
    ],
)
def test_unusable_profile_is_refused(profile, knots) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(DomainError):
        AxisymmetricSurface(profile, knots)


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
