"""The believed state goes into the estimator (:meth:`vegrip.estimator.ContactEstimator.assimilate`)."""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.estimator.kernels.report import upper_gauge
from vegrip.estimator.kernels.update import update
from vegrip.grip.kernels.generated import (
    CH_USED,
    CHANNEL0,
    CHANNEL_DISPLACEMENT,
    CHANNEL_FORCE,
    CHANNEL_SIZE,
    EXOGENOUS0,
    HISTORY0,
    HISTORY_SEQ0,
    HISTORY_STAMP0,
    HISTORY_STATES,
    LASTING_SIZE,
    LATE_SAMPLES,
    LEAST_SLIDING_SPEED,
    MEASURED,
    MU_LEARNED,
    NEWS_SEQ,
    NEWS_STAMP,
    REP_CONTACT,
    REP_FORCE,
    REP_FORCE_STD,
    REP_GAUGE,
    REP_GAUGE_ABS,
    REP_GAUGE_REL,
    REP_SOUND,
    REWIND0,
    SAMPLE_BACKWARDS,
    SAMPLE_BEGUN,
    SAMPLE_INFORMED,
    SAMPLE_IS_INFORMED,
    SAMPLE_REFUSED,
    SAMPLE_RESUMED,
    SAMPLE_REWIND_NEXT,
    SAMPLE_SEQ,
    SAMPLE_SHOWN,
    SAMPLE_STAMP,
    SAMPLE_TRUSTED,
    SET_LONGEST_GAP,
    SET_QUANTILE,
    SETUP_GAP,
    SETUP_RECOVERY,
    SLIDES,
    STATE0,
    STATE_CONTACT_RADIUS,
    STATE_DISPLACEMENT,
    STATE_NORMAL_FORCE,
    STATE_SLIP,
    STATE_SLIP_SPEED,
    STATE_TANGENTIAL_FORCE_X,
    STATE_TANGENTIAL_FORCE_Y,
    STATE_TEMPERATURE,
    STATE_TORQUE_Z,
    TAKEN_LOAD,
    TAKEN_TORQUE,
    TURN_NOTED,
    Floats,
    Wholes,
)


def assimilate(f: Floats, t: Wholes) -> None:
    """Take in the present state; one whose stamp does not advance only where the finger works alone."""
    t[SAMPLE_SHOWN], t[SAMPLE_TRUSTED] = t[NEWS_STAMP], 0
    if t[SAMPLE_RESUMED] == 1:
        t[SAMPLE_RESUMED] = 0
        follow_clock(f, t)
    elif t[SAMPLE_BEGUN] == 1 and t[NEWS_STAMP] <= t[SAMPLE_STAMP]:
        t[SAMPLE_REFUSED] += 1
        t[SAMPLE_BACKWARDS] += 1
        if t[SAMPLE_BACKWARDS] >= t[SETUP_RECOVERY]:
            follow_clock(f, t)
    else:
        t[SAMPLE_BACKWARDS] = 0
        take_state(f, t)
    note_history(f, t)


def follow_clock(f: Floats, t: Wholes) -> None:
    """Take the present state by a clock that has started anew: after a gap of unknown length."""
    t[SAMPLE_BACKWARDS] = 0
    t[SAMPLE_STAMP] = t[NEWS_STAMP] - t[SETUP_GAP]
    t[SAMPLE_INFORMED], t[SAMPLE_IS_INFORMED] = t[SAMPLE_STAMP], 1
    take_state(f, t)


def take_state(f: Floats, t: Wholes) -> None:
    """Take the state that follows the last one."""
    passed = float(elapsed_time(t[NEWS_STAMP], t[SAMPLE_STAMP])) / 1e9
    dt = passed if t[SAMPLE_BEGUN] == 1 else -1.0
    keep_for_rewind(f, t)
    x, y, torque = f[STATE_TANGENTIAL_FORCE_X], f[STATE_TANGENTIAL_FORCE_Y], f[STATE_TORQUE_Z]
    load = math.sqrt(x * x + y * y)
    t[SAMPLE_BEGUN], t[SAMPLE_TRUSTED], t[SAMPLE_STAMP] = 1, 1, t[NEWS_STAMP]
    f[TAKEN_LOAD] = load if math.isfinite(load) else math.nan
    f[TAKEN_TORQUE] = torque if math.isfinite(torque) else math.nan
    feel_outside(f)
    force, displacement = f[STATE_NORMAL_FORCE], f[STATE_DISPLACEMENT]
    radius, slip = f[STATE_CONTACT_RADIUS], sensed_slip(f)
    update(f, dt, force, displacement, radius, f[TAKEN_LOAD], f[TAKEN_TORQUE], slip)
    used = is_used(f, CHANNEL_DISPLACEMENT) or is_used(f, CHANNEL_FORCE)
    if used and (math.isfinite(force) or math.isfinite(displacement)):
        t[SAMPLE_INFORMED], t[SAMPLE_IS_INFORMED] = t[NEWS_STAMP], 1
    t[SAMPLE_SEQ] += 1


def is_used(f: Floats, channel: int) -> bool:
    """Return whether the estimator used what a channel measured."""
    return f[CHANNEL0 + channel * CHANNEL_SIZE + CH_USED] > 0.0


def keep_for_rewind(f: Floats, t: Wholes) -> None:
    """Keep what lasts of the memory before this state, so that a late one can still take its place."""
    if LATE_SAMPLES > 0:
        start = REWIND0 + t[SAMPLE_REWIND_NEXT] * LASTING_SIZE
        for i in range(LASTING_SIZE):
            f[start + i] = f[i]
        t[SAMPLE_REWIND_NEXT] = (t[SAMPLE_REWIND_NEXT] + 1) % max(LATE_SAMPLES, 1)


def note_history(f: Floats, t: Wholes) -> None:
    """Keep the state itself for those who look back."""
    if HISTORY_STATES > 0:
        row = t[TURN_NOTED] % max(HISTORY_STATES, 1)
        t[HISTORY_STAMP0 + row], t[HISTORY_SEQ0 + row] = t[NEWS_STAMP], t[NEWS_SEQ]
        start = HISTORY0 + row * (MEASURED + 1)
        for i in range(MEASURED):
            f[start + i] = f[STATE0 + i]
        f[start + MEASURED] = 1.0 if touches(f, t) else 0.0
        t[TURN_NOTED] += 1


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


def is_sound(f: Floats, t: Wholes) -> bool:
    """Return whether estimates count: measurements come, and are not all refused."""
    if t[SAMPLE_BEGUN] == 0 or t[SAMPLE_IS_INFORMED] == 0:
        return False
    age = float(elapsed_time(t[SAMPLE_STAMP], t[SAMPLE_INFORMED])) / 1e9
    return age <= f[SET_LONGEST_GAP] and f[REP_SOUND] > 0.5


def is_force_known(f: Floats, t: Wholes) -> bool:
    """Return whether the estimate of the normal force is valid."""
    finite = math.isfinite(f[REP_FORCE] + f[REP_FORCE_STD])
    return t[SAMPLE_TRUSTED] == 1 and is_sound(f, t) and finite


def margin_bound(f: Floats, t: Wholes) -> float:
    """Return the lower bound of the present margin; NaN: not known."""
    upper = upper_gauge(f[REP_GAUGE], f[REP_GAUGE_REL], f[REP_GAUGE_ABS], f[SET_QUANTILE])
    return 1.0 - upper if is_sound(f, t) and touches(f, t) and math.isfinite(upper) else math.nan
