"""Incipient slip as evidence of friction: a finger that begins to creep is at its limit.

A slip channel that is finer than the slides which a finger's own estimate learns from (it wants them fast
and steady) tells of creep long before. From ``ONSET_RUN_LENGTH`` samples of it in a row, the mean of ln u is
a measurement of ln mu, u being the friction coefficient at which the present load would slip. Once a run,
and only

* where two samples in a row say so; one, where another finger has just slipped, or where the finger was being
  let go of and u is not below what was to be expected;
* where the slip speed, if it is measured, shows a slide, at the latest ``ONSET_QUIET_TIME`` after the flag: a
  slide that begins slowly passes the threshold of the flag first;
* where u is known well: a light touch tells nothing;
* where the channel was quiet before, so that one that says slip all the time teaches at most once;
* where u is not below ``ONSET_BELOW`` of what the finger held a moment ago: else the grip is back, and the
  channel late.

What its channel alone tells may be false, the finger not being let go of and no other having just slipped:
it counts with ``ONSET_ALONE`` times the noise, and a finger's own estimate learns nothing of it.

It moves the belief by no more than a slip at ``ONSET_BOUND`` standard deviations would. What lies below
``ONSET_FAR``, where friction does not fall so fast, is counted: a channel that goes on so is not believed any
more.

Plain scalar code over the flat sequence of :mod:`~vegrip.grip.friction_probe`, behind its sections.
"""

import math

from vegrip.grip.friction_probe import *
from vegrip.types import Numbers

ONSET_NOISE = PROBE_SIZE  # std of ln mu from one onset to the next
ONSET_SHOCK = PROBE_SIZE + 1  # std of ln mu of what befalls all faces at once
ONSET_RUN = PROBE_SIZE + 2  # samples of slip in a row; negative: this run does not count, or has taught
ONSET_SUM = ONSET_RUN + BELIEF_MOST  # of ln u in this run
ONSET_QUIET = ONSET_SUM + BELIEF_MOST  # [s] since the last sample of slip
ONSET_HELD = ONSET_QUIET + BELIEF_MOST  # largest u that was held of late
ONSET_DOUBTED = ONSET_HELD + BELIEF_MOST  # how often the channel contradicted the load
ONSET_SILENT = ONSET_DOUBTED + BELIEF_MOST  # 1 while slip is not sensed
ONSET_SIZE = ONSET_SILENT + BELIEF_MOST

ONSET_RUN_LENGTH = 2.0
ONSET_PROBED_LENGTH = 1.0  # the same where the finger was being let go of: there slip is expected
ONSET_PROBED = 0.05  # of ln mu by which it was let go
ONSET_PROBED_BELOW = 1.5  # standard deviations below the mean down to which slip is expected
ONSET_TOGETHER = 0.1  # [s] within which fingers that slip confirm each other
ONSET_ALONE = 3.0  # times the std of an onset that nothing else tells
ONSET_CREEP = 1e-4  # [m/s] below which a slip speed, where it is measured, shows no onset
ONSET_VAGUE = 0.1  # relative std of u beyond which nothing is learned
ONSET_QUIET_TIME = 0.05  # [s] without slip before an onset
ONSET_FAR = 0.6  # of what was held: friction does not fall below this within ONSET_FADING
ONSET_BELOW = 0.8  # of the same, below which the slide is over, and tells nothing
ONSET_FADING = 0.3  # [s]
ONSET_BOUND = 2.5  # standard deviations
ONSET_FAR_BELOW = 2.5  # as FAR_BELOW of the belief
ONSET_TAUGHT = -2.0  # of ONSET_RUN
ONSET_DOUBTS = 3.0  # contradictions from which on a channel is not believed


def begin_onsets(q: Numbers, noise: float, shock: float) -> None:
    """Set how well an onset tells friction; nothing was felt yet."""
    q[ONSET_NOISE], q[ONSET_SHOCK] = noise, shock
    for i in range(BELIEF_MOST):
        q[ONSET_RUN + i] = q[ONSET_SUM + i] = q[ONSET_HELD + i] = q[ONSET_DOUBTED + i] = 0.0
        q[ONSET_QUIET + i], q[ONSET_SILENT + i] = 1.0, 0.0


def is_doubted(q: Numbers, i: int) -> bool:
    """Return whether the slip channel of finger ``i`` has contradicted its load too often."""
    return q[ONSET_DOUBTED + i] >= ONSET_DOUBTS


def has_taught(q: Numbers, i: int) -> bool:
    """Return whether the slip that finger ``i`` tells has taught by its onset, or may not teach at all."""
    return q[ONSET_RUN + i] == ONSET_TAUGHT


def is_heard(q: Numbers, i: int) -> bool:
    """Return whether the slip of finger ``i`` is sensed and believed, and force may be let go of at all."""
    return q[PROBE_CLIMB] > 0.0 and q[ONSET_SILENT + i] == 0.0 and not is_doubted(q, i)


