"""The compiled limit surface: its error bound with sign, its derivatives, its laws."""

import ast
import inspect
import math
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vegrip.contact.limit_surface import fast, queries, reference
from vegrip.errors import DomainError

exponents = st.floats(1.0, 50.0)
loads = st.floats(0.0, 2.0).map(lambda load: load if load > 1e-9 else 0.0)
INSIDE = 2.5e-5  # how far the fast radius may be below the true one; the promise is 1e-4
OUTSIDE = 2e-8  # how far above


def dense_grid() -> tuple[np.ndarray, np.ndarray]:
    """Exponents 1 .. 50 and beyond, slip centres that give load angles all over the quarter turn."""
    exponents = np.append(1.0 / np.linspace(0.02, 1.0, 45), [100.0, 1e4, np.inf])
    angles = np.tan(np.linspace(1e-3, np.pi / 2 - 1e-3, 160))
    near_edge = 1.0 + np.linspace(-0.1, 0.1, 41)
    k, d = np.meshgrid(exponents, np.concatenate([angles, near_edge]))
    return k.ravel(), d.ravel()


def test_radius_is_never_outside_the_true_surface_and_hardly_inside() -> None:
    assert agrees(fast.gauges, *dense_grid())


def agrees(gauges: Callable[..., np.ndarray], k: np.ndarray, d: np.ndarray) -> bool:
    """Return whether gauges are those of the reference, for exponents and slip centres."""
    error = 1.0 / gauges(k, *reference.point(k, d)) - 1.0  # the true gauge of these points is 1
    return bool(error.max() <= OUTSIDE and error.min() >= -INSIDE)


@pytest.mark.parametrize(
    "part", ["TORSION_TABLE[0]", "TORSION_TABLE[3]", "RADIUS_TABLE[0, 0]", "RADIUS_TABLE[3, 7]"]
)
def test_a_number_of_a_table_that_is_a_hundredth_off_is_a_difference(part: str) -> None:
    k, d = (one[::61] for one in dense_grid())
    names: dict[str, Any] = {}
    exec(inspect.getsource(fast).replace("@njit", ""), names)  # noqa: S102
    gauges = np.vectorize(names["gauge"])
    assert agrees(gauges, k, d)
    exec(f"{part} *= 1.01", names)  # noqa: S102
    assert not agrees(gauges, k, d)


def test_radius_against_thirty_digits() -> None:
    rng = np.random.default_rng(7)
    for k, d in zip(1 / rng.uniform(0.02, 1, 20), np.tan(rng.uniform(0, np.pi / 2, 20)), strict=True):
        f, m = thirty_digits(k, d)
        error = float(fast.radius(k, float(mp.atan2(m, f))) / mp.hypot(f, m) - 1)
        assert -INSIDE <= error <= OUTSIDE


def thirty_digits(k: float, d: float) -> tuple[mp.mpf, mp.mpf]:
    """Point of the surface by the ring integrals in their textbook form."""
    with mp.workdps(30):
        k, d = mp.mpf(k), mp.mpf(d)
        C = 3 * k / 2 * mp.gamma(3 / k) / (mp.gamma(1 / k) * mp.gamma(2 / k))

        def rings(r: mp.mpf, sign: int) -> mp.mpf:
            modulus = 1 - ((r - d) / (r + d)) ** 2
            across = (r + d) * mp.ellipe(modulus)
            along = (r - d) * mp.ellipk(modulus) if modulus != 1 else 0  # the limit of 0 times infinity
            return C / mp.pi * (1 - r**k) ** (1 / k) * r * 2 * (across + sign * along)

        ends = sorted({mp.mpf(0), min(d, mp.mpf(1)), mp.mpf(1)})
        return mp.quad(lambda r: rings(r, -1), ends) / d, mp.quad(lambda r: rings(r, 1), ends)


def test_support_is_never_above_the_true_one_and_hardly_below() -> None:
    k, d = (part[::41] for part in dense_grid())
    error = np.vectorize(fast.support)(k, d, 1.0) / reference.support(k, d) - 1.0
    assert error.max() <= 1e-7
    assert error.min() >= -4.1e-5


