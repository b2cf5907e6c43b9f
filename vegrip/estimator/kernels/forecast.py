"""What comes: when a held contact slips, and the least force that keeps a margin.

The forecast is the model itself, stepped through the hold (``hold_model.py``); radius and exponent follow
from its states. The spread of the gauge grows with what the forecast adds,
``s(T)^2 = s(0)^2 + [ln(N(0) / N(T)) s_c]^2``, s_c being the relative spread of the relaxing share. That the
contact holds by now is used too (``slip_probability.py``): what has held its load does not slip at once.
"""

import math

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.hold_model import begin_hold, keep_hold, surface_of, try_hold
from vegrip.estimator.kernels.load_law import *
from vegrip.estimator.kernels.load_loss import load_to_hold
from vegrip.estimator.kernels.report import upper_gauge
from vegrip.estimator.kernels.slip_probability import onset_probability
from vegrip.estimator.kernels.state import DEEPEST, copy_state, put_learned

Load = tuple[float, float]
"""Tangential force [N] and torque [N m], both not negative."""

UNKNOWN = 1e6  # relative std of force or gauge from which on there is no contact that they could describe
TINY = 1e-100  # [N], [m]; a spread over less could be infinite
SHARE_SPREAD = 0.3  # relative std of the part of the force that is still to relax
FIRST = 1e-3  # [s] of the first look ahead
GROWTH = 0.5  # each later one is so much farther ahead
LAST = 2e4  # [s]
OPEN = -1.0  # for a time that is not known yet
PARTS = (0.1, 0.25, 0.5, 1.0)  # of the horizon, where the least force looks


def gauge_of(force: float, a: float, k: float, mu: float, load: Load) -> float:
    """Load over limit; inf where there is load and no contact."""
    f, moment = load
    if not (force > 0.0 and a > 0.0):
        return math.inf if f + moment > 0.0 else 0.0
    limit = mu * force
    return gauge(k, f / limit, moment / (limit * a))


def gauge_after(
    m: Floats, y: int, before: float, dt: float, begun: tuple[float, float], load: Load, quantile: float
) -> tuple[float, float, float]:
    """Bound of the gauge after another dt of the hold; ``delta``, ``elastic_force``."""
    delta, x, elastic, force = try_hold(m, y, before, dt, begun)
    a, k, mu = surface_of(m, delta, x, elastic, force)
    g = gauge_of(force, a, k, mu, load)
    if g < math.inf:
        g = bound_gauge(m, g, force, a, mu, begun[1], load, quantile)
    return g, delta, elastic


def slip_probability_after(
    m: Floats, y: int, before: float, dt: float, begun: tuple[float, float], load: Load
) -> tuple[float, float, float]:
    """Probability of slip within another dt of the hold; ``delta``, ``elastic_force``."""
    delta, x, elastic, force = try_hold(m, y, before, dt, begun)
    a, k, mu = surface_of(m, delta, x, elastic, force)
    g = gauge_of(force, a, k, mu, load)
    if g == math.inf:
        return 1.0, delta, elastic
    noise = math.hypot(m.set.s_tangential, 0.0 if load[1] == 0.0 else m.set.s_torque / a)
    lost = SHARE_SPREAD * math.log(begun[1] / force) if begun[1] > 0.0 else 0.0
    unsure = math.hypot(lost, noise / (mu * force) / max(g, 1e-300))
    return onset_probability(m, g * math.exp(m.friction.ln_mu), unsure, relative_load(force)), delta, elastic


def bound_gauge(
    m: Floats, g: float, force: float, a: float, mu: float, fresh: float, load: Load, quantile: float
) -> float:
    """Upper bound of the gauge at the wanted confidence, the force gone from ``fresh`` to ``force``."""
    force, a = max(force, TINY), max(a, TINY)
    now = spread_by_force(m, force)
    lost = SHARE_SPREAD * math.log(fresh / force) if fresh > 0.0 else 0.0
    relative = math.sqrt(variance_without_force(m, force) + now * now + lost * lost)
    noise = math.hypot(m.set.s_tangential, 0.0 if load[1] == 0.0 else m.set.s_torque / a)
    return upper_gauge(g, relative, noise / (mu * force), quantile)


