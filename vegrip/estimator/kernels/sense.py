"""The clock of the samples: in which order they come, and how old the last one that informed is.

Stamps are those of the sender. One that does not advance belongs to a late sample, which still finds its
place among those that were kept, or is refused; after some of them in a row the sender's clock has started
anew, or one stamp was wrong by far.
"""

import math

from vegrip.estimator.elapsed import bounded_time, elapsed_time
from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.report import margin_gauge
from vegrip.estimator.kernels.update import update


def assimilate(f: Floats, t: Wholes) -> None:
    """Take in the present state; one that comes late in its place, if that is not too long ago.

    After enough stamps in a row that do not advance, the sender's clock counts as started anew.
    """
    t.sample.shown, t.sample.trusted = t.news.stamp, 0
    t.sample.offered += 1
    if t.sample.resumed == 1:
        t.sample.resumed = 0
        follow_clock(f, t)
    elif t.sample.begun == 0 or t.news.stamp > t.sample.stamp:
        t.sample.backwards = 0
        take_state(f, t)
    else:
        t.sample.backwards += 1
        is_anew = t.sample.backwards >= t.clock.recovery
        if is_anew or not take_late(f, t):
            t.sample.refused += 1
        if is_anew:
            follow_clock(f, t)


def follow_clock(f: Floats, t: Wholes) -> None:
    """Take the present state by a clock that has started anew: after a gap of unknown length."""
    t.sample.backwards = t.sample.kept = 0
    t.sample.followed += 1
    t.sample.begun, t.sample.stamp = 1, bounded_time(t.news.stamp) - t.clock.gap
    t.sample.informed, t.sample.is_informed = t.sample.stamp, 1
    take_state(f, t)


def take_state(f: Floats, t: Wholes) -> None:
    """Take the state that follows the last one; the first must measure force or displacement."""
    is_usable = math.isfinite(f.state.normal_force) or math.isfinite(f.state.displacement)
    if t.sample.begun == 0 and not is_usable:
        return
    passed = float(elapsed_time(t.news.stamp, t.sample.stamp)) / 1e9
    dt = passed if t.sample.begun == 1 else -1.0
    keep_for_rewind(f, t)
    x, y, torque = f.state.tangential_force_x, f.state.tangential_force_y, f.state.torque_z
    load = math.sqrt(x * x + y * y)  # not math.hypot: Python's rounds otherwise than C's
    t.sample.begun, t.sample.trusted, t.sample.stamp = 1, 1, t.news.stamp
    f.taken.load = load if math.isfinite(load) else math.nan
    f.taken.torque = torque if math.isfinite(torque) else math.nan
    f.taken.slip = f.state.slip
    f.report.slides = 1.0 if f.state.slip >= SLIDES else 0.0
    feel_outside(f)
    force, displacement = f.state.normal_force, f.state.displacement
    radius, slip = f.state.contact_radius, sensed_slip(f)
    update(f, dt, force, displacement, radius, f.taken.load, f.taken.torque, slip)
    if is_usable and (is_used(f, CHANNEL_DISPLACEMENT) or is_used(f, CHANNEL_FORCE)):
        t.sample.informed, t.sample.is_informed = t.news.stamp, 1
    t.sample.seq += 1


def is_used(f: Floats, channel: int) -> bool:
    """Return whether the estimator used what a channel measured."""
    return f.channel[channel * CHANNEL_SIZE + CH_USED] > 0.0


def keep_for_rewind(f: Floats, t: Wholes) -> None:
    """Keep this state and what lasts of the memory before it, so that a late one can still take its place."""
    if LATE_SAMPLES > 0:
        slot = t.sample.rewind_next
        for i in range(LASTING_SIZE):
            f.rewind[slot * LASTING_SIZE + i] = f[i]
        copy_measured(f, REWIND_STATE0 + slot * MEASURED, STATE0)
        t.rewind_stamp[slot] = t.news.stamp
        t.rewind_before[slot], t.rewind_begun[slot] = t.sample.stamp, t.sample.begun
        t.sample.rewind_next = (slot + 1) % max(LATE_SAMPLES, 1)
        t.sample.kept = min(t.sample.kept + 1, LATE_SAMPLES)


