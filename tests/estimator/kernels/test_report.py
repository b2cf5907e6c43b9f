"""Standard deviations of what is derived, against differences of the quantity itself."""

import math

import numpy as np
import pytest

from vegrip.contact.limit_surface import fast


def columns(kernels, m):
    """Return D, (N, a, k, friction, delta, t) by columns of independent unit variables."""
    count = kernels.M + kernels.N_CONSIDERED + 1
    names = ("D_FORCE0", "D_RADIUS0", "D_EXPONENT0", "D_FRICTION0", "D_DELTA0", "D_SHAPE0")
    return np.array([m[getattr(kernels, name) : getattr(kernels, name) + count] for name in names])


def reported(kernels, m, load=0.4, torque=1e-3):
    kernels.report(m, load, torque)
    at = np.array([m[kernels.REP_FORCE], m[kernels.REP_RADIUS], m[kernels.REP_EXPONENT], m[kernels.REP_MU]])
    return at, columns(kernels, m)


def spread(quantity, at, D):
    """Return quantity and its standard deviation, by differences along each column, without bends."""
    small = 1e-3
    changes = [(quantity(*(at + small * d)) - quantity(*(at - small * d))) / (2.0 * small) for d in D[:4].T]
    return quantity(*at), math.hypot(*changes)


def std_with_force(quantity, at, D):
    """Return what the force explains of the standard deviation of a quantity, by differences."""
    small = 1e-3
    changes = [(quantity(*(at + small * d)) - quantity(*(at - small * d))) / (2.0 * small) for d in D[:4].T]
    return abs(np.dot(changes, D[0])) / float(np.linalg.norm(D[0]))


def test_an_exponent_that_may_be_anything_moves_the_limit_surface_by_no_more_than_there_is(
    kernels, m
) -> None:
    """At the end of its law k is 180 in one step, and its derivative there says nothing."""
    kernels.note_difference(m, 0, (1.0, 1e-3, 180.0, 0.5), (1.0, 1e-3, 2.0, 0.5), 2.8)
    assert m[kernels.D_EXPONENT0] == pytest.approx(177.2 / kernels.WIDE)
    change = m[kernels.D_SHAPE0] * kernels.WIDE
    assert change == pytest.approx(2.0 / 180.0 - 2.0 / 2.8)
    limit, by_k = kernels.torsion_gradient(2.8)
    moved = kernels.by_shape(by_k, 2.8) * change
    assert limit + moved == pytest.approx(kernels.torsion_limit(180.0), rel=0.03)


def test_a_sum_has_the_spread_of_its_parts(kernels, m) -> None:
    _, D = reported(kernels, m)
    weights = [0.3, -200.0, 0.7, 1.1, 50.0, -2.0]
    assert kernels.combined_std(m, *weights) == pytest.approx(float(np.linalg.norm(weights @ D)))


def test_quantities_have_the_spread_of_their_columns(kernels, m) -> None:
    _, D = reported(kernels, m)
    for name, row in zip(("FORCE", "RADIUS", "EXPONENT", "MU"), D, strict=False):
        assert m[getattr(kernels, f"REP_{name}_STD")] == pytest.approx(float(np.linalg.norm(row)))
    assert m[kernels.REP_DEPTH_STD] == pytest.approx(float(np.linalg.norm(D[4])))


def test_limit_force_and_torque_have_the_spread_of_their_product(kernels, m) -> None:
    at, D = reported(kernels, m)
    force, std = spread(lambda N, _a, _k, mu: mu * N, at, D)
    assert m[kernels.REP_LIMIT_FORCE] == pytest.approx(force)
    assert m[kernels.REP_LIMIT_FORCE_STD] == pytest.approx(std, rel=1e-5)
    torque, std = spread(lambda N, a, k, mu: mu * N * a * fast.torsion_limit(k), at, D)
    assert m[kernels.REP_LIMIT_TORQUE] == pytest.approx(torque)
    assert m[kernels.REP_LIMIT_TORQUE_STD] == pytest.approx(std, rel=1e-5)


