"""From the state to what is published: N, a, k, mu, the limit surface and the margin, each with its spread.

Everything published is a function of four quantities q = (N, a, k, friction) and the measured load (f, m).
Their covariance comes from the filter's by the delta method, ``C = J P J' + considered parameters``; from
there on the derivatives are written out. With the gauge g of the limit surface (1 = slip)::

    g = gauge(k, f / (mu N), m / (mu N a))          margin = 1 - g
    limit_radius = |load| / g,  |load| = sqrt(f^2 + (m / a)^2)
"""

import math

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.load_law import *
from vegrip.estimator.kernels.quantities import combined_std, spread_quantities, std_with_force

LEAST_FORCE_STD = 0.5  # of the noise of the force: what the air, where N = 0 exactly, says of a touch
LEAST_RADIUS_STD = 1e-4  # of the tip radius
LEAST_EXPONENT_STD = 1e-3


def report(m: Floats, tangential: float, torque: float) -> None:
    """Fill the section REPORT for the present state and the load [N], [N m] (NaN = not measured)."""
    m.report.sound = 1.0
    for i in range(Y0, Y1):
        if not math.isfinite(m[i]):
            m.report.sound = 0.0
    friction_in(m)
    force, a, k, mu = spread_quantities(m)
    m.report.force, m.report.radius, m.report.exponent, m.report.mu = force, a, k, mu
    least = LEAST_FORCE_STD * math.sqrt(m.set.r_force)
    m.report.force_std = max(combined_std(m, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0), least)
    m.report.radius_std = max(
        combined_std(m, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0), LEAST_RADIUS_STD * m.set.tip_radius
    )
    m.report.exponent_std = max(combined_std(m, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), LEAST_EXPONENT_STD)
    m.report.mu_std = combined_std(m, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    m.report.depth_now, m.report.depth_std = m.y[DELTA], combined_std(m, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    update_contact(m)
    m.report.limit_force = mu * force
    m.report.limit_force_std = max(combined_std(m, mu, 0.0, 0.0, force, 0.0, 0.0), mu * least)
    report_limits(m, force, a, k, mu)
    report_along_load(m, tangential, torque, force, a, k, mu)


def friction_in(m: Floats) -> None:
    """Hand the friction posterior to the model and to the considered variances."""
    m.values[MU_PLACE] = math.exp(m.friction.ln_mu)
    m.consider[CONSIDERED_MU] = friction_variance(m, m.friction.load)


def update_contact(m: Floats) -> None:
    """In contact or not, with hysteresis: two standard deviations to make it, half of one to break it."""
    by_force = m.report.force / max(m.report.force_std, 1e-300)
    by_depth = m.report.depth_now / max(m.report.depth_std, 1e-300)
    sure = by_force if by_force > by_depth else by_depth
    if m.report.force <= 0.0:
        m.report.contact = 0.0
    elif sure > 2.0:
        m.report.contact = 1.0
    elif sure < 0.5:
        m.report.contact = 0.0


def report_limits(m: Floats, force: float, a: float, k: float, mu: float) -> None:
    """Pure torsion, ``mu N a M(k)``."""
    if not (force > 0.0 and a > 0.0):
        m.report.limit_torque = 0.0
        m.report.limit_torque_std = mu * m.report.force_std * m.report.radius_std
        return
    reach, by_k = torsion_gradient(k)
    torque = mu * force * a * reach
    m.report.limit_torque = torque
    by_t = by_shape(by_k, k) / reach
    m.report.limit_torque_std = torque * combined_std(m, 1.0 / force, 1.0 / a, 0.0, 1.0 / mu, 0.0, by_t)


def by_shape(by_k: float, k: float) -> float:
    """Return the derivative by ``t = 2 / k - 1`` of what has this one by k."""
    return -0.5 * by_k * k * k


def report_along_load(
    m: Floats, tangential: float, torque: float, force: float, a: float, k: float, mu: float
) -> None:
    """Limit radius and gauge along the present load; the gauge with relative and absolute spread.

    ``GAUGE_REL`` comes from what is estimated (it scales the gauge), ``GAUGE_ABS`` from the noise of the
    measured load (it adds to it). A torque that is not measured counts as zero.
    """
    f, moment = abs(tangential), abs(torque)
    if math.isnan(moment):
        moment = 0.0
    if not (force > 0.0 and a > 0.0) or math.isnan(f):
        m.report.limit_radius = math.nan if math.isnan(f) else 0.0
        m.report.limit_radius_std = math.inf if math.isnan(f) else m.report.limit_force_std
        m.report.gauge = math.nan
        m.report.gauge_rel = m.report.gauge_by_force = m.report.gauge_abs = math.inf
        return
    s_f = m.set.s_tangential
    s_m = 0.0 if math.isnan(torque) else m.set.s_torque
    along_f, along_m = f, moment / a
    load = math.hypot(along_f, along_m)
    c, s = (along_f / load, along_m / load) if load > 0.0 else (1.0, 0.0)
    reach, by_k, by_psi = radius_gradient_towards(k, c, s)
    turn = by_psi / reach
    limit = mu * force * reach
    gauge_now = load / limit
    # d ln reach by d ln a is -turn s c: a larger patch turns the load towards pure force
    by_t = by_shape(by_k, k) / reach
    rest = combined_std(m, 1.0 / force, -turn * s * c / a, 0.0, 1.0 / mu, 0.0, by_t)
    swing = math.hypot(s * s_f, c * s_m / a) / max(load, 1e-300)  # std of psi from the load's noise
    m.report.limit_radius = limit
    m.report.limit_radius_std = limit * math.hypot(rest, turn * min(swing, 1.0))
    m.report.gauge = gauge_now
    by_a = (s * s - turn * s * c) / a
    m.report.gauge_rel = combined_std(m, 1.0 / force, by_a, 0.0, 1.0 / mu, 0.0, by_t)
    m.report.gauge_by_force = std_with_force(m, 1.0 / force, by_a, 1.0 / mu, by_t)
    by_f, by_m = (c + turn * s) / limit, (s - turn * c) / (limit * a)
    m.report.gauge_abs = math.hypot(by_f * s_f, by_m * s_m)


def upper_gauge(gauge_now: float, relative: float, absolute: float, quantile: float) -> float:
    """The gauge's upper bound: lognormal in what is estimated, normal in the load, in quadrature."""
    grown = gauge_now * (math.exp(min(quantile * relative, 50.0)) - 1.0)
    return gauge_now + math.hypot(grown, quantile * absolute)


def margin_gauge(m: Floats) -> float:
    """The upper bound of the gauge behind the margin's: at least 1 while the finger is felt to slide."""
    upper = upper_gauge(m.report.gauge, m.report.gauge_rel, m.report.gauge_abs, m.set.quantile)
    return 1.0 if m.report.slides > 0.0 and upper < 1.0 else upper


def utilisation(m: Floats) -> tuple[float, float]:
    """``u``, the friction coefficient at which the present load would slip, and its relative std.

    Uses the quantities of REPORT; N scales it down, a and k by their derivatives.
    """
    gauge_now = m.report.gauge
    if not gauge_now > 0.0 or m.report.contact == 0.0:
        return math.nan, math.inf
    known = max(m.report.gauge_rel * m.report.gauge_rel - m.consider[CONSIDERED_MU], 0.0)
    noise = m.report.gauge_abs / gauge_now
    at_load = m.friction.ln_mu - m.friction.exponent * m.friction.load
    return gauge_now * math.exp(at_load), math.sqrt(known + noise * noise)
