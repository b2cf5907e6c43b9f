"""Whether a finger slides by what it feels, and whether its flag and its slip speed can be believed.

A finger slides where its slip flag says so, or where its slip speed is above ``sliding``: part of a patch
slides before all of it does, above all under a twist. Both are held against the load. With u the friction
coefficient at which the present load would slip, a contact that slides has u = mu, and it stops when the grip
has grown and u has fallen. What a channel says with no more than ``FELT_BURST`` of silence between is one
burst. Below ``FELT_FALLEN`` of the largest u of a burst the slide is over, whatever the channel says: the
grip does not grow any more. And

* a channel that says slip there for ``FELT_FALLEN_TIME``, after the delay that it is told to have,
  contradicts the load; so does a flag for ``FELT_EMPTY_TIME`` without any slip speed, where that is
  measured; single samples count for ``FELT_LEAST_TIME`` each, and are forgotten within ``FELT_FORGET``;
* a flag that is silent for ``FELT_SILENT_TIME`` while the slip speed shows a slide of a patch that is not
  twisted does not tell, or tells too late;
* a channel is deaf that does not tell a slide which the load shows (:mod:`~vegrip.grip.slip_trust`).

Such a channel is not believed for ``FELT_DISTRUST`` after it has last said slip: it counts as not sensed.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory
from vegrip.grip.load_lead import *

FELT_BY_LOAD, FELT_BY_OTHER, FELT_SILENT, FELT_DEAF = 1.0, 2.0, 3.0, 4.0

FELT_FALLEN = 0.6
FELT_FALLEN_TIME = 0.03  # [s]
FELT_LEAST_TIME = 0.01  # [s]
FELT_BURST = 1.0  # [s]
FELT_FORGET = 2.0  # [s]
FELT_SILENCE = 0.5  # [s] of silence that must come before what a flag tells teaches friction
FELT_EMPTY_TIME = 0.05  # [s]
FELT_SILENT_TIME = 0.15  # [s]
FELT_DISTRUST = 30.0  # [s]
FELT_CREEP = 1e-4  # [m/s] below which a slip speed shows none
FELT_TWIST = 0.5  # share of a twist in the load from which a patch may slide in part


def begin_felt_slip(g: GraspMemory, sliding: float, delay: float) -> None:
    """Set from which slip speed [m/s] a finger slides, and by how much that is late [s]; all is believed."""
    g.felt.sliding, g.felt.delay = sliding, delay
    for at in range(2 * BELIEF_MOST):
        g.felt.quiet[at] = g.felt.began[at] = g.felt.low[at] = g.felt.over[at] = 0.0
        g.felt.against[at] = g.felt.off[at] = g.felt.why[at] = g.felt.live[at] = 0.0


def believed_flag(g: GraspMemory, i: int, slip: float) -> float:
    """Return the slip flag of finger ``i``: NaN while it is not believed, 0 where the slide is over.

    A flag is 0 or 1; what lies between is none.
    """
    return believed(g, i, slip) if slip <= 0.0 or slip >= 1.0 else math.nan


def believed_speed(g: GraspMemory, i: int, speed: float) -> float:
    """Return the slip speed [m/s] of finger ``i``, as :func:`believed_flag`."""
    return believed(g, BELIEF_MOST + i, speed)


def believed(g: GraspMemory, at: int, value: float) -> float:
    """Return what the channel at ``at`` says, as far as it is believed."""
    if g.felt.off[at] > 0.0:
        return math.nan
    return 0.0 if value > 0.0 and g.felt.over[at] > 0.0 else value


def may_teach(g: GraspMemory, i: int) -> bool:
    """Return whether slip that the flag of finger ``i`` tells is evidence.

    The flag has been silent before, and the onset of this slip has not taught: one slip is one sample of what
    friction is, and counted twice it makes the belief too sure.
    """
    return g.felt.live[i] >= FELT_SILENCE and not has_taught(g, i)


def shows_sliding(g: GraspMemory, speed: float) -> bool:
    """Return whether a slip speed [m/s] is one of a finger that slides."""
    return g.felt.sliding > 0.0 and speed >= g.felt.sliding


def twist_share(tangential: float, load: float) -> float:
    """Return the share of the twist [-] in a ``load`` [N] of which ``tangential`` [N] is none."""
    return 1.0 - tangential / load if load > 0.0 else 0.0


def judge_felt_slip(
    g: GraspMemory, i: int, dt: float, slip: float, speed: float, u: float, twist: float
) -> None:
    """Hold what finger ``i`` feels against its load.

    Args:
        g: what the grasp shares.
        i: the finger.
        dt: [s] since the last sample.
        slip: flag as it is sensed.
        speed: slip speed as it is sensed [m/s].
        u: friction coefficient at which the present load would slip; NaN = not known.
        twist: share of the twist in the load [-].

    """
    flagged, slides = slip >= 0.5, shows_sliding(g, speed)
    flag, fast = i, BELIEF_MOST + i
    lasts = max(dt, FELT_LEAST_TIME) if g.felt.quiet[flag] > 0.0 else dt
    follow_claim(g, flag, dt, flagged, u)
    follow_claim(g, fast, dt, slides, u)
    if math.isnan(slip):
        g.felt.live[flag] = 0.0
    elif not flagged:
        g.felt.live[flag] = min(g.felt.live[flag] + dt, FELT_SILENCE)
    empty = flagged and speed < FELT_CREEP
    silent = slides and slip < 0.5 and twist < FELT_TWIST and g.felt.off[fast] <= 0.0
    g.felt.against[flag] *= math.exp(-dt / FELT_FORGET)
    g.felt.against[flag] += lasts if empty else 0.0
    g.felt.against[fast] = g.felt.against[fast] + dt if silent else 0.0
    if empty and g.felt.against[flag] > FELT_EMPTY_TIME + g.felt.delay:
        distrust(g, flag, FELT_BY_OTHER, FELT_DISTRUST)
    if g.felt.against[fast] > FELT_SILENT_TIME + g.felt.delay:
        distrust(g, flag, FELT_SILENT, FELT_DISTRUST)


def follow_claim(g: GraspMemory, at: int, dt: float, says: bool, u: float) -> None:
    """Follow the channel at ``at``, which ``says`` that the finger slides or not."""
    known = 0.0 < u < math.inf
    g.felt.low[at] *= math.exp(-dt / FELT_FORGET)
    g.felt.over[at] = g.felt.over[at] + dt if known and u < FELT_FALLEN * g.felt.began[at] else 0.0
    if not says:
        g.felt.quiet[at] += dt
        if g.felt.quiet[at] > FELT_BURST:
            g.felt.began[at] = 0.0
        g.felt.off[at] = max(g.felt.off[at] - dt, 0.0)
        return
    if known:
        g.felt.began[at] = max(g.felt.began[at], u)
    if g.felt.over[at] > g.felt.delay:
        g.felt.low[at] += max(dt, FELT_LEAST_TIME) if g.felt.quiet[at] > 0.0 else dt
        if g.felt.low[at] > FELT_FALLEN_TIME:
            distrust(g, at, FELT_BY_LOAD, FELT_DISTRUST)
    g.felt.quiet[at] = 0.0


def distrust(g: GraspMemory, at: int, why: float, lasts: float) -> None:
    """Do not believe the channel at ``at`` for so long [s] after it has last said slip."""
    g.felt.off[at], g.felt.why[at] = max(lasts, g.felt.off[at]), why
