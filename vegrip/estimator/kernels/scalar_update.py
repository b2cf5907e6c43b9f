"""One scalar measurement: gain, covariance, and what is remembered of the innovation."""

import math

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.state import bound_state

GATE = 49.0
"""Normalised square of an innovation above which a sample contradicts what is known."""

HUBER = 9.0
"""Above it the weight of a sample falls as in Huber's estimate, and nothing is learned from it."""

CALM_LEARNING = 0.7
"""Part of the gain that learned parameters and zeros get.

Nine tenths of the information, and seven tenths of what a slope that is wrong early, while they are not
known, makes them believe. Of 300 lives the indentation was beyond six standard deviations in 0.3 % of the
looks with the whole gain, and in none with seven tenths.
"""

TIMID = 0.02
"""What is left of the gain of learned parameters in a contact that was met in the middle.

Zero error, unknown history, stiffness and exponent all explain the same force there. The first touch that is
felt ends it.
"""

SUSPECTED = 2.0  # sum of excess forces, see touch_detection.py, from which a touch is suspected
FAST = 2.0  # [x_ref / s] above which loading and unloading are fast
LATE = 1.0  # [s] at rest from which a hold is late
SETTLED = 0.05  # [s] after a jerk for which innovations show the motion more than of the contact


def spread_of(m: Floats) -> float:
    """Variance of the expected measurement, ``H P H'``; leaves ``G = P H``."""
    S = 0.0
    for i in range(N):
        s = 0.0
        for j in range(N):
            s += m.p[i * N + j] * m.h[j]
        m.g[i] = s
        S += m.h[i] * s
    return S


def refuse(m: Floats, channel: int) -> None:
    """Count a sample that is not used."""
    at = CHANNEL0 + CHANNEL_SIZE * channel
    m[at + CH_STREAK] += 1.0
    m[at + CH_REJECTED] += 1.0


def accept(m: Floats, channel: int) -> None:
    """Count a sample that is used."""
    at = CHANNEL0 + CHANNEL_SIZE * channel
    m[at + CH_STREAK] = 0.0
    m[at + CH_AGE] = 0.0
    m[at + CH_USED] = 1.0


def apply_measurement(m: Floats, channel: int, innovation: float, S: float) -> None:
    """Take in one measurement with the gradient H, ``G = P H`` and the innovation's variance S.

    Above HUBER its weight falls (S grows with the root of the excess), above GATE it is refused. A running
    maximum (KEPT) has no gain: it follows the estimate upwards by itself, and corrected downwards with it,
    it would forget the maximum. What is not learned now is only considered [Schmidt1966]_. The covariance is
    that of the gain used, so it stays one. What is remembered for the health does not count as noise what the
    model leaves unexplained.
    """
    nis = innovation * innovation / S
    plain = max(S - m.mode.tolerated, 0.1 * S) if channel == CHANNEL_FORCE else S
    record_innovation(m, channel, innovation / math.sqrt(plain), innovation * innovation / plain)
    if not nis <= GATE:
        refuse(m, channel)
        return
    accept(m, channel)
    if nis > HUBER:
        S *= math.sqrt(nis / HUBER)
    zero_kept = m.mode.zero_known == 0.0
    # a tip that rests shows what drifts, not what it is made of
    unfelt = m.mode.felt == 0.0 and m.mode.blind == 0.0
    careful = m.mode.rest > m.set.learning_rest or m.mode.caution > 0.0 or nis > HUBER or unfelt
    # in contact and without a displacement nothing distinguishes the bias of the force from the force
    bias_kept = m.mode.blind > 0.0 and channel == CHANNEL_FORCE and m.h[DELTA] > 0.0
    for i in range(N):
        kept = KEPT[i] or (i == BIAS and bias_kept) or (i == OFFSET and (zero_kept or unfelt))
        m.k[i] = 0.0 if kept else m.g[i] / S
        if LEARNED_FROM <= i < M and (zero_kept or careful):
            m.k[i] *= 0.0 if careful else TIMID
        touching = i == BIAS and m.mode.touch > SUSPECTED and unfelt
        if touching or (i >= M and (nis > HUBER or m.mode.caution > 0.0)):
            m.k[i] = 0.0
        if i >= LEARNED_FROM:
            m.k[i] *= CALM_LEARNING
        m.y[i] += m.k[i] * innovation
    for i in range(N):
        for j in range(i, N):
            a, b = m.k[i], m.k[j]
            m.p[i * N + j] -= a * m.g[j] + (m.g[i] - a * S) * b
            m.p[j * N + i] = m.p[i * N + j]
        floor = 1e-12 * m.g[i] * m.g[i] / S  # what rounding may have left of a variance
        m.p[i * N + i] = max(m.p[i * N + i], floor)
    bound_state(m)


def record_innovation(m: Floats, channel: int, normalised: float, nis: float) -> None:
    """Remember the innovation for the consistency check, by channel and regime."""
    at = HEALTH0 + CELL_SIZE * (REGIMES * channel + int(m.mode.cell))
    keep = m.mode.health_decay  # exp(-dt / memory), set by update
    m[at + CELL_WEIGHT] = keep * m[at + CELL_WEIGHT] + 1.0
    gain = 1.0 / m[at + CELL_WEIGHT]
    m[at + CELL_MEAN] += gain * (min(max(normalised, -10.0), 10.0) - m[at + CELL_MEAN])
    m[at + CELL_NIS] += gain * (min(nis, 100.0) - m[at + CELL_NIS])


def regime_of(m: Floats) -> float:
    """How the tip moves: in the air, loading, hold or unloading."""
    if m.report.contact == 0.0:
        return REGIME_AIR
    slow = 2.0 * math.sqrt(max(m.p[SPEED * N + SPEED], 0.0))
    if abs(m.y[SPEED]) <= slow:
        return REGIME_HOLD
    return REGIME_LOADING if m.y[SPEED] > 0.0 else REGIME_UNLOADING


def cell_of(m: Floats) -> float:
    """Where among :data:`vegrip.estimator.layout.REGIMES` the innovations of this sample are noted."""
    regime = float(m.mode.regime)
    cell = regime
    deep, fast = m.y[DELTA] > m.set.depth, abs(m.y[SPEED]) > FAST * m.set.depth
    if m.mode.since_jerk < SETTLED:
        cell = REGIME_JERK
    elif regime > REGIME_AIR and m.friction.sliding > 0.0:
        cell = REGIME_SLIDING
    elif regime == REGIME_LOADING and (deep or fast):
        cell = REGIME_FAST_LOADING if fast else REGIME_DEEP_LOADING
    elif regime == REGIME_HOLD and m.mode.rest > LATE:
        cell = REGIME_LATE_HOLD
    elif regime == REGIME_HOLD and deep:
        cell = REGIME_DEEP_HOLD
    elif regime == REGIME_UNLOADING and (deep or fast):
        cell = REGIME_FAST_UNLOADING if fast else REGIME_DEEP_UNLOADING
    return cell
