"""Supervision of one finger's input: what arrives must be new, alive, believable and in time.

======================  ====================================================================================
what is seen            condition
======================  ====================================================================================
nothing for `time_out`  STALE (MISSING when there never was anything; CORRUPT while frames come but are bad)
state too late          STALE: it took `time_out` longer than the quickest one; clocks need not agree
counter or stamp        REPLAYED: runs backwards or stands still
a value out of range    OUT_OF_RANGE, infinities included
all values frozen       FROZEN: the counter runs, every mechanical channel repeats itself to the last bit
normal force frozen     FROZEN: the same of the normal force alone, for longer; at once when it has noise,
                        or when the tip is pressed in or unloaded meanwhile
tangential force frozen FROZEN: the same after `frozen_after` when it has noise, and the finger presses; so
                        of a torque
no force, no position   MISSING
a channel went missing  DEGRADED: it had been there; the rest is good
======================  ====================================================================================

Before a normal force that stands still counts as frozen, it is `doubtful`: it may be a coarse sensor at rest,
so control goes on, but lowers nothing on its word.

A fault is seen at once and left only after `recover_after` good states in a row: hysteresis, so that a loose
plug does not toggle the controller. This protects against faults, not attackers (keys are the transport's).
"""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.noise import noise_vanished
from vegrip.grip.kernels.stillness import all_still, force_still, has_travelled

# [ns] by which a stamp may be ahead of the sender's clock as it was; more is no clock of a hand
FAR_AHEAD = 86_400_000_000_000
DRIFT_PART = 5000  # two quartz clocks part by less than one part in so many, with a wide berth
NO_QUICKEST = 4611686018427387904  # [ns] nothing has come yet


def accept_state(f: Floats, t: Wholes, now: int) -> bool:
    """Judge the present state, arriving at ``now`` [ns]; return whether the estimator may use it."""
    found = judge_order(t)
    found = max(found, judge_lateness(f, t, now))
    found = max(found, judge_values(f, t, now))
    found = max(found, judge_channels(f, t))
    t.input.seq, t.input.stamp, t.input.is_known = t.news.seq, t.news.stamp, 1
    t.input.received, t.input.is_received = now, 1
    replayed = t.input.condition == CONDITION_REPLAYED
    judge(t, found)
    return found <= CONDITION_DEGRADED and (not replayed or t.input.condition <= CONDITION_DEGRADED)


def watch_silence(f: Floats, t: Wholes, now: int) -> None:
    """Look at the clock: silence beyond the time-out is a fault."""
    if t.input.is_received == 0:
        t.input.received, t.input.is_received = now, 1
    if float(elapsed_time(now, t.input.received)) > f.rule.time_out:
        since_corrupt = float(elapsed_time(now, t.input.corrupt))
        broken = t.input.is_corrupt == 1 and since_corrupt <= f.rule.time_out
        silent = CONDITION_MISSING if t.input.is_known == 0 else CONDITION_STALE
        judge(t, CONDITION_CORRUPT if broken else silent)


def note_broken(t: Wholes, now: int) -> None:
    """Note that a frame of this finger arrived broken at ``now`` [ns]."""
    t.input.corrupt, t.input.is_corrupt = now, 1


def judge(t: Wholes, found: int) -> None:
    """Take over what was found: a fault at once, its end after enough good states in a row."""
    if found > CONDITION_DEGRADED:
        if found != t.input.condition:
            t.faults[found] += 1
        t.input.condition, t.input.good = found, 0
        return
    t.input.good += 1
    if t.input.condition <= CONDITION_DEGRADED or t.input.good >= t.setup.recover_after:
        t.input.condition = found


def judge_order(t: Wholes) -> int:
    """Counter and stamp must advance."""
    advances = t.news.seq > t.input.seq and t.news.stamp > t.input.stamp
    if t.input.is_known == 0 or advances:
        return CONDITION_OK
    t.input.quickest = NO_QUICKEST  # should the sender have started anew, so has its clock
    return CONDITION_REPLAYED


def judge_lateness(f: Floats, t: Wholes, now: int) -> int:
    """No state takes the time-out longer than the quickest one, and none comes from far ahead."""
    took = elapsed_time(now, t.news.stamp)
    if leapt(t, took):
        return CONDITION_REPLAYED
    drift = 0 if t.input.is_received == 0 else elapsed_time(now, t.input.received) // DRIFT_PART
    t.input.quickest = min(max(t.input.quickest + drift, -NO_QUICKEST), took)
    late = float(elapsed_time(took, t.input.quickest)) > f.rule.time_out
    return CONDITION_STALE if late else CONDITION_OK


def leapt(t: Wholes, took: int) -> bool:
    """Return whether the stamp is far ahead; a sender that goes on so has another clock."""
    ahead = t.input.quickest < NO_QUICKEST and took < t.input.quickest - FAR_AHEAD
    t.input.leaps = t.input.leaps + 1 if ahead else 0
    if t.input.leaps > t.setup.recover_after:
        t.input.leaps = 0
        t.input.quickest = NO_QUICKEST
    return t.input.leaps > 0


def judge_values(f: Floats, t: Wholes, now: int) -> int:
    """Every value within its range, and alive."""
    for i in range(MEASURED):
        value = f.state[i]
        if not (f.lowest[i] <= value <= f.highest[i] or math.isnan(value)):
            return CONDITION_OUT_OF_RANGE
    everything, still = float(all_still(f, t, now)), force_still(f, t, now)
    force, travelled = float(still), has_travelled(f, t, now, still)
    t.input.doubtful = 1 if force > f.rule.doubt_after else 0
    vanished = noise_vanished(f, t, now)
    frozen = everything > f.rule.frozen_after or force > f.rule.force_frozen_after
    return CONDITION_FROZEN if vanished or travelled or frozen else CONDITION_OK


def judge_channels(f: Floats, t: Wholes) -> int:
    """Force or displacement must be there, and no channel that was may be missing.

    A channel was there if it came in as many states in a row as end a fault: a stray value is none.
    """
    present, bit = 0, 1
    for i in range(MEASURED):
        present += 0 if math.isnan(f.state[i]) else bit
        bit = bit * 2
    if present != t.input.present:
        t.input.present, t.input.alike = present, 0
        t.input.usable = 1 if (present & SUFFICIENT) != 0 else 0
        t.input.lost = t.input.seen - (t.input.seen & present)
    t.input.alike += 1
    if t.input.alike == t.setup.recover_after:
        t.input.seen = t.input.seen | present
    if t.input.usable == 0:
        return CONDITION_MISSING
    return CONDITION_DEGRADED if t.input.lost != 0 else CONDITION_OK
