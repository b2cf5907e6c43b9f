"""The clock of the samples: in which order they come, and how old the last one that informed is.

Stamps are those of the sender. One that does not advance belongs to a late sample, which still finds its
place among those that were kept, or is refused; after some refusals in a row the sender's clock has started
anew.
"""

import math

from vegrip.estimator.elapsed import bounded_time, elapsed_time
from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.report import upper_gauge
from vegrip.estimator.kernels.update import update


def assimilate(f: Floats, t: Wholes) -> None:
    """Take in the present state; one that comes late in its place, if that is not too long ago.

    After enough stamps in a row that do not advance, the sender's clock counts as started anew.
    """
    t[SAMPLE_SHOWN], t[SAMPLE_TRUSTED] = t[NEWS_STAMP], 0
    t[SAMPLE_OFFERED] += 1
    if t[SAMPLE_RESUMED] == 1:
        t[SAMPLE_RESUMED] = 0
        follow_clock(f, t)
    elif t[SAMPLE_BEGUN] == 0 or t[NEWS_STAMP] > t[SAMPLE_STAMP]:
        t[SAMPLE_BACKWARDS] = 0
        take_state(f, t)
    elif not take_late(f, t):
        t[SAMPLE_REFUSED] += 1
        t[SAMPLE_BACKWARDS] += 1
        if t[SAMPLE_BACKWARDS] >= t[CLOCK_RECOVERY]:
            follow_clock(f, t)


def follow_clock(f: Floats, t: Wholes) -> None:
    """Take the present state by a clock that has started anew: after a gap of unknown length."""
    t[SAMPLE_BACKWARDS] = t[SAMPLE_KEPT] = 0
    t[SAMPLE_FOLLOWED] += 1
    t[SAMPLE_BEGUN], t[SAMPLE_STAMP] = 1, bounded_time(t[NEWS_STAMP]) - t[CLOCK_GAP]
    t[SAMPLE_INFORMED], t[SAMPLE_IS_INFORMED] = t[SAMPLE_STAMP], 1
    take_state(f, t)


def take_state(f: Floats, t: Wholes) -> None:
    """Take the state that follows the last one; the first must measure force or displacement."""
    is_usable = math.isfinite(f[STATE_NORMAL_FORCE]) or math.isfinite(f[STATE_DISPLACEMENT])
    if t[SAMPLE_BEGUN] == 0 and not is_usable:
        return
    passed = float(elapsed_time(t[NEWS_STAMP], t[SAMPLE_STAMP])) / 1e9
    dt = passed if t[SAMPLE_BEGUN] == 1 else -1.0
    keep_for_rewind(f, t)
    x, y, torque = f[STATE_TANGENTIAL_FORCE_X], f[STATE_TANGENTIAL_FORCE_Y], f[STATE_TORQUE_Z]
    load = math.sqrt(x * x + y * y)  # not math.hypot: Python's rounds otherwise than C's
    t[SAMPLE_BEGUN], t[SAMPLE_TRUSTED], t[SAMPLE_STAMP] = 1, 1, t[NEWS_STAMP]
    f[TAKEN_LOAD] = load if math.isfinite(load) else math.nan
    f[TAKEN_TORQUE] = torque if math.isfinite(torque) else math.nan
    f[TAKEN_SLIP] = f[STATE_SLIP]
    feel_outside(f)
    force, displacement = f[STATE_NORMAL_FORCE], f[STATE_DISPLACEMENT]
    radius, slip = f[STATE_CONTACT_RADIUS], sensed_slip(f)
    update(f, dt, force, displacement, radius, f[TAKEN_LOAD], f[TAKEN_TORQUE], slip)
    if is_usable and (is_used(f, CHANNEL_DISPLACEMENT) or is_used(f, CHANNEL_FORCE)):
        t[SAMPLE_INFORMED], t[SAMPLE_IS_INFORMED] = t[NEWS_STAMP], 1
    t[SAMPLE_SEQ] += 1


def is_used(f: Floats, channel: int) -> bool:
    """Return whether the estimator used what a channel measured."""
    return f[CHANNEL0 + channel * CHANNEL_SIZE + CH_USED] > 0.0


def keep_for_rewind(f: Floats, t: Wholes) -> None:
    """Keep this state and what lasts of the memory before it, so that a late one can still take its place."""
    if LATE_SAMPLES > 0:
        slot = t[SAMPLE_REWIND_NEXT]
        for i in range(LASTING_SIZE):
            f[REWIND0 + slot * LASTING_SIZE + i] = f[i]
        copy_measured(f, REWIND_STATE0 + slot * MEASURED, STATE0)
        t[REWIND_STAMP0 + slot] = t[NEWS_STAMP]
        t[REWIND_BEFORE0 + slot], t[REWIND_BEGUN0 + slot] = t[SAMPLE_STAMP], t[SAMPLE_BEGUN]
        t[SAMPLE_REWIND_NEXT] = (slot + 1) % max(LATE_SAMPLES, 1)
        t[SAMPLE_KEPT] = min(t[SAMPLE_KEPT] + 1, LATE_SAMPLES)


