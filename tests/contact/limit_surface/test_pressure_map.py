"""Limit surfaces of pressure maps: against the rings, against the definition, and three feet exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from vegrip.contact.limit_surface import queries, reference
from vegrip.contact.limit_surface.pressure_map import (
    TOLERANCE,
    PressureMap,
    _bounds,
    bound_gauge,
    elliptical_map,
    polygon_map,
    taxel_map,
)
from vegrip.errors import DomainError

FEET = PressureMap([[0.03, 0.03], [0.09, 0.03], [0.03, 0.09]], [1.0, 1.0, 1.0])
twists = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(lambda t: np.array(t) * [1.0, 1.0, 20.0])


def map_gauge(pressure: PressureMap, load: ArrayLike) -> float:
    return bound_gauge(pressure, load).upper


@settings(max_examples=60, deadline=None)
@given(one=twists, two=twists)
def test_no_load_does_more_power_than_the_one_of_the_slip(one: np.ndarray, two: np.ndarray) -> None:
    assert FEET.load(one) @ two <= FEET.support(two) + 1e-12
    assert FEET.load(one) @ one == pytest.approx(float(FEET.support(one)), abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(one=twists, two=twists)
def test_dissipation_is_convex(one: np.ndarray, two: np.ndarray) -> None:
    assert FEET.support(one + two) <= FEET.support(one) + FEET.support(two) + 1e-12


@settings(max_examples=60, deadline=None)
@given(twist=twists.filter(lambda t: float(FEET.support(t)) > 0.05))
def test_load_is_the_gradient_of_the_dissipation(twist: np.ndarray) -> None:
    speeds = np.linalg.norm(FEET.velocities(twist), axis=-1)
    if speeds.min() < 1e-2:
        return  # a foot at the slip centre: a kink, see the facets
    h = 1e-6 * np.array([1.0, 1.0, 20.0])
    slopes = [
        (FEET.support(twist + step) - FEET.support(twist - step)) / (2 * step.sum()) for step in np.diag(h)
    ]
    assert np.array(slopes) == pytest.approx(FEET.load(twist), abs=1e-6)


def test_twists_are_taken_in_batches() -> None:
    batch = np.random.default_rng(0).normal(size=(2, 5, 3))
    assert FEET.support(batch).shape == (2, 5)
    assert FEET.load(batch)[1, 3] == pytest.approx(FEET.load(batch[1, 3]))


def test_spin_about_a_foot_leaves_the_friction_of_that_foot_open() -> None:
    facet = FEET.facet(0, spin=1.0)
    about_foot = np.array([0.03, -0.03, 1.0])
    assert FEET.velocities(about_foot)[0] == pytest.approx([0.0, 0.0])
    for angle in np.linspace(0, 2 * np.pi, 9):
        load = facet.centre + np.array([np.cos(angle), np.sin(angle)]) @ facet.axes
        # the whole facet does the same power: it is a flat piece of the surface
        assert load @ about_foot == pytest.approx(float(FEET.support(about_foot)), rel=1e-12)


def test_slips_next_to_a_foot_end_on_the_rim_of_its_facet() -> None:
    facet = FEET.facet(2, spin=-1.0)
    x, y = FEET.positions[2]
    for angle in (0.1, 2.0, 4.0):
        near = np.array([x, y]) + 1e-9 * np.array([np.cos(angle), np.sin(angle)])
        load = FEET.load([-near[1], near[0], -1.0])
        friction, *_ = np.linalg.lstsq(facet.axes.T, load - facet.centre)
        assert np.linalg.norm(friction) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("k", [1.0, 2.0, 3.0, 20.0])
def test_round_map_reduces_to_the_rings(k: float) -> None:
    a = 0.004
    contact = elliptical_map((a, a), k)
    d = np.array([0.0, 0.1, 0.5, 0.9, 1.0, 1.5, 5.0])
    twist = np.stack([0 * d, -a * d, 0 * d + 1], axis=1)  # about the point (a d, 0)
    f, m = reference.point(k, d)
    assert contact.support(twist) / a == pytest.approx(reference.support(k, d), rel=1e-5)
    assert contact.load(twist) == pytest.approx(np.stack([0 * d, -f, m * a], axis=1), abs=5e-4)


def test_points_of_an_ellipse_stand_evenly_in_rings_that_are_turned_by_the_golden_part_of_a_sector() -> None:
    x, y = (elliptical_map((2e-3, 1e-3)).positions / [2e-3, 1e-3]).T.reshape(2, 40, 96)
    sectors = np.unwrap(np.arctan2(y, x), axis=1) / (2.0 * np.pi / 96.0)
    assert np.diff(sectors, axis=1) == pytest.approx(np.ones((40, 95)))
    turned = sectors[:, 0] - 0.5 - 0.618034 * np.arange(40)
    assert turned == pytest.approx(np.round(turned), abs=1e-9)
    assert np.hypot(x, y).std(axis=1) == pytest.approx(np.zeros(40), abs=1e-12)


def test_a_map_has_as_many_points_as_its_order_says() -> None:
    assert len(taxel_map([[0.0, 0.0]], [1.0], pitch=2.0).shares) == 9
    assert len(polygon_map([[0, 0], [1, 0], [1, 1], [0, 1]]).shares) == 2 * 48**2


def test_ellipse_is_a_stretched_circle_in_translation_and_turns_with_its_axes() -> None:
    flat, upright = elliptical_map((0.008, 0.004)), elliptical_map((0.004, 0.008))
    assert flat.load([1.0, 0.0, 0.0]) == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    spin = np.array([0.002, 0.001, 1.0])
    turned = np.array([-0.001, 0.002, 1.0])  # the same slip a quarter turn on
    assert flat.support(spin) == pytest.approx(float(upright.support(turned)), rel=1e-5)


def test_torsion_of_a_square_taxel_is_the_mean_distance_from_its_centre() -> None:
    one = taxel_map([[0.0, 0.0]], [3.0], pitch=2.0, order=40)
    mean_distance = (np.sqrt(2) + np.log(1 + np.sqrt(2))) / 3  # of a square of side 2
    assert one.load([0.0, 0.0, 1.0])[2] == pytest.approx(mean_distance, rel=1e-4)


def test_tactile_array_approaches_the_contact_it_measures() -> None:
    a, pitch = 0.004, 0.0005
    grid = (np.arange(-8, 8) + 0.5) * pitch
    centres = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    r2 = (centres**2).sum(axis=1) / a**2
    array = taxel_map(centres, np.sqrt(np.maximum(1 - r2, 0)), pitch)
    for d in (0.0, 0.5, 1.5):
        support = array.support([0.0, -a * d, 1.0]) / a
        assert support == pytest.approx(float(reference.support(2.0, d)), rel=0.01)


def test_polygon_carries_its_area_at_its_centroid() -> None:
    triangle = polygon_map([[0, 0], [0.15, 0], [0, 0.15]])
    assert triangle.centre == pytest.approx([0.05, 0.05], rel=1e-12)
    assert triangle.shares.sum() == pytest.approx(1.0)
    square = polygon_map([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    mean_distance = (np.sqrt(2) + np.log(1 + np.sqrt(2))) / 3
    assert square.load([0.0, 0.0, 1.0])[2] == pytest.approx(2 * mean_distance / 2, rel=1e-3)


def test_points_without_force_do_not_count() -> None:
    with_idle = PressureMap([[0, 0], [1, 0], [5, 5]], [1, 1, 0])
    assert len(with_idle.shares) == 2
    assert with_idle.centre == pytest.approx([0.5, 0.0])


@pytest.mark.parametrize(
    ("positions", "forces"),
    [
        ([[0, 0, 0]], [1]),
        ([[0, 0], [1, 1]], [1]),
        ([[0, 0]], [0]),
        ([[0, 0], [1, 0]], [1, -1]),
        ([[0, np.nan]], [1]),
        ([[0, 0]], [np.nan]),
    ],
)
def test_impossible_map_is_refused(positions: ArrayLike, forces: ArrayLike) -> None:
    with pytest.raises(DomainError):
        PressureMap(positions, forces)


def test_impossible_shapes_are_refused() -> None:
    for build in (
        lambda: elliptical_map((0.0, 1.0)),
        lambda: elliptical_map((1.0, 1.0), k=0.5),
        lambda: polygon_map([[0, 0], [1, 1]]),
        lambda: taxel_map([[0, 0]], [1, 2], 0.1),
        lambda: taxel_map([[0, 0, 0]], [1], 0.1),
        lambda: taxel_map([[0], [0]], [1, 1], 0.1),
        lambda: taxel_map([[0, 0]], [1], 0.0),
    ):
        with pytest.raises(DomainError):
            build()


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


@settings(max_examples=15, deadline=None)
@given(seed=seeds, far=st.floats(1.0, 100.0))
def test_every_slip_bounds_the_gauge_from_both_sides(seed: int, far: float) -> None:
    """Also where one light point is so far from all others that it alone resists a torque."""
    rng = np.random.default_rng(seed)
    points, shares = rng.normal(size=(5, 2)) / far, np.full(5, far**2)
    points[0], shares[0] = far * np.exp(rng.normal(size=2)) * -1.0, 1.0
    contact = PressureMap(points, shares)
    contact = PressureMap((contact.positions - contact.centre) / contact.size, contact.shares)
    load, twist = rng.normal(size=3), rng.normal(size=3)
    exact = map_gauge(contact, load)
    for smooth in (1.0, 0.1, 1e-3):
        found = _bounds(contact, load, twist / (load @ twist), smooth)
        assert found.lower <= exact * (1.0 + 1e-8)
        assert found.upper >= exact * (1.0 - 1e-8)


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
    assert bound_gauge(foot, through).twist == pytest.approx([0.6, 0.8, 0.0])
    assert map_gauge(foot, [0.3, 0.4, through[2] * (1.0 + 0.9e-12)]) == pytest.approx(0.5)  # of rounding
    for moment in (-0.02, 0.02, 1.1e-12 * through[2]):  # [m] about the foot, which does not move
        lower, upper, twist = bound_gauge(foot, [0.3, 0.4, through[2] + moment])
        assert lower == upper == np.inf
        assert twist[2] == np.sign(moment)
        assert foot.velocities(twist) == pytest.approx(np.zeros((1, 2)))


@pytest.mark.parametrize("load", [[0, 0, 0], [np.nan, 0, 1], [1, 0], [np.inf, 0, 0]])
def test_load_without_direction_is_refused(load: ArrayLike) -> None:
    with pytest.raises(DomainError):
        bound_gauge(FEET, load)


@pytest.mark.parametrize(
    "forces", [[np.inf, 1.0], [np.inf, np.inf], [1e308, 1e308], [np.nan, 1.0], [0.0, 0.0]]
)
@pytest.mark.filterwarnings("ignore:overflow")
def test_a_map_whose_forces_have_no_finite_sum_above_0_is_refused(forces: list[float]) -> None:
    with pytest.raises(DomainError, match="finite positions and forces >= 0"):
        PressureMap([[0.0, 0.0], [1e-3, 0.0]], forces)
