"""From the state to what is published: N, a, k, mu, the limit surface and the margin, each with its spread.

Everything published is a function of four quantities q = (N, a, k, friction) and the measured load (f, m).
Their covariance comes from the filter's by the delta method, ``C = J P J' + considered parameters``; from
there on the derivatives are written out. With the gauge g of the limit surface (1 = slip)::

    g = gauge(k, f / (mu N), m / (mu N a))          margin = 1 - g
    limit_radius = |load| / g,  |load| = sqrt(f^2 + (m / a)^2)
"""

import math

from vegrip.estimator.generated import *  # noqa: F403


def quantities(m, y):
    """``N, a, k, friction`` of the state ``y``."""
    x, elastic_force, force, _ = contact(m, y)
    a, k, friction = readout(m, VALUES0, S10, m[y], m[y + 1], EXOGENOUS0, x, elastic_force, force)
    return force, a, k, friction


def quantities_jacobian(m, y):
    """Fill JAC, 4 x (moving + considered), at ``y``; return the quantities."""
    C = M + N_CONSIDERED
    q0, q1, q2, q3 = quantities(m, y)
    for j in range(C):
        m[JAC0 + j] = m[JAC0 + C + j] = m[JAC0 + 2 * C + j] = m[JAC0 + 3 * C + j] = 0.0
    for j in range(M):
        h = step_of(m, y, j)
        if h > 0.0 and j != 1:
            keep = m[y + j]
            m[y + j] = keep + h
            r0, r1, r2, r3 = quantities(m, y)
            m[y + j] = keep
            m[JAC0 + j], m[JAC0 + C + j] = (r0 - q0) / h, (r1 - q1) / h
            m[JAC0 + 2 * C + j], m[JAC0 + 3 * C + j] = (r2 - q2) / h, (r3 - q3) / h
    if m[LOAD0 + 1] > 0.5:
        at_constant_force(m, C)
    put_learned(m, y)
    for i in range(N_CONSIDERED):
        at = VALUES0 + CONSIDERED[i]
        keep = m[at]
        h = 1e-4 * math.sqrt(m[CONSIDER0 + i]) + 1e-12
        m[at] = keep * math.exp(h) if CONSIDERED_LOG[i] else keep + h
        r0, r1, r2, r3 = quantities(m, y)
        m[at] = keep
        j = M + i
        m[JAC0 + C + j], m[JAC0 + 2 * C + j], m[JAC0 + 3 * C + j] = (
            (r1 - q1) / h,
            (r2 - q2) / h,
            (r3 - q3) / h,
        )
    return q0, q1, q2, q3


def at_constant_force(m, C):
    """Without a displacement a change of a parameter moves the indentation so that N stays (lose_sight)."""
    by_depth = m[JAC0]
    if by_depth <= 0.0:
        return
    for j in range(2 + NS, M):
        slope = -m[JAC0 + j] / by_depth
        for q in range(4):
            m[JAC0 + q * C + j] += slope * m[JAC0 + q * C]


def depth_variance(m):
    """Variance of the indentation, from JAC where it is not seen."""
    total = m[P0]
    by_depth = m[JAC0 + M + N_CONSIDERED]  # of the radius: its columns are at constant force already
    if m[LOAD0 + 1] > 0.5 and by_depth > 0.0:
        C = M + N_CONSIDERED
        for i in range(2 + NS, M):
            for j in range(2 + NS, M):
                both = m[JAC0 + C + i] * m[JAC0 + C + j]
                total += both / (by_depth * by_depth) * m[P0 + i * N + j]
    return max(total, 0.0)


def spread(m, a0, a1, a2, a3):
    """Variance of ``a0 N + a1 a + a2 k + a3 friction`` from JAC and the filter's covariance."""
    C = M + N_CONSIDERED
    for j in range(M):
        m[G0 + j] = (
            a0 * m[JAC0 + j] + a1 * m[JAC0 + C + j] + a2 * m[JAC0 + 2 * C + j] + a3 * m[JAC0 + 3 * C + j]
        )
    total = 0.0
    for i in range(M):
        s = 0.5 * m[P0 + i * N + i] * m[G0 + i]
        for j in range(i + 1, M):
            s += m[P0 + i * N + j] * m[G0 + j]
        total += 2.0 * m[G0 + i] * s
    for i in range(N_CONSIDERED):
        j = M + i
        s = a1 * m[JAC0 + C + j] + a2 * m[JAC0 + 2 * C + j] + a3 * m[JAC0 + 3 * C + j]
        total += s * s * m[CONSIDER0 + i]
    return max(total, 0.0)