@pytest.mark.parametrize(
    ("load", "torque"), [(0.4, 1e-3), (-0.4, -1e-3), (0.05, 2e-3), (0.6, 0.0), (0.0, 1e-3)]
)
def test_gauge_and_limit_radius_have_the_spread_of_the_limit_surface(kernels, m, load, torque) -> None:
    at, D = reported(kernels, m, load, torque)
    f, moment = abs(load), abs(torque)

    def gauge(N, a, k, mu, f=f, moment=moment):
        return fast.gauge(k, f / (mu * N), moment / (mu * N * a))

    def reach(N, a, k, mu):
        return math.hypot(f, moment / a) / gauge(N, a, k, mu)

    value, std = spread(gauge, at, D)
    assert m[kernels.REP_GAUGE] == pytest.approx(value)
    assert m[kernels.REP_GAUGE_REL] == pytest.approx(std / value, rel=1e-4)
    assert m[kernels.REP_GAUGE_BY_FORCE] == pytest.approx(std_with_force(gauge, at, D) / value, rel=1e-2)
    s_f, s_m = m[kernels.SET_S_TANGENTIAL], m[kernels.SET_S_TORQUE]
    by_f = (gauge(*at, f=f + 1e-5) - gauge(*at, f=f - 1e-5)) / 2e-5
    by_m = (gauge(*at, moment=moment + 1e-8) - gauge(*at, moment=moment - 1e-8)) / 2e-8
    assert m[kernels.REP_GAUGE_ABS] == pytest.approx(math.hypot(by_f * s_f, by_m * s_m), rel=1e-3)
    limit, std = spread(reach, at, D)
    assert m[kernels.REP_LIMIT_RADIUS] == pytest.approx(limit)
    a = at[1]
    psi = math.atan2(moment / a, f)
    by_psi = (fast.radius(at[2], psi + 1e-6) - fast.radius(at[2], psi - 1e-6)) / 2e-6 * at[3] * at[0]
    swing = math.hypot(math.sin(psi) * s_f, math.cos(psi) * s_m / a) / math.hypot(f, moment / a)
    assert m[kernels.REP_LIMIT_RADIUS_STD] == pytest.approx(math.hypot(std, by_psi * swing), rel=1e-3)


def test_what_the_force_explains_of_the_gauge_includes_a_friction_that_changes_with_it(kernels, m) -> None:
    at, D = reported(kernels, m)
    N, _, _, mu = at
    D[3] = -0.3 * mu / N * D[0]  # as of a friction that goes with N^-0.3
    m[kernels.D_FRICTION0 : kernels.D_FRICTION0 + D.shape[1]] = D[3]
    kernels.report_along_load(m, 0.4, 1e-3, *at)

    def gauge(N, a, k, mu):
        return fast.gauge(k, 0.4 / (mu * N), 1e-3 / (mu * N * a))

    by_force = std_with_force(gauge, at, D) / gauge(*at)
    assert m[kernels.REP_GAUGE_BY_FORCE] == pytest.approx(by_force, rel=1e-2)


def test_the_utilisation_does_not_depend_on_what_is_believed_of_friction(kernels, m) -> None:
    reported(kernels, m)
    u, relative = kernels.utilisation(m)
    known = m[kernels.REP_GAUGE_REL]
    m[kernels.FRI_LN_MU] += 0.4
    m[kernels.FRI_VAR] *= 4.0
    reported(kernels, m)
    assert kernels.utilisation(m) == pytest.approx((u, relative), rel=1e-3)
    assert m[kernels.REP_GAUGE_REL] > 1.5 * known


@pytest.mark.parametrize(
    ("gauge", "contact", "known"),
    [(0.4, 1.0, True), (0.4, 0.0, False), (0.0, 1.0, False), (math.nan, 1.0, False)],
)
def test_the_utilisation_is_that_of_a_load_on_a_contact(kernels, m, gauge, contact, known) -> None:
    m[kernels.REP_GAUGE], m[kernels.REP_GAUGE_REL], m[kernels.REP_GAUGE_ABS] = gauge, 0.3, 0.04
    m[kernels.REP_CONTACT], m[kernels.CONSIDER0 + kernels.CONSIDERED_MU] = contact, 0.0
    m[kernels.FRI_LN_MU], m[kernels.FRI_EXPONENT], m[kernels.FRI_LOAD] = math.log(0.5), 0.2, 0.7
    expected = (0.4 * 0.5 * math.exp(-0.14), math.hypot(0.3, 0.1)) if known else (math.nan, math.inf)
    assert kernels.utilisation(m) == pytest.approx(expected, nan_ok=True)


def test_an_upper_bound_is_lognormal_in_what_is_estimated_and_normal_in_the_load(kernels) -> None:
    assert kernels.upper_gauge(0.5, 0.0, 0.0, 1.6) == 0.5
    assert kernels.upper_gauge(0.5, 0.2, 0.0, 1.6) == pytest.approx(0.5 * math.exp(0.32))
    assert kernels.upper_gauge(0.5, 0.0, 0.1, 1.6) == pytest.approx(0.66)
    both = math.hypot(0.5 * (math.exp(0.32) - 1.0), 0.16)
    assert kernels.upper_gauge(0.5, 0.2, 0.1, 1.6) == pytest.approx(0.5 + both)
    assert kernels.upper_gauge(0.5, 1e9, 0.0, 1.6) == pytest.approx(0.5 * math.exp(50.0))