def feel_onset(
    g: Numbers,
    q: Numbers,
    i: int,
    dt: float,
    u: float,
    relative: float,
    slip: float,
    speed: float,
) -> None:
    """Take in one sample of finger ``i``.

    Args:
        g: the belief.
        q: the state.
        i: the finger.
        dt: [s] since the last sample.
        u: utilisation at mu = 1.
        relative: its relative std.
        slip: whether it slips; NaN = not sensed.
        speed: slip speed [m/s]; NaN = not measured.

    """
    q[ONSET_SILENT + i] = 1.0 if math.isnan(slip) else 0.0
    q[ONSET_HELD + i] *= math.exp(-dt / ONSET_FADING)
    known = 0.0 < u < math.inf and relative < ONSET_VAGUE
    if not slip >= 0.5:
        q[ONSET_RUN + i] = 0.0
        q[ONSET_QUIET + i] += dt
        if known and slip < 0.5:
            q[ONSET_HELD + i] = max(q[ONSET_HELD + i], u)
        return
    if q[ONSET_RUN + i] == 0.0:
        q[ONSET_SUM + i] = 0.0
        if q[ONSET_QUIET + i] < ONSET_QUIET_TIME:
            q[ONSET_RUN + i] = -1.0
    if q[ONSET_RUN + i] == 0.0 and speed < ONSET_CREEP:
        q[ONSET_QUIET + i] = min(q[ONSET_QUIET + i], 2.0 * ONSET_QUIET_TIME) - dt
        return
    q[ONSET_QUIET + i] = 0.0
    if q[ONSET_RUN + i] < 0.0 or not known or speed < ONSET_CREEP:
        return
    q[ONSET_RUN + i] += 1.0
    q[ONSET_SUM + i] += math.log(u)
    if q[ONSET_RUN + i] >= onset_length(g, q, i):
        mean = q[ONSET_SUM + i] / q[ONSET_RUN + i]
        q[ONSET_RUN + i] = -1.0
        take_onset(g, q, i, mean, relative)


def onset_length(g: Numbers, q: Numbers, i: int) -> float:
    """Return how many samples of slip in a row make an onset, at the mean ln u of this run.

    A probe ends with the first sample, because the force comes back; one is enough where slip is expected. So
    it is where another finger has just slipped, since two channels say it.
    """
    if is_told_by_another(g, q, i):
        return ONSET_PROBED_LENGTH
    spread = math.sqrt(believed_variance(g, i) + q[ONSET_NOISE] * q[ONSET_NOISE])
    expected = g[BELIEF_MEAN + i] - ONSET_PROBED_BELOW * spread
    probed = q[PROBE_SHIFT + i] > ONSET_PROBED and q[ONSET_SUM + i] > q[ONSET_RUN + i] * expected
    return ONSET_PROBED_LENGTH if probed else ONSET_RUN_LENGTH


def is_told_by_another(g: Numbers, q: Numbers, i: int) -> bool:
    """Return whether a finger other than ``i`` has just slipped."""
    quiet = math.inf
    for j in range(int(g[BELIEF_FINGERS])):
        if j != i:
            quiet = min(quiet, q[ONSET_QUIET + j])
    return quiet < ONSET_TOGETHER


def is_witnessed(g: Numbers, q: Numbers, i: int) -> bool:
    """Return whether slip of finger ``i`` is more than what its channel alone says."""
    return q[PROBE_SHIFT + i] > ONSET_PROBED or is_told_by_another(g, q, i)


def take_onset(g: Numbers, q: Numbers, i: int, ln_u: float, relative: float) -> None:
    """Measure ln mu of finger ``i`` by the load at which it began to slip."""
    q[ONSET_RUN + i] = ONSET_TAUGHT
    u, held = math.exp(ln_u), q[ONSET_HELD + i]
    q[ONSET_DOUBTED + i] += 1.0 if u < ONSET_FAR * held else 0.0
    if u < ONSET_BELOW * held or is_doubted(q, i):
        return
    std = q[ONSET_NOISE] if is_witnessed(g, q, i) else ONSET_ALONE * q[ONSET_NOISE]
    noise = std * std + relative * relative
    widen_belief(g)
    off = ln_u - g[BELIEF_MEAN + i]
    if off < -ONSET_FAR_BELOW * math.sqrt(believed_variance(g, i) + noise):
        add_common(g, q[ONSET_SHOCK] * q[ONSET_SHOCK])
    most = ONSET_BOUND * math.sqrt(believed_variance(g, i) + noise)
    measured = g[BELIEF_MEAN + i] + min(max(off, -most), most)
    absorb_factor(g, i, 1.0 / noise, measured / noise)
