"""The measurements beside the displacement: what is expected, its slope over the state, and the correction.

The expected force is regressed over the whole spread of the state, and where it bends once more over the
spread that is left after the sample (iterated posterior linearisation, [GarciaFernandez2015]_): the first
touch shows stiffness and zero at once, and slopes at the mean would count the same sample as news again.
"""

import math

from vegrip.estimator.kernels.covariance_root import WIDE, bend_variance, shift_along_root, square_root
from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.predict import STRAIGHT
from vegrip.estimator.kernels.scalar_update import apply_measurement, spread_of
from vegrip.estimator.kernels.state import (
    DEEPEST,
    clear_section,
    contact,
    copy_section,
    copy_state,
    difference_step,
)

RATIO_TIME = 1.0  # [s] over which slopes are averaged where the tip rests
NEAR = 5.0  # noise of the displacement within which it rests
SURELY = 3.0  # std of the expected force from which the tip is surely in contact
ROUNDS = 3
"""Regressions of the force at most, at least two: about the state before the sample and about that after it.

The slope over the stiffness is the force at the indentation as it was just measured. Taken there it goes
with the displacement's noise, and so does the innovation: stiffness then falls in every hold, by 20 of its
standard deviations in 5 s. About the state after the sample it does not.
"""

BENT = 0.01  # excess variance over the noise's beyond which the spread after the sample is regressed over
BENT_TIME = 0.05  # [s] for which a bend stays the same
CHANCE = 0.3  # of the noise's variance
REFUSED_NIS = 100.0  # normalised square of an innovation that is refused anyhow

Expected = tuple[float, float]
"""Innovation, and its variance."""


def expect_force(m: Floats, value: float) -> Expected:
    """Regress the force into H for the measured ``value`` [N]; H, G = P H and the result are the update."""
    R = force_variance(m)
    square_root(m, P0)
    copy_section(m, Y0, MID0, N)
    expected, bend = regress_force(m)
    innovation = value - expected
    S = R + bend + spread_of(m)
    for _ in range(ROUNDS - 1):
        if innovation * innovation > REFUSED_NIS * S:
            break
        narrow = bend < BENT * R
        for i in range(N):
            m.mid[i] = m.y[i] + m.g[i] / S * innovation
        if not narrow:
            for i in range(N):
                for j in range(N):
                    m.b[i * N + j] = m.p[i * N + j] - m.g[i] * m.g[j] / S
            square_root(m, B0)
        expected, bend = regress_force(m)
        innovation = value - expected
        for j in range(N):
            innovation -= m.h[j] * (m.y[j] - m.mid[j])
        S = R + bend + spread_of(m)
        if narrow:
            break
    if m.mode.zero_known > 0.0:
        S += coherent_variance(m, bend)
    m.mode.slope = m.h[DELTA]
    if m.h[DELTA] > 0.0 and expected - m.mid[BIAS] > SURELY * math.sqrt(S):
        S += smooth_slopes(m)
    else:
        m.ratio.place = -m.set.tip_radius  # out of reach
    return innovation, S


def coherent_variance(m: Floats, bend: float) -> float:
    """Variance [N^2] by which a bend counts again in every sample, because it is the same in many.

    What is left of the law's bend over the spread of the state errs the same way from sample to sample. Taken
    as independent it would be averaged away, and the first touch would determine stiffness and zero too well.
    """
    sd = math.sqrt(bend)
    before = m.mode.bend * BENT_TIME / (BENT_TIME + m.mode.period)
    m.mode.bend = before + sd
    return float(2.0 * sd * before)


def smooth_slopes(m: Floats) -> float:
    """Where the tip rests, average the slopes relative to that over the indentation; return what S gains.

    Noise turns the direction of the gradient a little from sample to sample, and a filter that takes each for
    exact learns in time along the direction that no sample shows: stiffness against zero.
    """
    n, place = m.ratio.count, m.ratio.place
    holds = m.mode.regime == REGIME_HOLD and m.mode.zero_known > 0.0
    near = holds and abs(m.y[DELTA] - place) < NEAR * math.sqrt(m.set.r_displacement)
    n = min(n + 1.0, RATIO_TIME / max(m.mode.period, 1e-4)) if near else 0.0
    m.ratio.count = n
    m.ratio.place = place + (m.y[DELTA] - place) / (1.0 + n) if near else m.y[DELTA]  # mean place
    before = 0.0
    for j in range(N):
        before += m.h[j] * m.g[j]
    for j in range(EFFECTS, M):
        ratio = m.h[j] / m.h[DELTA]
        m.ratio[j] += (ratio - m.ratio[j]) / (1.0 + n)
        m.h[j] = m.h[DELTA] * m.ratio[j]
    return spread_of(m) - before


