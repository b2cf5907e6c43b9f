"""The load that the drive has to answer: what is felt, without its noise, and ahead by the drive's lag.

A force that is commanded now is there a lag later, so the load that counts is that of then. Each component of
the load (tangential force x and y, torque) passes two exponential filters; their difference tells its rate of
change::

    rate = (fast - slow) / (slow_time - fast_time),     ahead = fast + (fast_time + lag) rate .

Of the difference, ``LEAD_GATE`` standard deviations of its noise do not count: a steady load has no lead.

The lag is the one that is told, or the measured one (:mod:`~vegrip.grip.drive_lag`), of which no more than
``LEAD_MOST`` is led: beyond it, the noise of the rate and the shakes of the hand cost more than the lead
gains. For the rest the finger holds more beforehand. A drive of first order with the lag L that answers a
load which grows from 1 by ``burst`` a second, led by ``LEAD_MOST``, lacks at the end of the growth, at
``1 + BURST_SIZE``::

    missing = burst (L - LEAD_MOST) (1 - exp(-BURST_SIZE / (burst L)))

so it holds against ``(1 + BURST_SIZE) / (1 + BURST_SIZE - missing)`` times the load.

Plain scalar code over the flat sequence of :mod:`~vegrip.grip.friction_probe`, behind its sections and those
of :mod:`~vegrip.grip.drive_lag`; the same text is compiled.
"""

import math

from vegrip.grip.drive_lag import *
from vegrip.types import Numbers

LEAD_NOISE = DRIVE_SIZE  # [N] std of a tangential force
LEAD_TORQUE_NOISE = DRIVE_SIZE + 1  # [N m]
LEAD_BEGUN = DRIVE_SIZE + 2
LEAD_AHEAD = LEAD_BEGUN + BELIEF_MOST  # x, y [N] and torque [N m] of finger i from 3 i on
LEAD_FAST = LEAD_AHEAD + 3 * BELIEF_MOST
LEAD_SLOW = LEAD_FAST + 3 * BELIEF_MOST
LEAD_SIZE = LEAD_SLOW + 3 * BELIEF_MOST

LEAD_FAST_TIME = 0.003  # [s]
LEAD_SLOW_TIME = 0.012  # [s]
LEAD_GATE = 2.0  # standard deviations
LEAD_MOST = 0.015  # [s] of a measured lag
BURST_SIZE = 0.5  # of the load, by which it grows in a burst


def begin_lead(q: Numbers, noise: float, torque_noise: float) -> None:
    """Set the noise of the load [N], [N m]; nothing is felt yet."""
    q[LEAD_NOISE], q[LEAD_TORQUE_NOISE] = noise, torque_noise
    for i in range(BELIEF_MOST):
        q[LEAD_BEGUN + i] = 0.0


def lead_load(q: Numbers, i: int, dt: float, x: float, y: float, torque: float) -> tuple[float, float]:
    """Take in one sample of the load of finger ``i``; return tangential force [N] and torque [N m] ahead.

    A load that is not known leads nowhere: it is returned as it is, and the next one begins anew.
    """
    turn = 0.0 if math.isnan(torque) else torque
    if not abs(x) + abs(y) + abs(turn) < math.inf:
        q[LEAD_BEGUN + i] = 0.0
        return math.sqrt(x * x + y * y), abs(torque)
    begun = q[LEAD_BEGUN + i] > 0.0
    q[LEAD_BEGUN + i] = 1.0
    lag = lead_time(q, i)
    lead_component(q, 3 * i, dt, x, q[LEAD_NOISE], begun, lag)
    lead_component(q, 3 * i + 1, dt, y, q[LEAD_NOISE], begun, lag)
    lead_component(q, 3 * i + 2, dt, turn, q[LEAD_TORQUE_NOISE], begun, lag)
    at, more = LEAD_AHEAD + 3 * i, burst_reserve(q, i)
    return more * math.sqrt(q[at] * q[at] + q[at + 1] * q[at + 1]), more * abs(q[at + 2])


def lead_time(q: Numbers, i: int) -> float:
    """Return by how much the load of finger ``i`` is led [s]."""
    if counts_measured(q, i):
        return min(q[DRIVE_LAG + i], LEAD_MOST)
    return q[DRIVE_TOLD]


def burst_reserve(q: Numbers, i: int) -> float:
    """Return how many times its load finger ``i`` holds against, for the part of the lag that is not led."""
    return reserve_for(q[DRIVE_LAG + i], q[DRIVE_BURST]) if counts_measured(q, i) else 1.0


def reserve_for(lag: float, burst: float) -> float:
    """Return how many times its load a finger holds against, whose drive has this measured ``lag`` [s]."""
    late = burst * max(lag - LEAD_MOST, 0.0)
    missing = late * (1.0 - math.exp(-BURST_SIZE / (burst * lag))) if late > 0.0 else 0.0
    return (1.0 + BURST_SIZE) / (1.0 + BURST_SIZE - missing)


def counts_measured(q: Numbers, i: int) -> bool:
    """Return whether the measured lag of finger ``i`` counts."""
    return q[DRIVE_IS_MEASURED] > 0.0 and q[DRIVE_KNOWN + i] > 0.0


def lead_component(
    q: Numbers, at: int, dt: float, value: float, noise: float, begun: bool, lag: float
) -> None:
    """Follow one component of the load, whose noise has the std ``noise``, and lead it by ``lag`` [s]."""
    if not begun:
        q[LEAD_FAST + at] = q[LEAD_SLOW + at] = q[LEAD_AHEAD + at] = value
        return
    keep, hold = math.exp(-dt / LEAD_FAST_TIME), math.exp(-dt / LEAD_SLOW_TIME)
    q[LEAD_FAST + at] = value + keep * (q[LEAD_FAST + at] - value)
    q[LEAD_SLOW + at] = value + hold * (q[LEAD_SLOW + at] - value)
    off = q[LEAD_FAST + at] - q[LEAD_SLOW + at]
    gate = LEAD_GATE * noise * math.sqrt(lead_variance(keep, hold))
    beyond = math.copysign(max(abs(off) - gate, 0.0), off)
    rate = beyond / (LEAD_SLOW_TIME - LEAD_FAST_TIME)
    q[LEAD_AHEAD + at] = q[LEAD_FAST + at] + (LEAD_FAST_TIME + lag) * rate


def lead_variance(keep: float, hold: float) -> float:
    """Return the variance of fast minus slow for white noise of variance 1, from what each keeps a step."""
    fast, slow = (1.0 - keep) / (1.0 + keep), (1.0 - hold) / (1.0 + hold)
    both = (1.0 - keep) * (1.0 - hold) / (1.0 - keep * hold) if keep * hold < 1.0 else 0.0
    return max(fast + slow - 2.0 * both, 0.0)