def take_late(f: Floats, t: Wholes) -> bool:
    """Go back, take the present state, and again those that came after it; False: that is not possible."""
    later = samples_after(t, t[NEWS_STAMP])
    if later == 0:
        return False
    first = slot_back(t, later)
    if t[REWIND_BEGUN0 + first] == 0 or t[REWIND_BEFORE0 + first] >= t[NEWS_STAMP]:
        return False
    for i in range(LASTING_SIZE):
        f[i] = f[REWIND0 + first * LASTING_SIZE + i]
    t[SAMPLE_STAMP] = t[REWIND_BEFORE0 + first]
    t[SAMPLE_SEQ] -= later
    t[SAMPLE_KEPT] -= later
    t[SAMPLE_REWIND_NEXT] = first
    stamp, carried = t[NEWS_STAMP], t[NEWS_STAMP]
    copy_measured(f, LATER0, STATE0)
    for i in range(later + 1):
        slot = t[SAMPLE_REWIND_NEXT]  # it is written by the state before the one that it holds
        if i < later:
            carried = t[REWIND_STAMP0 + slot]
            copy_measured(f, LATER0 + MEASURED, REWIND_STATE0 + slot * MEASURED)
        take_state(f, t)
        t[NEWS_STAMP] = carried
        copy_measured(f, STATE0, LATER0 + MEASURED)
    t[NEWS_STAMP] = stamp
    copy_measured(f, STATE0, LATER0)
    t[SAMPLE_LATE] += 1
    return True


def samples_after(t: Wholes, stamp: int) -> int:
    """Return how many of the kept samples are later than ``stamp`` [ns]; 0 too if one has that very stamp."""
    later = 0
    if t[SAMPLE_KEPT] > 0 and t[REWIND_STAMP0 + slot_back(t, 1)] != stamp:
        while later < t[SAMPLE_KEPT] and t[REWIND_STAMP0 + slot_back(t, later + 1)] > stamp:
            later += 1
    return later


def slot_back(t: Wholes, samples: int) -> int:
    """Return the slot of the sample before so many ``samples``, at most all that are kept."""
    return (t[SAMPLE_REWIND_NEXT] - samples + LATE_SAMPLES) % max(LATE_SAMPLES, 1)


def copy_measured(f: Floats, to: int, start: int) -> None:
    """Copy the measured values of a state."""
    for i in range(MEASURED):
        f[to + i] = f[start + i]


def feel_outside(f: Floats) -> None:
    """Pass on what effects may feel besides; a value that is not measured stays as it was."""
    speed = 0.0 if f[STATE_SLIP] == 0.0 else f[STATE_SLIP_SPEED]  # noise is not sliding
    feel_one(f, 0, f[STATE_TEMPERATURE])
    feel_one(f, 1, f[TAKEN_LOAD])
    feel_one(f, 2, f[TAKEN_TORQUE])
    feel_one(f, 3, speed)
    feel_one(f, 4, f[STATE_TANGENTIAL_FORCE_X])
    feel_one(f, 5, f[STATE_TANGENTIAL_FORCE_Y])


def feel_one(f: Floats, place: int, value: float) -> None:
    """Set one of the quantities outside the model."""
    if math.isfinite(value):
        f[EXOGENOUS0 + place] = value


def sensed_slip(f: Floats) -> float:
    """Return whether it slips; NaN where that is not sensed or learned, or contradicts the slip speed."""
    slip, speed = f[STATE_SLIP], f[STATE_SLIP_SPEED]
    if not MU_LEARNED or not math.isfinite(slip) or (slip >= SLIDES and speed < LEAST_SLIDING_SPEED):
        return math.nan
    return slip


def touches(f: Floats, t: Wholes) -> bool:
    """Return whether the fingertip touches."""
    return t[SAMPLE_BEGUN] == 1 and f[REP_CONTACT] > 0.5


def informed_age(t: Wholes) -> float:
    """Return how old [s] the last sample that informed is at the last one; infinite when there was none."""
    if t[SAMPLE_IS_INFORMED] == 0:
        return math.inf
    return float(elapsed_time(t[SAMPLE_STAMP], t[SAMPLE_INFORMED])) / 1e9


def is_sound(f: Floats, t: Wholes) -> bool:
    """Return whether estimates count: measurements come, and are not all refused."""
    return t[SAMPLE_BEGUN] == 1 and informed_age(t) <= f[SET_LONGEST_GAP] and f[REP_SOUND] > 0.5


def is_force_known(f: Floats, t: Wholes) -> bool:
    """Return whether the estimate of the normal force is valid."""
    finite = math.isfinite(f[REP_FORCE] + f[REP_FORCE_STD])
    return t[SAMPLE_TRUSTED] == 1 and is_sound(f, t) and finite


def margin_bound(f: Floats, t: Wholes) -> float:
    """Return the lower bound of the present margin; NaN: not known."""
    upper = upper_gauge(f[REP_GAUGE], f[REP_GAUGE_REL], f[REP_GAUGE_ABS], f[SET_QUANTILE])
    return 1.0 - upper if is_sound(f, t) and touches(f, t) and math.isfinite(upper) else math.nan