def force_variance(m: Floats) -> float:
    """Variance of the force that is not the state's [N^2]: noise, and what the model has left unexplained.

    Of a second of white noise some is always left; less than a third of its variance is not counted.
    """
    m.mode.tolerated = max(m.mode.unexplained - CHANCE * m.set.r_force, 0.0)
    return float(m.set.r_force + m.mode.tolerated)


def regress_force(m: Floats) -> tuple[float, float]:
    """Fill H with the slope of the sensed force about MID over the spread L; return mean and bend [N^2]."""
    copy_section(m, MID0, TRIED0, N)
    base = contact(m, TRIED0)[3]
    missed = bend = 0.0
    for j in range(M):
        m.g[j] = 0.0
        if m.l[j * N + j] > 0.0:
            shift_along_root(m, MID0, j, 1.0)
            rise = contact(m, TRIED0)[3] - base
            fall = rise
            if not (base > 0.0 and abs(rise) <= STRAIGHT * base):
                shift_along_root(m, MID0, j, -1.0)
                fall = base - contact(m, TRIED0)[3]
            m.g[j] = (rise + fall) / (2.0 * WIDE)
            missed += (rise - fall) / (2.0 * WIDE * WIDE)
            bend += bend_variance(rise - fall)
    solve_slopes(m)
    m.h[OFFSET] = 0.0
    m.h[BIAS] = 1.0
    return base + missed + m.mid[BIAS], bend


def solve_slopes(m: Floats) -> None:
    """From changes along the columns of L, in G, to slopes over the coordinates: ``L' H = G``."""
    for j in range(M - 1, -1, -1):
        root = m.l[j * N + j]
        s = m.g[j]
        for i in range(j + 1, M):
            s -= m.l[i * N + j] * m.h[i]
        m.h[j] = s / root if root > 0.0 else 0.0


def expect_force_alone(m: Floats, value: float) -> Expected:
    """As ``expect_force`` without a displacement (displacement_loss.py): linearised where the force is."""
    y = TRIED0
    copy_state(m)
    R = force_variance(m)
    bias = m[y + BIAS]
    linearise_at_force(m, y, value - bias, 3.0 * math.sqrt(R + m.p[BIAS * N + BIAS]))
    base = force_gradient(m, y)
    innovation = value - base - bias
    for j in range(M):
        innovation -= m.h[j] * (m.y[j] - m[y + j])
    m.mode.slope = m.h[DELTA]
    return innovation, R + spread_of(m)


def force_gradient(m: Floats, y: int) -> float:
    """Fill H with the derivative of the sensed force at ``y``; return that force."""
    clear_section(m, H0, H1)
    base = contact(m, y)[3]
    for j in range(LEARNED_FROM if m.mode.blind > 0.0 else M):
        h = difference_step(m, y, j)
        if FELT[j] and h > 0.0:
            keep = m[y + j]
            m[y + j] = keep + h
            m.h[j] = (contact(m, y)[3] - base) / h
            m[y + j] = keep
    m.h[BIAS] = 1.0
    return base


def linearise_at_force(m: Floats, y: int, force: float, threshold: float) -> None:
    """Move the point of linearisation to the indentation at which the model gives the force.

    At first touch the model's slope is zero and a linearisation there would never leave the air.
    """
    if force < threshold:
        return
    found = contact(m, y)[3]
    if abs(found - force) < threshold:
        return
    low, high = min(m[y + DELTA], 0.0), DEEPEST * m.set.tip_radius
    for _ in range(40):
        m[y + DELTA] = 0.5 * (low + high)
        if contact(m, y)[3] < force:
            low = m[y + DELTA]
        else:
            high = m[y + DELTA]


def measure_radius(m: Floats, value: float) -> None:
    """``contact_radius = a``."""
    y = TRIED0
    copy_state(m)
    clear_section(m, H0, H1)
    base = radius_of(m, y)
    if base <= 0.0:
        return
    for j in range(M):
        h = difference_step(m, y, j)
        if FELT[j] and h > 0.0:
            keep = m[y + j]
            m[y + j] = keep + h
            m.h[j] = (radius_of(m, y) - base) / h
            m[y + j] = keep
    apply_measurement(m, CHANNEL_RADIUS, value - base, m.set.r_radius + spread_of(m))


def radius_of(m: Floats, y: int) -> float:
    """Contact radius of the state ``y``."""
    x, elastic_force, force, _ = contact(m, y)
    return read_radius(m, VALUES0, TRIAL0, m[y + DELTA], m[y + SPEED], EXOGENOUS0, x, elastic_force, force)
