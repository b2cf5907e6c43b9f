"""Probing: letting a finger count on more friction than is believed, slowly, while nothing happens.

What a finger counts on is the lower bound of its friction. ``b`` raises it, in logarithms: where nothing is
known of the object for all fingers, else for the one finger that is least known of those whose need decides
the grip and who have not been probed as far as may be. It grows only while no load moves fast and no slip
was felt of late, and any slip sets all of them back at once::

    b' = climb     while the object is unknown        (std of ln mu above ``unknown``)
    b' = rate      while the least known finger is not known well   (std above ``known``)

The force then falls until the finger is about to slip, or until ``b`` has reached what the belief can hold
for possible. Slip that comes is small, since only force was let go of, and teaches all fingers.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.friction_belief import *
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory

SMOOTHING = 0.01  # [s]
FOLLOWING = 0.1  # [s] with which the load from which changes are counted follows; a slow load is no change
LEAST_PROBE = 1e-3  # of ln mu, from which on a finger counts as let go of
REACHED = 0.99  # of how far a finger may be probed, from which on it does not keep the next one waiting


def begin_probing(
    g: GraspMemory,
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
    g.probe.climb, g.probe.rate, g.probe.unknown, g.probe.known = climb, rate, unknown, known
    g.probe.quiet_time, g.probe.quiet_change = quiet_time, quiet_change
    g.probe.pause, g.probe.reach = pause, reach
    g.probe.since_slip = 0.0
    for i in range(BELIEF_MOST):
        g.probe.shift[i] = g.probe.load[i] = g.probe.smooth[i] = 0.0
        g.probe.still[i] = -1.0
        g.probe.need[i] = 0.0


def watch_load(g: GraspMemory, i: int, dt: float, load: float, noise: float, touching: bool) -> None:
    """Follow the load [N] of finger ``i``, whose noise has the std ``noise`` [N]."""
    if not (touching and load >= 0.0):
        g.probe.still[i] = -1.0
        g.probe.shift[i] = 0.0
        return
    if g.probe.still[i] < 0.0:
        g.probe.smooth[i] = g.probe.load[i] = load
        g.probe.still[i] = 0.0
    g.probe.smooth[i] += (1.0 - math.exp(-dt / SMOOTHING)) * (load - g.probe.smooth[i])
    g.probe.still[i] += dt
    g.probe.load[i] += (1.0 - math.exp(-dt / FOLLOWING)) * (g.probe.smooth[i] - g.probe.load[i])
    change = abs(g.probe.smooth[i] - g.probe.load[i])
    if change > g.probe.quiet_change * g.probe.load[i] + 2.0 * noise:
        g.probe.load[i] = g.probe.smooth[i]
        g.probe.still[i] = 0.0


def feel_slip(g: GraspMemory, dt: float, fingers: int, slipping: bool) -> None:
    """Note whether a finger slips: then nothing is probed any more."""
    g.probe.since_slip += dt / float(max(fingers, 1))
    if slipping:
        g.probe.since_slip = 0.0
        for j in range(fingers):
            g.probe.shift[j] = 0.0


def is_quiet(g: GraspMemory, fingers: int) -> bool:
    """Return whether no finger has slipped and no load has changed for a while."""
    for j in range(fingers):
        if 0.0 <= g.probe.still[j] < g.probe.quiet_time:
            return False
    return g.probe.since_slip >= g.probe.pause


def farthest(g: GraspMemory, i: int, lag: float) -> float:
    """Return how far finger ``i`` may be probed, of ln mu."""
    return (lag + g.probe.reach) * math.sqrt(believed_variance(g, i))


def probe_friction(g: GraspMemory, i: int, dt: float, lag: float) -> None:
    """Let ``b`` of finger ``i`` grow where it may; ``lag`` is how many std are counted off the mean."""
    n = int(g.belief.fingers)
    std = math.sqrt(believed_variance(g, i))
    rate = g.probe.climb if std > g.probe.unknown else g.probe.rate
    most = farthest(g, i, lag)
    if std < g.probe.known or not is_quiet(g, n):
        return
    others = 0.0
    for j in range(1, n):
        others += g.probe.need[j]
    if std <= g.probe.unknown:
        for j in range(n):
            decides = others >= g.probe.need[0] if j > 0 else g.probe.need[0] >= others
            vaguer = believed_variance(g, j) > believed_variance(g, i)
            if j != i and decides and vaguer and g.probe.shift[j] < REACHED * farthest(g, j, lag):
                return
    g.probe.shift[i] = min(g.probe.shift[i] + rate * dt, max(most, g.probe.shift[i]))