@pytest.mark.parametrize(
    ("force", "depth", "before", "contact"),
    [
        (2.1, 0.0, 0.0, 1.0),
        (0.1, 2.1, 0.0, 1.0),
        (1.9, 1.9, 0.0, 0.0),
        (1.9, 0.6, 1.0, 1.0),
        (0.6, 0.0, 1.0, 1.0),
        (0.4, 0.4, 1.0, 0.0),
        (-0.1, 9.0, 1.0, 0.0),
        (0.0, 9.0, 1.0, 0.0),
        (2.0, 0.0, 0.0, 0.0),
        (0.5, 0.0, 1.0, 1.0),
    ],
)
def test_contact_is_made_by_two_standard_deviations_and_broken_by_half_of_one(
    kernels, m, force, depth, before, contact
) -> None:
    m[kernels.REP_FORCE], m[kernels.REP_FORCE_STD] = 0.3 * force, 0.3
    m[kernels.REP_DEPTH_NOW], m[kernels.REP_DEPTH_STD] = 1e-5 * depth, 1e-5
    m[kernels.REP_CONTACT] = before
    kernels.update_contact(m)
    assert m[kernels.REP_CONTACT] == contact


AT = (1.7, 3e-3, 2.5, 0.6)  # N [N], a [m], k, mu


@pytest.fixture
def spread_by(kernels, m, rng, monkeypatch):
    """Let N, a, k, mu, delta and t have any columns, of which those of delta are of no use to a limit."""
    D = 0.05 * rng.standard_normal((6, kernels.M + kernels.N_CONSIDERED + 1))
    D *= np.array([AT[0], AT[1], AT[2], AT[3], 1.0, 1.0])[:, None]
    names = ("D_FORCE0", "D_RADIUS0", "D_EXPONENT0", "D_FRICTION0", "D_DELTA0", "D_SHAPE0")
    at = list(AT)

    def spread_quantities(m):
        for name, row in zip(names, D, strict=True):
            m[getattr(kernels, name) : getattr(kernels, name) + D.shape[1]] = row
        return tuple(at)

    monkeypatch.setattr(kernels, "spread_quantities", spread_quantities)
    return at, D


def by_shape(quantity, D):
    """Return a quantity of (N, a, mu, t) and its slopes along each column, by differences."""
    at = np.array([AT[0], AT[1], AT[3], 2.0 / AT[2] - 1.0])
    rows, h = D[[0, 1, 3, 5]], 1e-5
    slopes = [(quantity(*(at + h * d)) - quantity(*(at - h * d))) / (2.0 * h) for d in rows.T]
    return quantity(*at), np.array(slopes)


def test_whatever_spreads_goes_into_each_limit_by_its_own_slope(kernels, m, spread_by) -> None:
    _, D = spread_by
    load, torque = 0.4, 9e-4
    kernels.report(m, load, torque)
    told = [m[getattr(kernels, f"REP_{name}_STD")] for name in ("FORCE", "RADIUS", "EXPONENT", "MU", "DEPTH")]
    assert told == pytest.approx(np.linalg.norm(D[:5], axis=1))

    def gauge(N, a, mu, t, f=load, moment=torque):
        return fast.gauge(2.0 / (t + 1.0), f / (mu * N), moment / (mu * N * a))

    def torsion(N, a, mu, t):
        return mu * N * a * fast.torsion_limit(2.0 / (t + 1.0))

    _, slopes = by_shape(lambda N, _a, mu, _t: mu * N, D)
    assert m[kernels.REP_LIMIT_FORCE_STD] == pytest.approx(np.linalg.norm(slopes), rel=1e-6)
    limit, slopes = by_shape(torsion, D)
    assert m[kernels.REP_LIMIT_TORQUE] == pytest.approx(limit)
    assert m[kernels.REP_LIMIT_TORQUE_STD] == pytest.approx(np.linalg.norm(slopes), rel=1e-6)
    value, slopes = by_shape(gauge, D)
    assert m[kernels.REP_GAUGE_REL] == pytest.approx(np.linalg.norm(slopes) / value, rel=1e-6)
    by_force = abs(slopes @ D[0]) / np.linalg.norm(D[0]) / value
    assert m[kernels.REP_GAUGE_BY_FORCE] == pytest.approx(by_force, rel=1e-6)
    m[kernels.SET_S_TANGENTIAL] = m[kernels.SET_S_TORQUE] = 0.0
    kernels.report(m, load, torque)
    limit, slopes = by_shape(lambda N, a, mu, t: math.hypot(load, torque / a) / gauge(N, a, mu, t), D)
    assert m[kernels.REP_LIMIT_RADIUS] == pytest.approx(limit)
    assert m[kernels.REP_LIMIT_RADIUS_STD] == pytest.approx(np.linalg.norm(slopes), rel=1e-6)