def test_pure_force_and_pure_torsion_are_exact() -> None:
    for k in (1.0, 1.7, 2.0, 3.0, 50.0, math.inf):
        assert fast.radius(k, 0.0) == pytest.approx(1.0, rel=1e-15)
        assert fast.torsion_limit(k) == pytest.approx(float(reference.torsion_limit(k)), rel=2e-11)
        assert fast.gauge(k, 0.0, fast.torsion_limit(k)) == pytest.approx(1.0, rel=1e-15)


def test_slip_direction_and_point_of_a_slip_centre() -> None:
    k, d = (part[::7] for part in dense_grid())
    f, m = reference.point(k, d)
    for row in zip(k, d, f, m, strict=True):
        k_i, d_i, f_i, m_i = map(float, row)
        assert math.atan(fast.cor_distance(k_i, f_i, m_i)) == pytest.approx(math.atan(d_i), abs=7e-4)
        assert fast.point(k_i, d_i) == pytest.approx((f_i, m_i), abs=1e-3)
        assert fast.support(k_i, d_i, 1.0) == pytest.approx(d_i * f_i + m_i, rel=5e-5)


@settings(max_examples=100, deadline=None)
@given(k=exponents, f=loads, m=loads, factor=st.floats(0.01, 100.0))
def test_gauge_is_proportional_to_the_load(k: float, f: float, m: float, factor: float) -> None:
    assert fast.gauge(k, factor * f, factor * m) == pytest.approx(factor * fast.gauge(k, f, m), rel=1e-12)


@settings(max_examples=100, deadline=None)
@given(k=exponents, f=loads, m=loads)
def test_gauge_does_not_know_directions(k: float, f: float, m: float) -> None:
    assert fast.gauge(k, f, m) == fast.gauge(k, -f, m) == fast.gauge(k, f, -m)


@settings(max_examples=200, deadline=None)
@given(k=exponents, one=st.tuples(loads, loads), two=st.tuples(loads, loads))
def test_gauge_is_convex(k: float, one: tuple[float, float], two: tuple[float, float]) -> None:
    together = fast.gauge(k, one[0] + two[0], one[1] + two[1])
    assert together <= (fast.gauge(k, *one) + fast.gauge(k, *two)) * (1 + 2 * INSIDE)


@settings(max_examples=100, deadline=None)
@given(k=exponents, factor=st.floats(1.0, 5.0), psi=st.floats(0.0, math.pi / 2))
def test_flatter_pressure_holds_more(k: float, factor: float, psi: float) -> None:
    assert fast.radius(k * factor, psi) >= fast.radius(k, psi) * (1 - INSIDE)


@settings(max_examples=100, deadline=None)
@given(k=exponents, psi=st.floats(0.0, math.pi / 2), chi=st.floats(0.0, math.pi / 2))
def test_support_is_the_greatest_power_over_the_surface(k: float, psi: float, chi: float) -> None:
    r = fast.radius(k, psi)
    power = r * math.cos(psi) * math.cos(chi) + r * math.sin(psi) * math.sin(chi)
    assert power <= fast.support(k, math.cos(chi), math.sin(chi)) * (1 + 5e-5)


@settings(max_examples=100, deadline=None)
@given(k=st.floats(1.01, 50.0), f=st.floats(0.01, 2.0), m=st.floats(0.01, 2.0))
def test_gauge_gradient_is_the_slope_of_the_gauge(k: float, f: float, m: float) -> None:
    value, *slopes = fast.gauge_gradient(k, f, m)
    assert value == pytest.approx(fast.gauge(k, f, m), rel=1e-13)
    for i, slope in enumerate(slopes):
        assert slope == pytest.approx(_difference(fast.gauge, (k, f, m), i), abs=2e-7 * value)
    assert f * slopes[1] + m * slopes[2] == pytest.approx(value, rel=1e-12)  # Euler: degree one


@settings(max_examples=100, deadline=None)
@given(k=st.floats(1.01, 50.0), psi=st.floats(0.01, 1.56))
def test_radius_gradient_is_the_slope_of_the_radius(k: float, psi: float) -> None:
    value, *slopes = fast.radius_gradient(k, psi)
    assert value == pytest.approx(fast.radius(k, psi), rel=1e-13)
    for i, slope in enumerate(slopes):
        assert slope == pytest.approx(_difference(fast.radius, (k, psi), i), abs=2e-7)


