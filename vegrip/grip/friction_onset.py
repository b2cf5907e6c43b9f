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

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.friction_probe import *
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory

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


def begin_onsets(g: GraspMemory, noise: float, shock: float) -> None:
    """Set how well an onset tells friction; nothing was felt yet."""
    g.onset.noise, g.onset.shock = noise, shock
    for i in range(BELIEF_MOST):
        g.onset.run[i] = g.onset.sum[i] = g.onset.held[i] = g.onset.doubted[i] = 0.0
        g.onset.quiet[i], g.onset.silent[i] = 1.0, 0.0


def is_doubted(g: GraspMemory, i: int) -> bool:
    """Return whether the slip channel of finger ``i`` has contradicted its load too often."""
    return g.onset.doubted[i] >= ONSET_DOUBTS


def has_taught(g: GraspMemory, i: int) -> bool:
    """Return whether the slip that finger ``i`` tells has taught by its onset, or may not teach at all."""
    return g.onset.run[i] == ONSET_TAUGHT


def is_heard(g: GraspMemory, i: int) -> bool:
    """Return whether the slip of finger ``i`` is sensed and believed, and force may be let go of at all."""
    return g.probe.climb > 0.0 and g.onset.silent[i] == 0.0 and not is_doubted(g, i)


def feel_onset(
    g: GraspMemory,
    i: int,
    dt: float,
    u: float,
    relative: float,
    slip: float,
    speed: float,
) -> None:
    """Take in one sample of finger ``i``.

    Args:
        g: what the grasp shares.
        i: the finger.
        dt: [s] since the last sample.
        u: utilisation at mu = 1.
        relative: its relative std.
        slip: whether it slips; NaN = not sensed.
        speed: slip speed [m/s]; NaN = not measured.

    """
    g.onset.silent[i] = 1.0 if math.isnan(slip) else 0.0
    g.onset.held[i] *= math.exp(-dt / ONSET_FADING)
    known = 0.0 < u < math.inf and relative < ONSET_VAGUE
    if not slip >= 0.5:
        g.onset.run[i] = 0.0
        g.onset.quiet[i] += dt
        if known and slip < 0.5:
            g.onset.held[i] = max(g.onset.held[i], u)
        return
    if g.onset.run[i] == 0.0:
        g.onset.sum[i] = 0.0
        if g.onset.quiet[i] < ONSET_QUIET_TIME:
            g.onset.run[i] = -1.0
    if g.onset.run[i] == 0.0 and speed < ONSET_CREEP:
        g.onset.quiet[i] = min(g.onset.quiet[i], 2.0 * ONSET_QUIET_TIME) - dt
        return
    g.onset.quiet[i] = 0.0
    if g.onset.run[i] < 0.0 or not known or speed < ONSET_CREEP:
        return
    g.onset.run[i] += 1.0
    g.onset.sum[i] += math.log(u)
    if g.onset.run[i] >= onset_length(g, i):
        mean = g.onset.sum[i] / g.onset.run[i]
        g.onset.run[i] = -1.0
        take_onset(g, i, mean, relative)


def onset_length(g: GraspMemory, i: int) -> float:
    """Return how many samples of slip in a row make an onset, at the mean ln u of this run.

    A probe ends with the first sample, because the force comes back; one is enough where slip is expected. So
    it is where another finger has just slipped, since two channels say it.
    """
    if is_told_by_another(g, i):
        return ONSET_PROBED_LENGTH
    spread = math.sqrt(believed_variance(g, i) + g.onset.noise * g.onset.noise)
    expected = believed_mean(g, i) - ONSET_PROBED_BELOW * spread
    probed = g.probe.shift[i] > ONSET_PROBED and g.onset.sum[i] > g.onset.run[i] * expected
    return ONSET_PROBED_LENGTH if probed else ONSET_RUN_LENGTH


def is_told_by_another(g: GraspMemory, i: int) -> bool:
    """Return whether a finger other than ``i`` has just slipped."""
    quiet = math.inf
    for j in range(int(g.belief.fingers)):
        if j != i:
            quiet = min(quiet, g.onset.quiet[j])
    return quiet < ONSET_TOGETHER


def is_witnessed(g: GraspMemory, i: int) -> bool:
    """Return whether slip of finger ``i`` is more than what its channel alone says."""
    return g.probe.shift[i] > ONSET_PROBED or is_told_by_another(g, i)


def take_onset(g: GraspMemory, i: int, ln_u: float, relative: float) -> None:
    """Measure ln mu of finger ``i`` by the load at which it began to slip."""
    g.onset.run[i] = ONSET_TAUGHT
    u, held = math.exp(ln_u), g.onset.held[i]
    g.onset.doubted[i] += 1.0 if u < ONSET_FAR * held else 0.0
    if u < ONSET_BELOW * held or is_doubted(g, i):
        return
    std = g.onset.noise if is_witnessed(g, i) else ONSET_ALONE * g.onset.noise
    noise = std * std + relative * relative
    widen_belief(g)
    off = ln_u - believed_mean(g, i)
    if off < -ONSET_FAR_BELOW * math.sqrt(believed_variance(g, i) + noise):
        add_common(g, g.onset.shock * g.onset.shock)
    most = ONSET_BOUND * math.sqrt(believed_variance(g, i) + noise)
    measured = believed_mean(g, i) + min(max(off, -most), most)
    absorb_factor(g, i, g.belief.load[i], 1.0 / noise, measured / noise)