def test_no_quantity_is_known_better_than_its_floor_and_no_limit_is_without_a_contact(
    kernels, m, spread_by
) -> None:
    at, D = spread_by
    D[:] = 0.0
    noise, R = math.sqrt(m[kernels.SET_R_FORCE]), m[kernels.SET_TIP_RADIUS]
    kernels.report(m, 0.4, 9e-4)
    told = [m[getattr(kernels, f"REP_{name}_STD")] for name in ("FORCE", "RADIUS", "EXPONENT", "MU")]
    assert told == pytest.approx([0.5 * noise, 1e-4 * R, 1e-3, 0.0])
    assert m[kernels.REP_LIMIT_FORCE_STD] == pytest.approx(0.6 * 0.5 * noise)
    assert m[kernels.REP_GAUGE_BY_FORCE] == 0.0
    for force, radius in ((0.0, 3e-3), (1.7, 0.0)):
        at[:2] = force, radius
        kernels.report(m, 0.4, 9e-4)
        assert m[kernels.REP_LIMIT_TORQUE] == m[kernels.REP_LIMIT_RADIUS] == 0.0
        assert m[kernels.REP_LIMIT_TORQUE_STD] == pytest.approx(0.6 * 0.5 * noise * 1e-4 * R)
        assert m[kernels.REP_LIMIT_RADIUS_STD] == m[kernels.REP_LIMIT_FORCE_STD]
        assert math.isnan(m[kernels.REP_GAUGE])
        assert (
            m[kernels.REP_GAUGE_REL] == m[kernels.REP_GAUGE_BY_FORCE] == m[kernels.REP_GAUGE_ABS] == math.inf
        )


def test_a_torque_that_is_not_measured_is_none_a_force_that_is_not_leaves_no_gauge(
    kernels, m, spread_by
) -> None:
    kernels.report(m, 0.4, math.nan)
    section = slice(kernels.REP_FORCE, kernels.REP_SLIDES)
    found, m[kernels.SET_S_TORQUE] = m[section].copy(), 0.0
    kernels.report(m, 0.4, 0.0)
    assert found == pytest.approx(m[section])
    kernels.report(m, math.nan, 9e-4)
    assert math.isnan(m[kernels.REP_LIMIT_RADIUS])
    assert math.isnan(m[kernels.REP_GAUGE])
    assert m[kernels.REP_LIMIT_RADIUS_STD] == m[kernels.REP_GAUGE_REL] == m[kernels.REP_GAUGE_ABS] == math.inf
    kernels.report(m, 0.0, 0.0)  # without a load, the limit is that of a force
    assert m[kernels.REP_GAUGE] == 0.0
    assert m[kernels.REP_LIMIT_RADIUS] == pytest.approx(0.6 * 1.7)


def test_a_load_of_noise_alone_may_point_a_radian_aside(kernels, m, spread_by) -> None:
    spread_by[1][:] = 0.0
    m[kernels.SET_S_TANGENTIAL], m[kernels.SET_S_TORQUE] = 0.01, 1e-4
    kernels.report(m, 1e-6, 1e-6 * AT[1])
    _, _, by_psi = fast.radius_gradient(AT[2], math.pi / 4.0)
    assert m[kernels.REP_LIMIT_RADIUS_STD] == pytest.approx(0.6 * 1.7 * abs(by_psi))


@pytest.mark.parametrize("value", [0.0, math.nan, math.inf])
def test_a_state_that_is_not_finite_is_not_sound(kernels, m, spread_by, value) -> None:
    m[kernels.Y0 + kernels.OFFSET] = value
    kernels.report(m, 0.4, 9e-4)
    assert m[kernels.REP_SOUND] == float(value == 0.0)


@pytest.mark.parametrize(("gauge", "slides", "told"), [(0.4, 0.0, 0.4), (0.4, 1.0, 1.0), (1.3, 1.0, 1.3)])
def test_a_finger_that_is_felt_to_slide_is_at_its_limit_at_least(kernels, m, gauge, slides, told) -> None:
    m[kernels.REP_GAUGE], m[kernels.REP_GAUGE_REL], m[kernels.REP_GAUGE_ABS] = gauge, 0.0, 0.0
    m[kernels.REP_SLIDES] = slides
    assert kernels.margin_gauge(m) == told