def report(m, tangential, torque):
    """Fill the section REPORT for the present state and the load [N], [N m] (NaN = not measured)."""
    y = TRY0
    copy_state(m)
    friction_in(m)
    force, a, k, mu = quantities_jacobian(m, y)
    m[REP_FORCE], m[REP_RADIUS], m[REP_EXPONENT], m[REP_MU] = force, a, k, mu
    m[REP_FORCE_STD] = math.sqrt(spread(m, 1.0, 0.0, 0.0, 0.0))
    m[REP_RADIUS_STD] = math.sqrt(spread(m, 0.0, 1.0, 0.0, 0.0))
    m[REP_EXPONENT_STD] = math.sqrt(spread(m, 0.0, 0.0, 1.0, 0.0))
    m[REP_MU_STD] = math.sqrt(spread(m, 0.0, 0.0, 0.0, 1.0))
    m[REP_DEPTH_NOW], m[REP_DEPTH_STD] = m[Y0], math.sqrt(depth_variance(m))
    touch(m)
    m[REP_LIMIT_FORCE] = mu * force
    m[REP_LIMIT_FORCE_STD] = math.sqrt(spread(m, mu, 0.0, 0.0, force))
    limits(m, force, a, k, mu)
    along(m, tangential, torque, force, a, k, mu)


def friction_in(m):
    """Hand the friction posterior to the model and to the considered variances."""
    m[VALUES0 + MU_PLACE] = math.exp(m[FRI_LN_MU])
    m[CONSIDER0 + CONSIDERED_MU] = m[FRI_VAR]


def touch(m):
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


def limits(m, force, a, k, mu):
    """Pure torsion, ``mu N a M(k)``."""
    if not (force > 0.0 and a > 0.0):
        m[REP_LIMIT_TORQUE] = 0.0
        m[REP_LIMIT_TORQUE_STD] = 0.0
        return
    reach, by_k, _ = radius_gradient(k, 0.5 * math.pi)
    torque = mu * force * a * reach
    m[REP_LIMIT_TORQUE] = torque
    m[REP_LIMIT_TORQUE_STD] = torque * math.sqrt(spread(m, 1.0 / force, 1.0 / a, by_k / reach, 1.0 / mu))


def along(m, tangential, torque, force, a, k, mu):
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
    psi = math.atan2(along_m, along_f)
    reach, by_k, by_psi = radius_gradient(k, psi)
    c, s = math.cos(psi), math.sin(psi)
    turn = by_psi / reach
    limit = mu * force * reach
    gauge_now = load / limit
    # d ln reach by d ln a is -turn s c: a larger patch turns the load towards pure force
    rest = math.sqrt(spread(m, 1.0 / force, -turn * s * c / a, by_k / reach, 1.0 / mu))
    swing = math.hypot(s * s_f, c * s_m / a) / max(load, 1e-300)  # std of psi from the load's noise
    m[REP_LIMIT_RADIUS] = limit
    m[REP_LIMIT_RADIUS_STD] = limit * math.hypot(rest, turn * min(swing, 1.0))
    m[REP_GAUGE] = gauge_now
    by_a = (s * s - turn * s * c) / a
    m[REP_GAUGE_REL] = math.sqrt(spread(m, 1.0 / force, by_a, by_k / reach, 1.0 / mu))
    by_f, by_m = (c + turn * s) / limit, (s - turn * c) / (limit * a)
    m[REP_GAUGE_ABS] = math.hypot(by_f * s_f, by_m * s_m)


def upper_gauge(gauge_now, relative, absolute, quantile):
    """The gauge's upper bound: lognormal in what is estimated, normal in the load, in quadrature."""
    grown = gauge_now * (math.exp(min(quantile * relative, 50.0)) - 1.0)
    return gauge_now + math.hypot(grown, quantile * absolute)


def utilisation(m, tangential, torque):
    """``u``, the friction coefficient at which the present load would slip, and its relative std.

    Uses the quantities of REPORT; N scales it down, a and k by their derivatives.
    """
    mu, gauge_now = m[REP_MU], m[REP_GAUGE]
    if not gauge_now > 0.0 or m[REP_CONTACT] < 0.5:
        return math.nan, math.inf
    friction_part = m[CONSIDER0 + CONSIDERED_MU]
    known = max(m[REP_GAUGE_REL] * m[REP_GAUGE_REL] - friction_part, 0.0)
    noise = m[REP_GAUGE_ABS] / gauge_now
    return gauge_now * math.exp(m[FRI_LN_MU]), math.sqrt(known + noise * noise)
