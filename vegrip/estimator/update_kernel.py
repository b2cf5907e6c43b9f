"""One sample through everything, one compiled call."""

import math

from vegrip.estimator.generated import *  # noqa: F403


def filter_step(m, dt, force, displacement, radius):
    """Predict and measure; NaN is a channel without a measurement. Returns nothing, all is in ``m``."""
    gap = dt > m[SET_LONGEST_GAP]
    blind = m[CHANNEL0 + CH_AGE] > m[SET_LONGEST_GAP]
    rho = math.exp(-dt * m[SET_RHO_SPEED]) if gap or blind else 1.0
    m[LOAD0 + 2] = math.exp(-dt / m[SET_HEALTH_TIME])
    for channel in range(3):
        m[CHANNEL0 + 4 * channel + CH_AGE] += dt
        m[CHANNEL0 + 4 * channel + CH_USED] = 0.0
    if gap:
        m[Y0 + 1] = 0.0
    known = math.isfinite(displacement)
    look(m, blind and not known)
    predict(m, dt, rho)
    m[LOAD0 + 3] = regime_of(m)
    if blind and not known and m[Y0] < 0.0:
        m[Y0] = 0.0  # out of contact nothing tells how far
        m[Y0 + 1] = 0.0
    bound(m)
    if known:
        measure_displacement(m, displacement)
        if m[CHANNEL0 + CH_STREAK] >= m[SET_RECOVERY]:
            widen(m, True, displacement)
            measure_displacement(m, displacement)
            m[CHANNEL0 + CH_STREAK] = 0.0
    if math.isfinite(force):
        measure_force(m, force, blind and not known)
        if m[CHANNEL0 + 4 + CH_STREAK] >= m[SET_RECOVERY]:
            widen(m, False, displacement)
            measure_force(m, force, True)
            m[CHANNEL0 + 4 + CH_STREAK] = 0.0
    if math.isfinite(radius) and radius > 0.0:
        measure_radius(m, radius)


def look(m, blind):
    """Note whether the indentation is seen, and what changes with that."""
    was = m[LOAD0 + 1] > 0.5
    m[LOAD0 + 1] = 1.0 if blind else 0.0
    if blind:
        m[MOTION0] = 1.0
    if blind and not was:
        lose_sight(m)
    if was and not blind:
        regain_sight(m)


def update(m, dt, force, displacement, radius, tangential, torque, slip):
    """One sample: filter, quantities, limit surface, friction. ``dt < 0`` begins."""
    if dt < 0.0:
        begin(m, force, displacement)
        dt = 0.0
    filter_step(m, dt, force, displacement, radius)
    report(m, tangential, torque)
    u, relative = utilisation(m, tangential, torque)
    learn_friction(m, dt, u, relative, slip, m[REP_CONTACT] > 0.5)


def many(ms, dt, samples):
    """Several fingers in one call: rows of ``ms`` and of ``samples`` (force, displacement, radius, ...)."""
    for i in range(ms.shape[0]):
        s = samples[i]
        update(ms[i], dt, s[0], s[1], s[2], s[3], s[4], s[5])


def margin_of(m, tangential, torque, out):
    """Fill ``out`` with gauge, its upper bound, force reserve, time to slip and its earliest."""
    out[0] = m[REP_GAUGE]
    out[1] = upper_gauge(m[REP_GAUGE], m[REP_GAUGE_REL], m[REP_GAUGE_ABS], m[SET_QUANTILE])
    out[2] = reserve(m, tangential, torque)
    out[3] = time_to_slip(m, tangential, torque, 0.0)
    out[4] = time_to_slip(m, tangential, torque, 1.0)
