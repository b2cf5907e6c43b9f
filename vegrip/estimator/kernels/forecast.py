"""What comes: the relaxing contact over time, and the least force that keeps a margin.

Position-held, ``N(T) = N_e - sum c_i [z_i e^(-nu_i T) + N_e (1 - e^(-nu_i T))]``: with the indentation at
rest one step of the model of length T is exact for any T, so the forecast is the model itself. Radius and
exponent follow from the states at T; the spread of the gauge scales with what the forecast adds,
``s(T)^2 = s(0)^2 + [ln(N(0) / N(T)) s_c]^2``, s_c being the relative spread of the relaxing share.
"""

import math

from vegrip.estimator.kernels.generated import (
    EXOGENOUS0,
    REP_CONTACT,
    REP_FORCE,
    REP_FORCE_STD,
    REP_GAUGE_REL,
    S10,
    SET_HOLD,
    SET_HORIZON,
    SET_QUANTILE,
    SET_S_TANGENTIAL,
    SET_S_TORQUE,
    SET_TIP_RADIUS,
    TRY0,
    VALUES0,
    Y0,
    Floats,
    advance,
    gauge,
    readout,
)
from vegrip.estimator.kernels.report import upper_gauge
from vegrip.estimator.kernels.state import copy_state, put_learned

SHARE_SPREAD = 0.3  # relative std of the part of the force that is still to relax


def held_state(m: Floats, y: int, T: float, into: int) -> tuple[float, float, float, float]:
    """Quantities ``N, a, k, friction`` after holding the indentation of ``y`` for T [s]."""
    put_learned(m, y)
    _, before, _, _ = advance(m, VALUES0, y + 2, m[y], 0.0, EXOGENOUS0, 0.0, 0.0, into)
    x, elastic_force, force, _ = advance(m, VALUES0, into, m[y], 0.0, EXOGENOUS0, before, T, into)
    a, k, friction = readout(m, VALUES0, into, m[y], 0.0, EXOGENOUS0, x, elastic_force, force)
    return force, a, k, friction


def gauge_of(force: float, a: float, k: float, mu: float, f: float, moment: float) -> float:
    """Load over limit; inf where there is load and no contact."""
    if not (force > 0.0 and a > 0.0):
        return math.inf if f + moment > 0.0 else 0.0
    limit = mu * force
    return gauge(k, f / limit, moment / (limit * a))


def gauge_after(m: Floats, y: int, T: float, f: float, moment: float, bound: float) -> float:
    """Gauge after holding for T; with ``bound`` its upper bound at the wanted confidence."""
    force, a, k, mu = held_state(m, y, T, S10)
    g = gauge_of(force, a, k, mu, f, moment)
    if bound < 0.5 or not g < math.inf:
        return g
    fresh = held_state(m, y, 0.0, S10)[0]
    # absolute spread of N kept, so its relative part grows as N falls or shrinks as N rises
    relative = m[REP_GAUGE_REL]
    part = m[REP_FORCE_STD] / max(m[REP_FORCE], 1e-300)
    now = m[REP_FORCE_STD] / force
    lost = SHARE_SPREAD * math.log(fresh / force) if T > 0.0 and fresh > 0.0 else 0.0
    relative = math.sqrt(max(relative * relative - part * part, 0.0) + now * now + lost * lost)
    noise = math.hypot(m[SET_S_TANGENTIAL], 0.0 if moment == 0.0 else m[SET_S_TORQUE] / a)
    return upper_gauge(g, relative, noise / (mu * force), m[SET_QUANTILE])


