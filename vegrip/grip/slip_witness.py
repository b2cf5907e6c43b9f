"""The load as a witness of a slide: while the object holds, T stays as N falls; while it slides, T = mu N.

N and T are the sums of the normal and tangential forces of the fingers: what one gives up the others take.
While force is let go of, ::

    y = FOLLOWS ln N - ln T,     dy / d ln N = FOLLOWS while it holds,     FOLLOWS - 1 while it slides

so the rise of y above its least of late is the test of [Page1954]_ for the moment at which a slide begins. It
counts from ``RISE`` on, or from five standard deviations of its noise; where that is beyond ``BLIND``,
nothing is let go of. The least y is forgotten within ``PAUSE``, because a load that changes slowly is no
slide; nor is one that fades more than ``GOES_AWAY`` times as fast as N.

It was a slide if T comes back with N: within ``RETURN`` and the delay of the channels T must rise from its
least by more than half of what it had fallen by. A load that went away does not come back with the grip. Then
each channel that has not told it has missed a slide.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.slip_channels import *


def begin_witness(g: GraspMemory, noise: float) -> None:
    """Have seen nothing; ``noise`` is the std of a tangential force [N]."""
    g.witness.noise, g.witness.least = noise, math.inf


def follow_forces(g: GraspMemory, i: int, dt: float, force: float, pull: float, touching: bool) -> None:
    """Take in normal and tangential force [N] of finger ``i``."""
    is_known = touching and force > 0.0 and pull >= 0.0
    if is_known != (g.witness.forces[i] > 0.0):  # the sums are of other fingers from now on
        g.witness.least, g.witness.chance = math.inf, 0.0
    if not is_known:
        g.witness.forces[i] = g.witness.pulls[i] = 0.0
        return
    part = 1.0 - math.exp(-dt / LOOK) if g.witness.forces[i] > 0.0 else 1.0
    g.witness.forces[i] += part * (force - g.witness.forces[i])
    g.witness.pulls[i] += part * (pull - g.witness.pulls[i])


def rise_needed(g: GraspMemory, dt: float) -> float:
    """Return the rise of y that is no noise; ``dt`` [s] is from sample to sample of one finger."""
    n = int(g.belief.fingers)
    pull = 0.0
    for i in range(n):
        pull += g.witness.pulls[i]
    if not (pull > 0.0 and dt > 0.0):
        return math.inf
    std = g.witness.noise * math.sqrt(g.belief.fingers * dt / (dt + 2.0 * LOOK))
    return max(RISE, OUTLIER * std / pull)


def is_slow(g: GraspMemory, dt: float, force: float) -> bool:
    """Return whether N, ``force`` [N] now, has begun to fall and falls too slowly to show a slide in time.

    While ln N falls by v a second, a part ``v t`` of the weight is missing after t. What is needed to see it,
    ``rise_needed / (1 - FOLLOWS)``, is missing once the object has slid by ``g (v t)^3 / (6 v^2)``. v is that
    of the last ``RETURN``: a fall that has just begun counts as slower, at most as 1.1 a second.
    """
    g.witness.lagging += (1.0 - math.exp(-dt / RETURN)) * (force - g.witness.lagging)
    if force >= (1.0 - BLIND) * g.witness.first:
        return False
    missing = rise_needed(g, dt * g.belief.fingers) / (1.0 - FOLLOWS)
    rate = math.log(g.witness.lagging / force) / RETURN
    return rate < math.sqrt(GRAVITY * missing * missing * missing / (6.0 * HIDDEN))


def sees_slide(g: GraspMemory, dt: float, let_go: float, changed: bool) -> bool:
    """Return whether the object has begun to slide, force having been ``let_go`` of [ln N].

    A load that has ``changed`` meanwhile may slide, too, where N may have made it: until it comes back it
    counts as it was, but no channel is judged by it.
    """
    n = int(g.belief.fingers)
    force, pull = 0.0, 0.0
    for i in range(n):
        force += g.witness.forces[i]
        pull += g.witness.pulls[i]
    part = dt / g.belief.fingers
    if g.witness.waits > 0.0:
        wait_for_verdict(g, part, pull)
        return False
    if not (let_go > 0.0 and force > 0.0 and pull > 0.0):
        g.witness.least = math.inf
        g.witness.first = g.witness.lagging = force
        return False
    y = FOLLOWS * math.log(force) - math.log(pull)
    is_seen = y - g.witness.least > rise_needed(g, dt)
    if is_seen or (changed and y > g.witness.least):
        if math.log(g.witness.pull / pull) > GOES_AWAY * math.log(g.witness.force / force):
            g.witness.least = math.inf
            return False
        g.witness.lost = g.witness.pull - pull
        g.witness.least = math.inf
        likely = 0.0
        for i in range(n):
            likely = max(likely, g.slip.likely[i])
        g.witness.chance = chance(logit(likely) + logit(SURE)) if is_seen else 0.0
        if g.witness.lost > 0.0:
            g.witness.waits, g.witness.rested = RETURN + g.slip.delay, 0.0
            g.witness.low = g.witness.high = pull
        return is_seen
    part = 1.0 if y <= g.witness.least else 1.0 - math.exp(-part / PAUSE)
    if g.witness.least == math.inf:
        g.witness.least = y
    g.witness.least += part * (y - g.witness.least)
    g.witness.pull += part * (pull - g.witness.pull)
    g.witness.force += part * (force - g.witness.force)
    return False


def watch_part(g: GraspMemory, i: int, dt: float, let_go: float) -> None:
    """Note whether finger ``i`` has slid by itself, force having been ``let_go`` of.

    The others take its load, so the sums show nothing; its own T falls with its own N.
    """
    force, pull = g.witness.forces[i], g.witness.pulls[i]
    if not (let_go > 0.0 and force > 0.0 and pull > 0.0):
        g.witness.part[i], g.witness.slid[i] = math.inf, 0.0
        return
    y = FOLLOWS * math.log(force) - math.log(pull)
    g.witness.part[i] = min(g.witness.part[i], y)
    std = g.witness.noise * math.sqrt(dt / (dt + 2.0 * LOOK))
    if y - g.witness.part[i] > max(RISE, OUTLIER * std / pull):
        g.witness.slid[i] = 1.0


def wait_for_verdict(g: GraspMemory, dt: float, pull: float) -> None:
    """Wait until the grip is back; then a slide that no channel has told was missed."""
    g.witness.waits -= dt
    g.witness.rested += dt
    g.witness.lack = max(min(math.log(max(pull, NEARLY_NONE) / g.witness.pull), 0.0), -BLIND)
    if pull < g.witness.low:
        g.witness.low = g.witness.high = pull
    g.witness.high = max(g.witness.high, pull)
    if g.witness.waits > 0.0:
        return
    g.witness.waits = g.witness.lack = 0.0
    if g.witness.high > g.witness.low + 0.5 * g.witness.lost:
        judge_slide(g, g.witness.rested + 2.0 * g.slip.delay, g.witness.chance)