def take_late(f: Floats, t: Wholes) -> bool:
    """Go back, take the present state, and again those that came after it; False: that is not possible."""
    later = samples_after(t, t.news.stamp)
    if later == 0:
        return False
    first = slot_back(t, later)
    if t.rewind_begun[first] == 0 or t.rewind_before[first] >= t.news.stamp:
        return False
    for i in range(LASTING_SIZE):
        f[i] = f.rewind[first * LASTING_SIZE + i]
    t.sample.stamp = t.rewind_before[first]
    t.sample.seq -= later
    t.sample.kept -= later
    t.sample.rewind_next = first
    stamp, carried = t.news.stamp, t.news.stamp
    copy_measured(f, LATER0, STATE0)
    for i in range(later + 1):
        slot = t.sample.rewind_next  # it is written by the state before the one that it holds
        if i < later:
            carried = t.rewind_stamp[slot]
            copy_measured(f, LATER0 + MEASURED, REWIND_STATE0 + slot * MEASURED)
        take_state(f, t)
        t.news.stamp = carried
        copy_measured(f, STATE0, LATER0 + MEASURED)
    t.news.stamp = stamp
    copy_measured(f, STATE0, LATER0)
    t.sample.late += 1
    return True


def samples_after(t: Wholes, stamp: int) -> int:
    """Return how many of the kept samples are later than ``stamp`` [ns]; 0 too if one has that very stamp."""
    later = 0
    if t.sample.kept > 0 and t.rewind_stamp[slot_back(t, 1)] != stamp:
        while later < t.sample.kept and t.rewind_stamp[slot_back(t, later + 1)] > stamp:
            later += 1
    return later


def slot_back(t: Wholes, samples: int) -> int:
    """Return the slot of the sample before so many ``samples``, at most all that are kept."""
    return (t.sample.rewind_next - samples + LATE_SAMPLES) % max(LATE_SAMPLES, 1)


def copy_measured(f: Floats, to: int, start: int) -> None:
    """Copy the measured values of a state."""
    for i in range(MEASURED):
        f[to + i] = f[start + i]


def feel_outside(f: Floats) -> None:
    """Pass on what effects may feel besides; a value that is not measured stays as it was."""
    speed = 0.0 if f.state.slip == 0.0 else f.state.slip_speed  # noise is not sliding
    feel_one(f, 0, f.state.temperature)
    feel_one(f, 1, f.taken.load)
    feel_one(f, 2, f.taken.torque)
    feel_one(f, 3, speed)
    feel_one(f, 4, f.state.tangential_force_x)
    feel_one(f, 5, f.state.tangential_force_y)


def feel_one(f: Floats, place: int, value: float) -> None:
    """Set one of the quantities outside the model."""
    if math.isfinite(value):
        f.exogenous[place] = value


def sensed_slip(f: Floats) -> float:
    """Return whether it slips; NaN where that is not sensed or learned, or contradicts the slip speed."""
    slip, speed = f.state.slip, f.state.slip_speed
    if not MU_LEARNED or not math.isfinite(slip) or (slip >= SLIDES and abs(speed) < LEAST_SLIDING_SPEED):
        return math.nan
    return slip


def touches(f: Floats, t: Wholes) -> bool:
    """Return whether the fingertip touches."""
    return t.sample.begun == 1 and f.report.contact > 0.0


def informed_age(t: Wholes) -> float:
    """Return how old [s] the last sample that informed is at the last one; infinite when there was none."""
    if t.sample.is_informed == 0:
        return math.inf
    return float(elapsed_time(t.sample.stamp, t.sample.informed)) / 1e9


def is_sound(f: Floats, t: Wholes) -> bool:
    """Return whether estimates count: measurements come, and are not all refused."""
    return t.sample.begun == 1 and informed_age(t) <= f.set.longest_gap and f.report.sound > 0.0


def is_force_known(f: Floats, t: Wholes) -> bool:
    """Return whether the estimate of the normal force is valid."""
    finite = math.isfinite(f.report.force + f.report.force_std)
    return t.sample.trusted == 1 and is_sound(f, t) and finite


def margin_bound(f: Floats, t: Wholes) -> float:
    """Return the lower bound of the present margin; NaN: not known."""
    upper = margin_gauge(f)
    return 1.0 - upper if is_sound(f, t) and touches(f, t) and math.isfinite(upper) else math.nan
