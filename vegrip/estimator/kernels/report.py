"""From the state to what is published: N, a, k, mu, the limit surface and the margin, each with its spread.

Everything published is a function of four quantities q = (N, a, k, friction) and the measured load (f, m).
Their covariance comes from the filter's by the delta method, ``C = J P J' + considered parameters``; from
there on the derivatives are written out. With the gauge g of the limit surface (1 = slip)::

    g = gauge(k, f / (mu N), m / (mu N a))          margin = 1 - g
    limit_radius = |load| / g,  |load| = sqrt(f^2 + (m / a)^2)
"""

import math

from vegrip.estimator.kernels.covariance_root import WIDE
from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.quantities import combined_std, spread_quantities

LEAST_FORCE_STD = 0.5  # of the noise of the force: what the air, where N = 0 exactly, says of a touch
LEAST_RADIUS_STD = 1e-4  # of the tip radius
LEAST_EXPONENT_STD = 1e-3


def report(m: Floats, tangential: float, torque: float) -> None:
    """Fill the section REPORT for the present state and the load [N], [N m] (NaN = not measured)."""
    m[REP_SOUND] = 1.0
    for i in range(Y0, Y1):
        if not math.isfinite(m[i]):
            m[REP_SOUND] = 0.0
    friction_in(m)
    force, a, k, mu = spread_quantities(m)
    m[REP_FORCE], m[REP_RADIUS], m[REP_EXPONENT], m[REP_MU] = force, a, k, mu
    least = LEAST_FORCE_STD * math.sqrt(m[SET_R_FORCE])
    m[REP_FORCE_STD] = max(combined_std(m, 1.0, 0.0, 0.0, 0.0, 0.0), least)
    m[REP_RADIUS_STD] = max(combined_std(m, 0.0, 1.0, 0.0, 0.0, 0.0), LEAST_RADIUS_STD * m[SET_TIP_RADIUS])
    m[REP_EXPONENT_STD] = max(combined_std(m, 0.0, 0.0, 1.0, 0.0, 0.0), LEAST_EXPONENT_STD)
    m[REP_MU_STD] = combined_std(m, 0.0, 0.0, 0.0, 1.0, 0.0)
    m[REP_DEPTH_NOW], m[REP_DEPTH_STD] = m[Y0 + DELTA], combined_std(m, 0.0, 0.0, 0.0, 0.0, 1.0)
    update_contact(m)
    m[REP_LIMIT_FORCE] = mu * force
    m[REP_LIMIT_FORCE_STD] = max(combined_std(m, mu, 0.0, 0.0, force, 0.0), mu * least)
    report_limits(m, force, a, k, mu)
    report_along_load(m, tangential, torque, force, a, k, mu)


def friction_in(m: Floats) -> None:
    """Hand the friction posterior to the model and to the considered variances."""
    m[VALUES0 + MU_PLACE] = math.exp(m[FRI_LN_MU])
    m[CONSIDER0 + CONSIDERED_MU] = m[FRI_VAR]


def update_contact(m: Floats) -> None:
    """In contact or not, with hysteresis: two standard deviations to make it, half of one to break it."""
    by_force = m[REP_FORCE] / max(m[REP_FORCE_STD], 1e-300)
    by_depth = m[REP_DEPTH_NOW] / max(m[REP_DEPTH_STD], 1e-300)
    sure = by_force if by_force > by_depth else by_depth
    if m[REP_FORCE] <= 0.0:
        m[REP_CONTACT] = 0.0
    elif sure > 2.0:
        m[REP_CONTACT] = 1.0
    elif sure < 0.5:
        m[REP_CONTACT] = 0.0


def report_limits(m: Floats, force: float, a: float, k: float, mu: float) -> None:
    """Pure torsion, ``mu N a M(k)``."""
    if not (force > 0.0 and a > 0.0):
        m[REP_LIMIT_TORQUE] = 0.0
        m[REP_LIMIT_TORQUE_STD] = mu * m[REP_FORCE_STD] * m[REP_RADIUS_STD]
        return
    reach, by_k = torsion_gradient(k)
    torque = mu * force * a * reach
    m[REP_LIMIT_TORQUE] = torque
    m[REP_LIMIT_TORQUE_STD] = torque * combined_std(m, 1.0 / force, 1.0 / a, by_k / reach, 1.0 / mu, 0.0)


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
        m[REP_LIMIT_RADIUS] = math.nan if math.isnan(f) else 0.0
        m[REP_LIMIT_RADIUS_STD] = math.inf if math.isnan(f) else m[REP_LIMIT_FORCE_STD]
        m[REP_GAUGE] = math.nan
        m[REP_GAUGE_REL] = m[REP_GAUGE_ABS] = math.inf
        return
    s_f = m[SET_S_TANGENTIAL]
    s_m = 0.0 if math.isnan(torque) else m[SET_S_TORQUE]
    along_f, along_m = f, moment / a
    load = math.hypot(along_f, along_m)
    c, s = (along_f / load, along_m / load) if load > 0.0 else (1.0, 0.0)
    reach, by_k, by_psi = radius_gradient_towards(k, c, s)
    turn = by_psi / reach
    limit = mu * force * reach
    gauge_now = load / limit
    # d ln reach by d ln a is -turn s c: a larger patch turns the load towards pure force
    rest = combined_std(m, 1.0 / force, -turn * s * c / a, by_k / reach, 1.0 / mu, 0.0)
    swing = math.hypot(s * s_f, c * s_m / a) / max(load, 1e-300)  # std of psi from the load's noise
    m[REP_LIMIT_RADIUS] = limit
    m[REP_LIMIT_RADIUS_STD] = limit * math.hypot(rest, turn * min(swing, 1.0))
    m[REP_GAUGE] = gauge_now
    by_a = (s * s - turn * s * c) / a
    m[REP_GAUGE_REL] = combined_std(m, 1.0 / force, by_a, by_k / reach, 1.0 / mu, 0.0)
    by_f, by_m = (c + turn * s) / limit, (s - turn * c) / (limit * a)
    m[REP_GAUGE_ABS] = math.hypot(by_f * s_f, by_m * s_m)


def upper_gauge(gauge_now: float, relative: float, absolute: float, quantile: float) -> float:
    """The gauge's upper bound: lognormal in what is estimated, normal in the load, in quadrature."""
    grown = gauge_now * (math.exp(min(quantile * relative, 50.0)) - 1.0)
    return gauge_now + math.hypot(grown, quantile * absolute)


def utilisation(m: Floats) -> tuple[float, float]:
    """``u``, the friction coefficient at which the present load would slip, and its relative std.

    Uses the quantities of REPORT; N scales it down, a and k by their derivatives.
    """
    gauge_now = m[REP_GAUGE]
    if not gauge_now > 0.0 or m[REP_CONTACT] < 0.5:
        return math.nan, math.inf
    friction_std = math.sinh(WIDE * math.sqrt(m[CONSIDER0 + CONSIDERED_MU])) / WIDE
    friction_part = friction_std * friction_std
    known = max(m[REP_GAUGE_REL] * m[REP_GAUGE_REL] - friction_part, 0.0)
    noise = m[REP_GAUGE_ABS] / gauge_now
    return gauge_now * math.exp(m[FRI_LN_MU]), math.sqrt(known + noise * noise)