@pytest.mark.parametrize("k", [1.0, 1.3, 2.0, 5.0, 49.0])
def test_the_gradient_of_the_torsion_limit_is_its_slope_from_the_least_exponent_on(k: float) -> None:
    """By the reference, forwards to second order, as no smaller exponent than 1 has a limit."""
    h = 1e-4 * k
    here, near, far = (float(reference.torsion_limit(k + n * h)) for n in range(3))
    value, slope = fast.torsion_gradient(k)
    assert value == pytest.approx(here, rel=2e-11)
    assert slope == pytest.approx((4.0 * near - 3.0 * here - far) / (2.0 * h), rel=1e-6)


@settings(max_examples=100, deadline=None)
@given(k=exponents, v=st.floats(0.01, 2.0), omega=st.floats(0.01, 2.0))
def test_load_of_a_slip_is_the_slope_of_the_support(k: float, v: float, omega: float) -> None:
    value, f, m = fast.support_gradient(k, v, omega)
    assert f == pytest.approx(_difference(fast.support, (k, v, omega), 1), abs=2e-7)
    assert m == pytest.approx(_difference(fast.support, (k, v, omega), 2), abs=2e-7)
    assert v * f + omega * m == pytest.approx(value, rel=1e-12)


def _difference(function: Callable[..., float], at: tuple[float, ...], index: int) -> float:
    h = 1e-6 * max(1.0, at[index])
    low, high = ([x + s * h * (i == index) for i, x in enumerate(at)] for s in (-1, 1))
    return (function(*high) - function(*low)) / (2 * h)


@pytest.mark.parametrize("k", [0.999, -1.0, math.nan])
def test_exponent_outside_the_domain_gives_nan(k: float) -> None:
    results = [
        fast.gauge(k, 0.5, 0.5),
        fast.radius(k, 0.5),
        fast.torsion_limit(k),
        *fast.gauge_gradient(k, 0.5, 0.5),
        *fast.support_gradient(k, 1.0, 1.0),
        *fast.point(k, 1.0),
        fast.cor_distance(k, 0.5, 0.5),
    ]
    assert all(map(math.isnan, results))


def test_missing_load_gives_nan_and_endless_load_an_endless_gauge() -> None:
    assert math.isnan(fast.gauge(2.0, math.nan, 0.1))
    assert math.isnan(fast.gauge(2.0, 0.1, math.nan))
    assert fast.gauge(2.0, math.inf, 0.1) == math.inf


def test_batches_are_the_single_queries() -> None:
    rng = np.random.default_rng(3)
    k, f, m = rng.uniform(1, 9, 50), rng.uniform(0, 1, 50), rng.uniform(0, 1, 50)
    assert fast.gauges(k, f, m).tolist() == [fast.gauge(*row) for row in zip(k, f, m, strict=True)]
    assert fast.radii(k, f).tolist() == [fast.radius(*row) for row in zip(k, f, strict=True)]


def test_the_file_imports_nothing_compiled_from_elsewhere() -> None:
    """numba's disk cache would then serve stale code after an edit of the other file."""
    tree = ast.parse(inspect.getsource(fast))
    imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert imported == {"numpy.typing", "vegrip.compiled"}


def test_source_runs_uncompiled_with_the_same_results() -> None:
    plain = inspect.getsource(fast).replace("@njit", "")
    names: dict[str, Callable[..., float]] = {}
    exec(compile(plain, "plain", "exec"), names)  # noqa: S102
    for args in ((1.3, 0.2, 0.6), (2.5, 0.9, 0.1), (40.0, 0.5, 0.5)):
        assert names["gauge_gradient"](*args) == pytest.approx(fast.gauge_gradient(*args), rel=1e-12)
        assert names["point"](args[0], args[1]) == pytest.approx(fast.point(args[0], args[1]), rel=1e-12)
    assert names["least_normal_force"](1.0, 0.01, 0.5, 0.005, 2.0, 1.0, 0.3, 0.0) == pytest.approx(
        fast.least_normal_force(1.0, 0.01, 0.5, 0.005, 2.0, 1.0, 0.3, 0.0), rel=1e-12
    )