def time_to_slip(m: Floats, tangential: float, torque: float, bound: float) -> float:
    """First time [s] at which the gauge (or its bound) reaches 1 under the present load; inf = never.

    The crossing is bracketed on a grid of three instants per decade, then halved.
    """
    f, moment = load_of(tangential, torque)
    y = TRY0
    copy_state(m)
    if math.isnan(f) or m[REP_CONTACT] < 0.5:
        return math.nan
    if gauge_after(m, y, 0.0, f, moment, bound) >= 1.0:
        return 0.0
    if m[SET_HOLD] > 0.5:
        return math.inf
    low, high = 0.0, 1e-3
    while high < 2e4:
        if gauge_after(m, y, high, f, moment, bound) >= 1.0:
            for _ in range(30):
                middle = 0.5 * (low + high)
                if gauge_after(m, y, middle, f, moment, bound) >= 1.0:
                    high = middle
                else:
                    low = middle
            return high
        low, high = high, high * 2.154434690031884
    return math.inf


def worst_gauge(m: Floats, y: int, f: float, moment: float) -> float:
    """Largest upper bound of the gauge, now and at thirds of the horizon."""
    worst = gauge_after(m, y, 0.0, f, moment, 1.0)
    horizon = m[SET_HORIZON]
    if m[SET_HOLD] < 0.5 and horizon > 0.0:
        for i in range(1, 4):
            worst = max(worst, gauge_after(m, y, horizon * i / 3.0, f, moment, 1.0))
    return worst


def least_force(m: Floats, tangential: float, torque: float, margin: float) -> float:
    """Least normal force [N] with which the margin's lower bound stays above ``margin`` over the horizon.

    Follows the model's own loading and unloading from the present state: the indentation changes at once,
    the relaxed forces stay; N, a and k with it. The gauge falls with the indentation; inf when even pressing
    in by the whole tip radius does not suffice.
    """
    f, moment = load_of(tangential, torque)
    if math.isnan(f):
        return math.nan
    y = TRY0
    copy_state(m)
    present = m[Y0]
    m[y] = m[SET_TIP_RADIUS]
    if worst_gauge(m, y, f, moment) > 1.0 - margin or margin >= 1.0:
        return math.inf
    m[y] = least_depth(m, y, f, moment, 1.0 - margin, present)
    return held_state(m, y, 0.0, S10)[0]


def least_depth(m: Floats, y: int, f: float, moment: float, wanted: float, present: float) -> float:
    """Least indentation [m] at which the worst gauge is at most ``wanted``, within a millionth.

    In logarithms the gauge is nearly a straight line of slope -3/2 to -2 over the indentation (N ~ delta^1.5
    to delta^2): a step from the ``present`` one along that line, then false position in the bracket, with
    halving of the kept end's value (Illinois) [DowellJarratt1971]_.
    """
    high = math.log(m[SET_TIP_RADIUS])
    low = high - 18.0  # 1.5e-8 of the radius
    above, below = -1.0, 1.0  # ln(gauge / wanted) at high and low: signs known, values not yet
    x = min(max(math.log(max(present, 1e-300)), low), high)
    last = 0
    for i in range(40):
        m[y] = math.exp(x)
        g = worst_gauge(m, y, f, moment)
        value = math.log(g / wanted) if 0.0 < g < math.inf else math.copysign(20.0, g - wanted)
        if value > 0.0:
            below = value
            low, above, last = x, 0.5 * above if last > 0 else above, 1
        else:
            above = value
            high, below, last = x, 0.5 * below if last < 0 else below, -1
        if high - low < 1e-6 or -1e-7 < value <= 0.0:
            break
        step = x + value / 1.5 + math.copysign(0.02, value)
        if i > 1 or not low < step < high:
            step = high - above * (high - low) / (above - below)
        margin = 0.25e-6
        x = min(max(step, low + margin), high - margin)
    return math.exp(high)


def load_of(tangential: float, torque: float) -> tuple[float, float]:
    """Magnitudes of the load; a torque that is not measured counts as zero."""
    moment = 0.0 if math.isnan(torque) else abs(torque)
    return abs(tangential), moment


def reserve(m: Floats, tangential: float, torque: float) -> float:
    """Normal force [N] that could be lost now before the margin's lower bound is 0; negative: too little."""
    hold = m[SET_HOLD]
    m[SET_HOLD] = 1.0
    needed = least_force(m, tangential, torque, 0.0)
    m[SET_HOLD] = hold
    return float(m[REP_FORCE] - needed)
