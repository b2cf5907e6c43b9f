"""One sample through everything, one compiled call."""

import math

from vegrip.estimator.kernels.begin import begin, keep_finite, widen
from vegrip.estimator.kernels.forecast import reserve, time_to_slip
from vegrip.estimator.kernels.friction import learn_friction
from vegrip.estimator.kernels.gain import cell_of, regime_of
from vegrip.estimator.kernels.generated import (
    CH_AGE,
    CH_STREAK,
    CH_USED,
    CHANNEL0,
    LOAD0,
    P0,
    REP_CONTACT,
    REP_FORCE,
    REP_GAUGE,
    REP_GAUGE_ABS,
    REP_GAUGE_REL,
    SET_DEPTH,
    SET_HEALTH_TIME,
    SET_LONGEST_GAP,
    SET_QUANTILE,
    SET_RECOVERY,
    SET_RHO_SPEED,
    Y0,
    Floats,
    N,
)
from vegrip.estimator.kernels.measure import measure_displacement, measure_force, measure_radius
from vegrip.estimator.kernels.predict import predict
from vegrip.estimator.kernels.report import report, upper_gauge, utilisation
from vegrip.estimator.kernels.sight import look
from vegrip.estimator.kernels.state import bound


def filter_step(m: Floats, dt: float, force: float, displacement: float, radius: float) -> None:
    """Predict and measure; NaN is a channel without a measurement. Returns nothing, all is in ``m``."""
    gap = dt > m[SET_LONGEST_GAP]
    blind = m[CHANNEL0 + CH_AGE] > m[SET_LONGEST_GAP]
    rho = math.exp(-dt * m[SET_RHO_SPEED]) if gap or blind else 1.0
    m[LOAD0 + 2] = math.exp(-dt / m[SET_HEALTH_TIME])
    for channel in range(3):
        m[CHANNEL0 + 4 * channel + CH_AGE] += dt
        m[CHANNEL0 + 4 * channel + CH_USED] = 0.0
    if gap:
        stand_still(m, dt)
    known = math.isfinite(displacement)
    look(m, blind and not known)
    predict(m, dt, rho)
    m[LOAD0 + 3] = regime_of(m)
    moves = m[LOAD0 + 3] == 1.0 or m[LOAD0 + 3] == 3.0
    m[LOAD0 + 4] = 0.0 if moves else m[LOAD0 + 4] + dt
    m[LOAD0 + 6] += dt
    m[LOAD0 + 5] = cell_of(m)
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


def stand_still(m: Floats, dt: float) -> None:
    """Take the tip to rest in a gap of ``dt`` [s]; where it may have led anywhere, forget the speed's spread.

    Carried through minutes, that spread is many times the depth of a contact, and linearised the memory of
    the contact follows it wherever the tip is seen next: a free fingertip came out of the gap as dented as
    it had ever been pressed, and refused its next contact.
    """
    m[Y0 + 1] = 0.0
    if math.sqrt(max(m[P0 + N + 1], 0.0)) * dt > m[SET_DEPTH]:
        for j in range(N):
            m[P0 + N + j] = m[P0 + j * N + 1] = 0.0


def update(
    m: Floats,
    dt: float,
    force: float,
    displacement: float,
    radius: float,
    tangential: float,
    torque: float,
    slip: float,
) -> None:
    """One sample: filter, quantities, limit surface, friction. ``dt < 0`` begins."""
    if dt < 0.0:
        begin(m, force, displacement)
        dt = 0.0
    filter_step(m, dt, force, displacement, radius)
    keep_finite(m)
    report(m, tangential, torque)
    if m[REP_FORCE] <= 0.0:
        m[LOAD0] = 1.0  # in the air: the next touch tells where zero is
    u, relative = utilisation(m)
    learn_friction(m, dt, u, relative, slip, m[REP_CONTACT] > 0.5)


def many(ms: Floats, dt: float, samples: Floats) -> None:
    """Several fingers in one call: rows of ``ms`` and of ``samples`` (force, displacement, radius, ...)."""
    for i in range(ms.shape[0]):
        s = samples[i]
        update(ms[i], dt, s[0], s[1], s[2], s[3], s[4], s[5])


def margin_of(m: Floats, tangential: float, torque: float, out: Floats) -> None:
    """Fill ``out`` with gauge, its upper bound, force reserve, time to slip and its earliest."""
    out[0] = m[REP_GAUGE]
    out[1] = upper_gauge(m[REP_GAUGE], m[REP_GAUGE_REL], m[REP_GAUGE_ABS], m[SET_QUANTILE])
    out[2] = reserve(m, tangential, torque)
    out[3] = time_to_slip(m, tangential, torque, 0.5)
    out[4] = time_to_slip(m, tangential, torque, 0.5 * math.erfc(m[SET_QUANTILE] * 0.7071067811865476))
