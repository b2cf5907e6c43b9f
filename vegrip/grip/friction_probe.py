"""Probing: letting a finger count on more friction than is believed, slowly, while nothing happens.

What a finger counts on is the lower bound of its friction. ``b`` raises it, in logarithms: where nothing is
known of the object for all fingers, else for the one finger that is least known of those whose need decides
the grip and who have not been probed as far as may be. It grows only while no load moves fast and no slip
was felt of late, and any slip sets all of them back at once::

    b' = climb     while the object is unknown        (std of ln mu above ``unknown``)
    b' = rate      while the least known finger is not known well   (std above ``known``)

The force then falls until the finger is about to slip, or until ``b`` has reached what the belief can hold
for possible. Slip that comes is small, since only force was let go of, and teaches all fingers.

Plain scalar code over one flat sequence ``q`` of numbers, of fixed size; the same text is compiled.
"""

import math

from vegrip.grip.friction_belief import *
from vegrip.types import Numbers

PROBE_CLIMB = BELIEF_SIZE  # [1/s] of ln mu while the object is unknown
PROBE_RATE = BELIEF_SIZE + 1  # [1/s] afterwards
PROBE_UNKNOWN = BELIEF_SIZE + 2  # std of ln mu above which the object is unknown
PROBE_KNOWN = BELIEF_SIZE + 3  # and below which a finger is known well enough
PROBE_QUIET_TIME = BELIEF_SIZE + 4  # [s] without a change of any load before probing goes on
PROBE_QUIET_CHANGE = BELIEF_SIZE + 5  # relative change of a load that is one
PROBE_PAUSE = BELIEF_SIZE + 6  # [s] after a slip
PROBE_REACH = BELIEF_SIZE + 7  # standard deviations above the mean up to which it is probed
PROBE_SINCE_SLIP = BELIEF_SIZE + 8
PROBE_SHIFT = BELIEF_SIZE + 9  # b of each finger
PROBE_LOAD = PROBE_SHIFT + BELIEF_MOST  # [N] from which changes are counted
PROBE_SMOOTH = PROBE_LOAD + BELIEF_MOST  # [N] load without noise
PROBE_STILL = PROBE_SMOOTH + BELIEF_MOST  # [s] since the load last changed; negative: not in contact
PROBE_NEED = PROBE_STILL + BELIEF_MOST  # [N] what each finger needs on its own
PROBE_SIZE = PROBE_NEED + BELIEF_MOST

SMOOTHING = 0.01  # [s]
FOLLOWING = 0.1  # [s] with which the load from which changes are counted follows; a slow load is no change
LEAST_PROBE = 1e-3  # of ln mu, from which on a finger counts as let go of
REACHED = 0.99  # of how far a finger may be probed, from which on it does not keep the next one waiting


def begin_probing(
    q: Numbers,
    climb: float,
    rate: float,
    unknown: float,
    known: float,
    quiet_time: float,
    quiet_change: float,
    pause: float,
    reach: float,
) -> None:
    """Set how it probes; no finger touches yet."""
    q[PROBE_CLIMB], q[PROBE_RATE], q[PROBE_UNKNOWN], q[PROBE_KNOWN] = climb, rate, unknown, known
    q[PROBE_QUIET_TIME], q[PROBE_QUIET_CHANGE] = quiet_time, quiet_change
    q[PROBE_PAUSE], q[PROBE_REACH] = pause, reach
    q[PROBE_SINCE_SLIP] = 0.0
    for i in range(BELIEF_MOST):
        q[PROBE_SHIFT + i] = q[PROBE_LOAD + i] = q[PROBE_SMOOTH + i] = 0.0
        q[PROBE_STILL + i] = -1.0
        q[PROBE_NEED + i] = 0.0


def watch_load(q: Numbers, i: int, dt: float, load: float, noise: float, touching: bool) -> None:
    """Follow the load [N] of finger ``i``, whose noise has the std ``noise`` [N]."""
    if not (touching and load >= 0.0):
        q[PROBE_STILL + i] = -1.0
        q[PROBE_SHIFT + i] = 0.0
        return
    if q[PROBE_STILL + i] < 0.0:
        q[PROBE_SMOOTH + i] = q[PROBE_LOAD + i] = load
        q[PROBE_STILL + i] = 0.0
    q[PROBE_SMOOTH + i] += (1.0 - math.exp(-dt / SMOOTHING)) * (load - q[PROBE_SMOOTH + i])
    q[PROBE_STILL + i] += dt
    q[PROBE_LOAD + i] += (1.0 - math.exp(-dt / FOLLOWING)) * (q[PROBE_SMOOTH + i] - q[PROBE_LOAD + i])
    change = abs(q[PROBE_SMOOTH + i] - q[PROBE_LOAD + i])
    if change > q[PROBE_QUIET_CHANGE] * q[PROBE_LOAD + i] + 2.0 * noise:
        q[PROBE_LOAD + i] = q[PROBE_SMOOTH + i]
        q[PROBE_STILL + i] = 0.0


def feel_slip(q: Numbers, dt: float, fingers: int, slipping: bool) -> None:
    """Note whether a finger slips: then nothing is probed any more."""
    q[PROBE_SINCE_SLIP] += dt / float(max(fingers, 1))
    if slipping:
        q[PROBE_SINCE_SLIP] = 0.0
        for j in range(fingers):
            q[PROBE_SHIFT + j] = 0.0


def is_quiet(q: Numbers, fingers: int) -> bool:
    """Return whether no finger has slipped and no load has changed for a while."""
    for j in range(fingers):
        if 0.0 <= q[PROBE_STILL + j] < q[PROBE_QUIET_TIME]:
            return False
    return q[PROBE_SINCE_SLIP] >= q[PROBE_PAUSE]


def farthest(g: Numbers, q: Numbers, i: int, lag: float) -> float:
    """Return how far finger ``i`` may be probed, of ln mu."""
    return (lag + q[PROBE_REACH]) * math.sqrt(believed_variance(g, i))


def probe_friction(g: Numbers, q: Numbers, i: int, dt: float, lag: float) -> None:
    """Let ``b`` of finger ``i`` grow where it may; ``lag`` is how many std are counted off the mean."""
    n = int(g[BELIEF_FINGERS])
    std = math.sqrt(believed_variance(g, i))
    rate = q[PROBE_CLIMB] if std > q[PROBE_UNKNOWN] else q[PROBE_RATE]
    most = farthest(g, q, i, lag)
    if std < q[PROBE_KNOWN] or not is_quiet(q, n):
        return
    others = 0.0
    for j in range(1, n):
        others += q[PROBE_NEED + j]
    if std <= q[PROBE_UNKNOWN]:
        for j in range(n):
            decides = others >= q[PROBE_NEED] if j > 0 else q[PROBE_NEED] >= others
            vaguer = believed_variance(g, j) > believed_variance(g, i)
            if j != i and decides and vaguer and q[PROBE_SHIFT + j] < REACHED * farthest(g, q, j, lag):
                return
    q[PROBE_SHIFT + i] = min(q[PROBE_SHIFT + i] + rate * dt, max(most, q[PROBE_SHIFT + i]))