def variance_without_force(m: Floats, force: float) -> float:
    """Relative variance of the gauge at ``force`` [N] that does not come from an error of N.

    The part of friction is that at this force, not at the present one; out of contact there is no other.
    """
    there = friction_variance(m, relative_load(force))
    if not (m.report.force > 0.0 and m.report.gauge_rel < UNKNOWN):
        return there
    relative, part = m.report.gauge_rel, spread_by_force(m, m.report.force)
    return float(max(relative * relative - part * part - m.consider[CONSIDERED_MU], 0.0) + there)


def spread_by_force(m: Floats, force: float) -> float:
    """Relative std of the gauge at ``force`` [N] that comes from the error of N.

    That error is the same there, so it matters less the larger N is; and what is wrong with radius and
    exponent because of it, too.
    """
    alone = m.report.force_std / force
    if not (m.report.force > 0.0 and m.report.gauge_rel < UNKNOWN):
        return alone
    return float(max(m.report.gauge_by_force * m.report.force / force, alone))


def slip_times(m: Floats, tangential: float, torque: float, chance: float) -> tuple[float, float]:
    """Times [s] by which the contact has slipped with probability one half, and with ``chance``; inf = never.

    The load stays, and the hold is followed once for both, in steps that grow; the step of a crossing is
    halved. NaN when the load, the contact or what the hold leads to is not known.
    """
    load, y = load_of(tangential, torque), TRIED0
    if math.isnan(load[0]) or m.report.contact == 0.0:
        return math.nan, math.nan
    copy_state(m)
    put_learned(m, y)
    elastic, origin, fresh = begin_hold(m, y)
    begun = (origin, fresh)
    slipped = slip_probability_after(m, y, elastic, 0.0, begun, load)[0]
    slides = m.friction.sliding > 0.0 or m.report.slides > 0.0
    likely = 0.0 if slides or slipped >= 0.5 else OPEN
    earliest = 0.0 if slides or slipped >= chance else OPEN
    t, dt = 0.0, FIRST
    while t < LAST and not math.isnan(slipped) and min(likely, earliest) == OPEN:
        slipped, delta, after = slip_probability_after(m, y, elastic, dt, begun, load)
        crosses = False
        if earliest == OPEN and slipped >= chance:
            earliest, crosses = t + crossing_time(m, y, elastic, dt, begun, load, chance), True
        if likely == OPEN and slipped >= 0.5:
            likely, crosses = t + crossing_time(m, y, elastic, dt, begun, load, 0.5), True
        if crosses:  # the halving has left other trial states
            slip_probability_after(m, y, elastic, dt, begun, load)
        keep_hold(m, y, delta)
        t, elastic = t + dt, after
        dt = GROWTH * t
    never = math.nan if math.isnan(slipped) else math.inf
    return never if likely == OPEN else likely, never if earliest == OPEN else earliest


def crossing_time(
    m: Floats, y: int, before: float, dt: float, begun: tuple[float, float], load: Load, chance: float
) -> float:
    """Part of the step ``dt`` [s] after which slip has the probability ``chance``, by halving."""
    low, high = 0.0, dt
    for _ in range(30):
        middle = 0.5 * (low + high)
        if slip_probability_after(m, y, before, middle, begun, load)[0] >= chance:
            high = middle
        else:
            low = middle
    return high


