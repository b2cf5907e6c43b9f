"""The load that the drive has to answer: what is felt, without its noise, and ahead by the drive's lag.

A force that is commanded now is there a lag later, so the load that counts is that of then. Each component of
the load (tangential force x and y, torque) passes two exponential filters; their difference shows its rate of
change::

    rate = (fast - slow) / (slow_time - fast_time),     ahead = fast + (fast_time + lag) rate .

Of the difference, ``LEAD_GATE`` standard deviations of its noise do not count: a steady load has no lead. Nor
is a load that vanishes led through zero to one that is larger than it was.

The lag is the one that is stated, or the measured one (:mod:`~vegrip.grip.drive_lag`), of which no more than
``LEAD_MOST`` is led: beyond it, the noise of the rate and the shakes of the hand cost more than the lead
gains. For the rest the finger holds more beforehand. A drive of first order with the lag L that answers a
load which grows from 1 by ``burst`` a second, led by ``LEAD_MOST``, lacks at the end of the growth, at
``1 + BURST_SIZE``::

    missing = burst (L - LEAD_MOST) (1 - exp(-BURST_SIZE / (burst L)))

so it holds against ``(1 + BURST_SIZE) / (1 + BURST_SIZE - missing)`` times the load.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.drive_lag import *
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory

LEAD_FAST_TIME = 0.003  # [s]
LEAD_SLOW_TIME = 0.012  # [s]
LEAD_GATE = 2.0  # standard deviations
LEAD_MOST = 0.015  # [s] of a measured lag
BURST_SIZE = 0.5  # of the load, by which it grows in a burst


def begin_lead(g: GraspMemory, noise: float, torque_noise: float) -> None:
    """Set the noise of the load [N], [N m]; nothing is felt yet."""
    g.lead.noise, g.lead.torque_noise = noise, torque_noise
    for i in range(BELIEF_MOST):
        g.lead.begun[i] = 0.0


def lead_load(g: GraspMemory, i: int, dt: float, x: float, y: float, torque: float) -> tuple[float, float]:
    """Take in one sample of the load of finger ``i``; return tangential force [N] and torque [N m] ahead.

    A load that is not known leads nowhere: it is returned as it is, and the next one begins anew.
    """
    turn = 0.0 if math.isnan(torque) else torque
    if not abs(x) + abs(y) + abs(turn) < math.inf:
        g.lead.begun[i] = 0.0
        return math.sqrt(x * x + y * y), abs(torque)
    begun = g.lead.begun[i] > 0.0
    g.lead.begun[i] = 1.0
    lag = lead_time(g, i)
    lead_component(g, 3 * i, dt, x, g.lead.noise, begun, lag)
    lead_component(g, 3 * i + 1, dt, y, g.lead.noise, begun, lag)
    lead_component(g, 3 * i + 2, dt, turn, g.lead.torque_noise, begun, lag)
    more = burst_reserve(g, i)
    x, y, turn = g.lead.ahead[3 * i], g.lead.ahead[3 * i + 1], g.lead.ahead[3 * i + 2]
    return more * math.sqrt(x * x + y * y), more * abs(turn)


def lead_time(g: GraspMemory, i: int) -> float:
    """Return by how much the load of finger ``i`` is led [s]."""
    if counts_measured(g, i):
        return min(g.drive.lag[i], LEAD_MOST)
    return g.drive.stated


def burst_reserve(g: GraspMemory, i: int) -> float:
    """Return how many times its load finger ``i`` holds against, for the part of the lag that is not led."""
    return reserve_for(g.drive.lag[i], g.drive.burst) if counts_measured(g, i) else 1.0


def reserve_for(lag: float, burst: float) -> float:
    """Return how many times its load a finger holds against, whose drive has this measured ``lag`` [s]."""
    late = burst * max(lag - LEAD_MOST, 0.0)
    missing = late * (1.0 - math.exp(-BURST_SIZE / (burst * lag))) if late > 0.0 else 0.0
    return (1.0 + BURST_SIZE) / (1.0 + BURST_SIZE - missing)


def counts_measured(g: GraspMemory, i: int) -> bool:
    """Return whether the measured lag of finger ``i`` counts."""
    return g.drive.known[i] > 0.0


def lead_component(
    g: GraspMemory, at: int, dt: float, value: float, noise: float, begun: bool, lag: float
) -> None:
    """Follow one component of the load, whose noise has the std ``noise``, and lead it by ``lag`` [s]."""
    if not begun:
        g.lead.fast[at] = g.lead.slow[at] = g.lead.ahead[at] = value
        return
    keep, hold = math.exp(-dt / LEAD_FAST_TIME), math.exp(-dt / LEAD_SLOW_TIME)
    g.lead.fast[at] = value + keep * (g.lead.fast[at] - value)
    g.lead.slow[at] = value + hold * (g.lead.slow[at] - value)
    off = g.lead.fast[at] - g.lead.slow[at]
    gate = LEAD_GATE * noise * math.sqrt(lead_variance(keep, hold))
    beyond = math.copysign(max(abs(off) - gate, 0.0), off)
    rate = beyond / (LEAD_SLOW_TIME - LEAD_FAST_TIME)
    ahead = g.lead.fast[at] + (LEAD_FAST_TIME + lag) * rate
    if ahead * g.lead.slow[at] < 0.0:
        ahead = math.copysign(min(abs(ahead), abs(g.lead.slow[at])), ahead)
    g.lead.ahead[at] = ahead


def lead_variance(keep: float, hold: float) -> float:
    """Return the variance of fast minus slow for white noise of variance 1, from what each keeps a step."""
    fast, slow = (1.0 - keep) / (1.0 + keep), (1.0 - hold) / (1.0 + hold)
    both = (1.0 - keep) * (1.0 - hold) / (1.0 - keep * hold) if keep * hold < 1.0 else 0.0
    return max(fast + slow - 2.0 * both, 0.0)
