"""Geometry against the sphere itself, cut by a plane."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.contact.geometry import contact_radius, indentation, local_depression, parabolic_radius
from vegrip.errors import DomainError

R = 8e-3
depths = st.floats(1e-9, R)


@given(depths)
def test_the_edge_of_the_patch_lies_on_the_sphere(delta: float) -> None:
    a = contact_radius(delta, R)
    assert np.hypot(a, R - delta) == pytest.approx(R, rel=1e-14)


@given(depths)
def test_indentation_undoes_contact_radius(delta: float) -> None:
    # near the equator the radius hardly depends on the depth: half the digits are lost there, not before
    assert indentation(contact_radius(delta, R), R) == pytest.approx(delta, rel=1e-7)


def test_the_centre_is_pressed_in_by_the_indentation_and_the_edge_not_at_all() -> None:
    delta = 0.3 * R
    a = contact_radius(delta, R)
    r = np.array([0.0, a / 2, a, 1.1 * a, 2 * R])
    depressed = local_depression(r, delta, R)
    assert depressed == pytest.approx([delta, delta - R + np.sqrt(R**2 - a**2 / 4), 0, 0, 0], abs=1e-17)


def test_the_paper_neglects_eleven_percent_of_the_area_at_a_fifth_of_the_radius() -> None:
    excess = parabolic_radius(0.2 * R, R) / contact_radius(0.2 * R, R)
    assert excess**2 - 1 == pytest.approx(0.111, abs=5e-4)
    assert excess - 1 == pytest.approx(0.054, abs=5e-4)


@given(depths, st.floats(0.5, 3))
def test_the_area_is_proportional_to_the_radius_factor(delta: float, kappa: float) -> None:
    assert parabolic_radius(delta, R, kappa) ** 2 == pytest.approx(kappa * R * delta, rel=1e-14)


def test_small_indentations_have_the_parabolic_radius() -> None:
    assert contact_radius(1e-10 * R, R) == pytest.approx(parabolic_radius(1e-10 * R, R), rel=1e-9)


@given(depths, st.floats(1.01, 2))
def test_more_indentation_gives_more_radius(delta: float, factor: float) -> None:
    deeper = min(delta * factor, R)
    if deeper > delta:
        assert contact_radius(deeper, R) >= contact_radius(delta, R)
        assert parabolic_radius(deeper, R) > parabolic_radius(delta, R)


@pytest.mark.parametrize(("delta", "radius"), [(-1e-9, R), (1.01 * R, R), (np.nan, R), (1e-3, 0.0)])
def test_a_depth_that_a_sphere_cannot_have_is_refused(delta: float, radius: float) -> None:
    with pytest.raises(DomainError):
        contact_radius(delta, radius)


def test_fingertips_of_different_size_broadcast() -> None:
    a = contact_radius(np.array([[1e-3], [2e-3]]), np.array([5e-3, 10e-3]))
    assert a.shape == (2, 2)
    assert a == pytest.approx(np.array([[3e-3, np.sqrt(19e-6)], [4e-3, 6e-3]]), rel=1e-14)