def worst_gauge(m: Floats, y: int, depth: float, load: Load, quantile: float) -> float:
    """Largest upper bound of the gauge from ``depth`` [m] on, over the horizon of the hold; NaN if not known.

    A held force is not followed: creep widens and flattens the contact, which then carries more.
    """
    copy_state(m)
    m[y + DELTA] = depth
    elastic, _, fresh = begin_hold(m, y)
    begun = (depth, fresh)
    worst = gauge_after(m, y, elastic, 0.0, begun, load, quantile)[0]
    if m.set.hold == 0.0 or m.set.horizon == 0.0 or math.isnan(worst):
        return worst
    t = 0.0
    for part in PARTS:
        dt = part * m.set.horizon - t
        g, delta, elastic = gauge_after(m, y, elastic, dt, begun, load, quantile)
        if math.isnan(g):
            return math.nan
        keep_hold(m, y, delta)
        worst, t = max(worst, g), t + dt
    return worst


def least_force(m: Floats, tangential: float, torque: float, margin: float, quantile: float) -> float:
    """Least normal force [N] with which the margin's lower bound stays above ``margin`` over the horizon.

    The bound is ``quantile`` standard deviations from the estimate.

    Follows the model's own loading and unloading from the present state: the indentation changes at once,
    the relaxed forces stay; N, a and k with it. The gauge falls with the indentation; inf when even pressing
    in by DEEPEST tip radii does not suffice. NaN when the load, or what the contact would carry, is not
    known. A part of the load that may be gone by a fault of its channel alone counts as it was.
    """
    load, y = load_of(tangential, torque), TRIED0
    load = load_to_hold(m, load[0], load[1])
    if math.isnan(load[0] + margin + quantile):
        return math.nan
    copy_state(m)
    put_learned(m, y)
    pressed = worst_gauge(m, y, DEEPEST * m.set.tip_radius, load, quantile)
    if math.isnan(pressed):
        return math.nan
    if pressed > 1.0 - margin or margin >= 1.0:
        return math.inf
    depth = least_depth(m, y, load, 1.0 - margin, m.y[DELTA], quantile)
    copy_state(m)
    m[y + DELTA] = depth
    return begin_hold(m, y)[2]


def least_depth(m: Floats, y: int, load: Load, wanted: float, present: float, quantile: float) -> float:
    """Least indentation [m] at which the worst gauge is at most ``wanted``, within a millionth.

    In logarithms the gauge is nearly a straight line of slope -3/2 to -2 over the indentation (N ~ delta^1.5
    to delta^2): a step from the ``present`` one along that line, then false position in the bracket, with
    halving of the kept end's value (Illinois) [DowellJarratt1971]_.
    """
    high = math.log(DEEPEST * m.set.tip_radius)
    low = high - 19.0  # 1.7e-8 of the radius
    above, below = -1.0, 1.0  # ln(gauge / wanted) at high and low: signs known, values not yet
    x = min(max(math.log(max(present, 1e-300)), low), high)
    last = 0
    for i in range(40):
        g = worst_gauge(m, y, math.exp(x), load, quantile)
        value = -20.0 if g <= wanted else 20.0  # a NaN is not known to suffice
        if 0.0 < g < math.inf:
            value = math.log(max(g / wanted, 1e-300))
        if value > 0.0:
            below = value
            low, above, last = x, 0.5 * above if last > 0 else above, 1
        else:
            above = value
            high, below, last = x, 0.5 * below if last < 0 else below, -1
        if high - low < 1e-6 or -1e-7 < value <= 0.0:
            break
        step = x + value / 1.5 + (0.02 if value > 0.0 else -0.02)
        if i > 1 or not low < step < high:
            step = high - above * (high - low) / (above - below)
        margin = 0.25e-6
        x = min(max(step, low + margin), high - margin)
    return math.exp(high)


def load_of(tangential: float, torque: float) -> Load:
    """Magnitudes of the load; a torque that is not measured counts as zero."""
    moment = 0.0 if math.isnan(torque) else abs(torque)
    return abs(tangential), moment


def force_reserve(m: Floats, tangential: float, torque: float) -> float:
    """Normal force [N] that could be lost now before the margin's lower bound is 0; negative: too little."""
    hold = m.set.hold
    m.set.hold = 0.0  # now, not over the horizon
    needed = least_force(m, tangential, torque, 0.0, m.set.quantile)
    m.set.hold = hold
    return float(m.report.force - needed)
