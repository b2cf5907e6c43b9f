"""One scalar measurement: gate, gain, covariance, and what is remembered of the innovation."""

import math

from vegrip.estimator.kernels.generated import (
    CH_AGE,
    CH_REJECTED,
    CH_STREAK,
    CH_USED,
    CHANNEL0,
    FRI_SLIDING,
    G0,
    H0,
    HEALTH0,
    HEALTH1,
    K0,
    KEPT,
    LOAD0,
    MOTION0,
    NS,
    P0,
    REP_CONTACT,
    SET_DEPTH,
    SET_LEARNING_REST,
    Y0,
    Floats,
    M,
    N,
)
from vegrip.estimator.kernels.state import bound

TIMID = 0.02
"""What is left of the gain of learned parameters in a contact that was met in the middle.

Zero error, unknown history, stiffness and exponent all explain the same force there, and a linearised filter
takes its own noise for the difference: with the whole gain the 95 % interval of the radius held 58 % of the
truths, with this one 92 %. The first touch that is felt ends it.
"""

FAST = 2.0  # [x_ref / s] above which loading and unloading are fast
LATE = 1.0  # [s] at rest from which a hold is late
SUDDEN = 9.0  # NIS of the displacement at which the motion is taken to have jerked, and
SETTLED = 0.05  # [s] for which innovations then tell of the motion more than of the contact


def scalar_update(m: Floats, channel: int, innovation: float, R: float) -> bool:
    """One measurement with the gradient in section H; returns False when the gate refuses it.

    Above NIS 9 the weight falls as in Huber's estimate (the innovation variance grows with sqrt(NIS / 9)),
    above 100 the measurement is refused.

    A running maximum (KEPT) has no gain: it follows the estimate upwards by itself, and corrected downwards
    with it, it would forget the maximum. The covariance is that of the gain used, so it stays one.
    """
    y = Y0
    S = R
    for i in range(N):
        s = 0.0
        for j in range(N):
            s += m[P0 + i * N + j] * m[H0 + j]
        m[G0 + i] = s
    for i in range(N):
        S += m[H0 + i] * m[G0 + i]
    at = CHANNEL0 + 4 * channel
    nis = innovation * innovation / S
    if channel == 0 and nis > SUDDEN:
        m[LOAD0 + 5], m[LOAD0 + 6] = 11.0, 0.0
    note(m, channel, innovation / math.sqrt(S), nis)
    if not nis <= 100.0:
        m[at + CH_STREAK] += 1.0
        m[at + CH_REJECTED] += 1.0
        return False
    if channel == 0:
        restless(m, nis)
    m[at + CH_STREAK] = 0.0
    m[at + CH_AGE] = 0.0
    m[at + CH_USED] = 1.0
    if nis > 9.0:
        S *= math.sqrt(nis / 9.0)
    # in contact and without a displacement nothing tells the bias of the force from the force
    # and before the first touch was felt, nothing tells the zero of the displacement
    zero_kept = m[LOAD0] < 0.5
    # a tip that rests shows what drifts, not what it is made of
    resting = m[LOAD0 + 4] > m[SET_LEARNING_REST]
    bias_kept = m[LOAD0 + 1] > 0.5 and channel == 1 and m[H0] > 0.0
    for i in range(N):
        kept = KEPT[i] or (i == N - 1 and bias_kept) or (i == N - 2 and zero_kept)
        m[K0 + i] = 0.0 if kept else m[G0 + i] / S
        if 2 + NS <= i < M and (zero_kept or resting):
            m[K0 + i] *= 0.0 if resting else TIMID
        m[y + i] += m[K0 + i] * innovation
    for i in range(N):
        for j in range(i, N):
            a, b = m[K0 + i], m[K0 + j]
            m[P0 + i * N + j] -= a * m[G0 + j] + (m[G0 + i] - a * S) * b
            m[P0 + j * N + i] = m[P0 + i * N + j]
        floor = 1e-12 * m[G0 + i] * m[G0 + i] / S  # what rounding may have left of a variance
        m[P0 + i * N + i] = max(m[P0 + i * N + i], floor)
    bound(m)
    return True


def restless(m: Floats, nis: float) -> None:
    """Adapt how restless the motion is taken to be, a factor on the density of the acceleration.

    In a hold a filter that expects motion takes the noise of the displacement for motion, and the missing
    answer of the force for a soft contact: stiffness and relaxation came out low by two standard deviations.
    """
    calm = m[MOTION0] * (1.0 + 0.03 * (min(nis, 25.0) - 1.0))
    if nis > 9.0:
        calm = max(calm, 1.0)
    m[MOTION0] = min(max(calm, 1e-4), 100.0)


def note(m: Floats, channel: int, normalised: float, nis: float) -> None:
    """Remember the innovation for the consistency check, by channel and regime."""
    at = HEALTH0 + (HEALTH1 - HEALTH0) // 3 * channel + 3 * int(m[LOAD0 + 5])
    keep = m[LOAD0 + 2]  # exp(-dt / memory), set by update
    m[at] = keep * m[at] + 1.0
    gain = 1.0 / m[at]
    m[at + 1] += gain * (min(max(normalised, -10.0), 10.0) - m[at + 1])
    m[at + 2] += gain * (min(nis, 100.0) - m[at + 2])


def regime_of(m: Floats) -> float:
    """0 air, 1 loading, 2 hold, 3 unloading."""
    if m[REP_CONTACT] < 0.5:
        return 0.0
    slow = 2.0 * math.sqrt(max(m[P0 + N + 1], 0.0))
    if abs(m[Y0 + 1]) <= slow:
        return 2.0
    return 1.0 if m[Y0 + 1] > 0.0 else 3.0


def cell_of(m: Floats) -> float:
    """Where among :data:`vegrip.estimator.layout.REGIMES` the innovations of this sample are noted."""
    regime = float(m[LOAD0 + 3])
    cell = regime
    deep, fast = m[Y0] > m[SET_DEPTH], abs(m[Y0 + 1]) > FAST * m[SET_DEPTH]
    if m[LOAD0 + 6] < SETTLED:
        cell = 11.0
    elif regime > 0.0 and m[FRI_SLIDING] > 0.5:
        cell = 10.0
    elif regime == 1.0 and (deep or fast):
        cell = 5.0 if fast else 4.0
    elif regime == 2.0 and m[LOAD0 + 4] > LATE:
        cell = 7.0
    elif regime == 2.0 and deep:
        cell = 6.0
    elif regime == 3.0 and (deep or fast):
        cell = 9.0 if fast else 8.0
    return cell
