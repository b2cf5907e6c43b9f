"""The gauge of a pressure map and its two bounds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from vegrip.contact.limit_surface import queries, reference
from vegrip.contact.limit_surface.pressure_map import (
    TOLERANCE,
    PressureMap,
    bound_gauge,
    elliptical_map,
    map_gauge,
    polygon_map,
)
from vegrip.errors import DomainError

FEET = PressureMap([[0.03, 0.03], [0.09, 0.03], [0.03, 0.09]], [1.0, 1.0, 1.0])
seeds = st.integers(0, 2**32 - 1)


def any_map(rng: np.random.Generator) -> PressureMap:
    """Two to eight points somewhere, at any scale."""
    n, scale = rng.integers(2, 9), 10 ** rng.uniform(-6, 1)
    return PressureMap(scale * rng.normal(size=(n, 2)) + scale * rng.normal(size=2), rng.uniform(0.1, 1, n))


def any_load(rng: np.random.Generator, contact: PressureMap) -> np.ndarray:
    fx, fy, m = rng.normal(size=3)
    x, y = contact.centre
    return np.array([fx, fy, m * contact.size + x * fy - y * fx])


@settings(max_examples=150, deadline=None)
@given(seed=seeds)
def test_bounds_meet(seed: int) -> None:
    rng = np.random.default_rng(seed)
    contact = any_map(rng)
    bounds = bound_gauge(contact, any_load(rng, contact))
    assert bounds.lower <= bounds.upper * (1 + 1e-12)
    assert bounds.upper <= bounds.lower * (1 + 10 * TOLERANCE)


@settings(max_examples=60, deadline=None)
@given(seed=seeds)
def test_load_of_a_slip_has_gauge_one_and_that_slip(seed: int) -> None:
    rng = np.random.default_rng(seed)
    contact = any_map(rng)
    twist = rng.normal(size=3) * [contact.size, contact.size, 1.0]
    bounds = bound_gauge(contact, contact.load(twist))
    assert bounds.upper == pytest.approx(1.0, rel=1e-7)
    # the slip may not be unique (two feet in line with it), its power is
    power = contact.load(twist) @ bounds.twist
    assert power == pytest.approx(float(contact.support(bounds.twist)), rel=1e-7)


@settings(max_examples=60, deadline=None)
@given(seed=seeds, factor=st.floats(0.01, 100.0))
def test_gauge_is_proportional_to_the_load(seed: int, factor: float) -> None:
    rng = np.random.default_rng(seed)
    load = any_load(rng, FEET)
    assert map_gauge(FEET, factor * load) == pytest.approx(factor * map_gauge(FEET, load), rel=1e-8)


@settings(max_examples=60, deadline=None)
@given(seed=seeds)
def test_gauge_is_convex(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, two = any_load(rng, FEET), any_load(rng, FEET)
    assert map_gauge(FEET, one + two) <= map_gauge(FEET, one) + map_gauge(FEET, two) + 1e-8


def test_loads_on_a_facet_are_on_the_surface_exactly_with_one_slip() -> None:
    facet = FEET.facet(1, spin=-1.0)
    for friction in ([0.0, 0.0], [0.6, 0.0], [-0.5, 0.8]):
        bounds = bound_gauge(FEET, facet.centre + np.array(friction) @ facet.axes)
        assert bounds.lower == pytest.approx(1.0, abs=1e-12)
        assert bounds.upper == pytest.approx(1.0, abs=1e-12)
        assert FEET.velocities(bounds.twist)[1] == pytest.approx([0.0, 0.0], abs=1e-12)
        assert bounds.twist[2] < 0


@pytest.mark.parametrize(("f", "m"), [(0.3, 0.2), (0.8, 0.05), (0.05, 0.6), (0.0, 0.4), (0.7, 0.0)])
def test_round_map_gives_the_gauge_of_the_rings(f: float, m: float) -> None:
    a = 0.004
    contact = elliptical_map((a, a), 3.0)
    exact = np.hypot(f, m) / float(reference.radius(3.0, np.arctan2(m, f)))
    assert map_gauge(contact, [0.6 * f, -0.8 * f, m * a]) == pytest.approx(exact, rel=1e-5)
    assert float(queries.gauge(3.0, f, m)) == pytest.approx(exact, rel=3e-5)


def test_gauge_is_that_of_a_search_over_all_slip_centres() -> None:
    triangle = polygon_map([[0, 0], [0.15, 0], [0, 0.15]], order=10)
    load = np.array([0.3, 0.2, 0.01])
    grid = np.linspace(-0.3, 0.4, 201)
    x, y = np.meshgrid(grid, grid)
    twists = np.stack([y, -x, np.ones_like(x)], axis=-1).reshape(-1, 3)
    searched = np.max(np.abs(twists @ load) / triangle.support(twists))
    bounds = bound_gauge(triangle, load)
    assert searched <= bounds.upper
    assert searched == pytest.approx(bounds.upper, rel=1e-3)


def test_gauge_does_not_depend_on_where_the_origin_is() -> None:
    shift = np.array([0.2, -0.7])
    moved = PressureMap(FEET.positions + shift, FEET.shares)
    load = np.array([0.3, 0.2, 0.01])
    about_moved = load + np.array([0.0, 0.0, shift[0] * load[1] - shift[1] * load[0]])
    assert map_gauge(moved, about_moved) == pytest.approx(map_gauge(FEET, load), rel=1e-8)


def test_single_point_carries_force_but_no_torque() -> None:
    foot = PressureMap([[0.1, 0.2]], [5.0])
    through = [0.3, 0.4, 0.1 * 0.4 - 0.2 * 0.3]
    assert map_gauge(foot, through) == pytest.approx(0.5)
    assert map_gauge(foot, [0.3, 0.4, 0.0]) == np.inf


@pytest.mark.parametrize("load", [[0, 0, 0], [np.nan, 0, 1], [1, 0], [np.inf, 0, 0]])
def test_load_without_direction_is_refused(load: ArrayLike) -> None:
    with pytest.raises(DomainError):
        bound_gauge(FEET, load)