@pytest.mark.parametrize("load", [(math.inf, 0.0), (0.1, math.inf), (math.nan, 0.1)])
def test_a_load_that_is_no_number_has_no_gradient(load: tuple[float, float]) -> None:
    gauge, *gradient = fast.gauge_gradient(2.0, *load)
    assert gauge == math.inf or math.isnan(sum(load))
    assert all(math.isnan(one) for one in gradient)
    support, f, m = fast.support_gradient(2.0, *load)
    assert support == math.inf or math.isnan(sum(load))
    assert math.isnan(f)
    assert math.isnan(m)


def test_a_slip_that_does_not_turn_has_its_centre_nowhere_and_one_about_the_contact_is_torsion() -> None:
    assert fast.cor_distance(2.0, 0.5, 0.0) == math.inf
    assert fast.point(2.0, math.inf) == (1.0, 0.0)
    assert fast.point(2.0, 0.0) == (0.0, fast.torsion_limit(2.0))


def test_no_load_has_a_gauge_and_gradient_of_zero() -> None:
    assert fast.gauge(2.0, 0.0, 0.0) == 0.0
    assert fast.gauge_gradient(2.0, 0.0, 0.0) == (0.0, 0.0, 0.0, 0.0)
    assert fast.support_gradient(2.0, 0.0, 0.0) == (0.0, 0.0, 0.0)


def test_queries_broadcast() -> None:
    assert queries.gauge([2, 3], [[0.1], [0.2], [0.3]], 0.1).shape == (3, 2)
    assert queries.radius([2, 3, 4], 0.3).shape == (3,)
    assert queries.gauge(2, 0.1, 0.1).shape == ()


def test_point_of_a_slip_centre_is_on_the_surface_and_gives_it_back() -> None:
    d = np.array([0.0, 0.3, 1.0, 4.0, np.inf])
    f, m = queries.point(2.5, d)
    assert queries.gauge(2.5, f, m) == pytest.approx(np.ones(5), abs=3e-5)
    assert np.arctan(queries.cor_distance(2.5, f, m)) == pytest.approx(np.arctan(d), abs=1e-3)


def test_inside_and_outside() -> None:
    f, m = queries.point(2.0, [0.2, 1.0, 3.0])
    assert queries.is_inside(2.0, 0.999 * f, 0.999 * m).all()
    assert not queries.is_inside(2.0, 1.001 * f, 1.001 * m).any()
    assert not queries.is_inside(2.0, 1.0, 0.0), "a gauge of 1 is on the surface"


def test_slip_follows_the_signs_of_the_load() -> None:
    v, omega = queries.slip_twist(2.0, [0.4, -0.4], [-0.3, 0.3])
    assert v[0] == -v[1] > 0
    assert omega[0] == -omega[1] < 0
    assert np.hypot(v, omega) == pytest.approx([1, 1])


def test_support_of_a_slip_is_its_dissipation() -> None:
    assert queries.support(3.0, 0.7, 1.0) == pytest.approx(float(reference.support(3.0, 0.7)), rel=5e-5)
    assert queries.support(3.0, 1.4, -2.0) == pytest.approx(2 * float(queries.support(3.0, 0.7, 1.0)))


@pytest.mark.parametrize(
    "question",
    [
        lambda: queries.gauge(0.9, 0.1, 0.1),
        lambda: queries.gauge(2.0, np.nan, 0.1),
        lambda: queries.gauge(2.0, 0.1, np.inf),
        lambda: queries.radius(2.0, 1.6),
        lambda: queries.point(2.0, -1.0),
        lambda: queries.support(np.nan, 1.0, 1.0),
        lambda: queries.slip_twist(2.0, 0.0, 0.0),
        lambda: queries.cor_distance(2.0, [0.1, 0.0], [0.1, 0.0]),
    ],
)
def test_outside_the_domain_is_refused(question) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(DomainError):
        question()
