"""What is told of a finger: its contact in two frames and its slip margin in one, as messages tell it.

A message tells the first report, and every one while the input is not believed
(:meth:`vegrip.grip.finger.GraspFinger.reports`).
"""

import math

from vegrip.estimator.elapsed import bounded_time, elapsed_time
from vegrip.estimator.kernels.forecast import force_reserve, slip_times
from vegrip.estimator.kernels.report import upper_gauge
from vegrip.estimator.kernels.sense import is_sound, touches
from vegrip.grip.kernels.friction_shared import told_friction
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.protection import protect

LARGEST_SINGLE = 3.4028234663852886e38
SLIP_CHANNEL = 6  # of a state that is kept
NOT_TOLD = 0  # messages have to tell it; nothing has changed
TOLD = 1


def finger_report(f: Floats, t: Wholes, now: int, contact1: Bytes, contact2: Bytes, margin: Bytes) -> int:
    """Pack contact and slip margin at ``now`` [ns], if they are due; return whether that was done."""
    if not is_told_here(t, now) or not is_carried(f):
        return NOT_TOLD
    bound = report_margin(f, t, margin)
    if math.isinf(bound):
        return NOT_TOLD
    report_contact(f, t, contact1, contact2)
    f[TAKEN_BOUND] = bound
    t[TURN_REPORTS] += 1
    t[TURN_REPORTED] = now
    t[TURN_CONTACT_DUE] = bounded_time(now) + t[SETUP_REPORT_PERIOD]
    t[TURN_REPORT_DUE] = min(t[TURN_CONTACT_DUE], t[TURN_HEALTH_DUE])
    return TOLD


def is_told_here(t: Wholes, now: int) -> bool:
    """Return whether a report is due that is not the first, of a contact that is believed."""
    is_begun = t[SAMPLE_BEGUN] == 1 and t[SAMPLE_IS_INFORMED] == 1 and t[TURN_SEEN] == 1
    is_due = t[TURN_CONTACT_DUE] > 0 and now >= t[TURN_CONTACT_DUE]
    return is_begun and is_due and t[TURN_HAS_MARGIN] == 1 and t[INPUT_CONDITION] <= CONDITION_DEGRADED


def is_carried(f: Floats) -> bool:
    """Return whether frames can carry every number of the contact."""
    values = is_single(f[REP_DEPTH_NOW]) and is_single(f[REP_FORCE]) and is_single(f[REP_RADIUS])
    values = values and is_single(f[REP_EXPONENT]) and is_single(f[REP_MU])
    values = values and is_single(f[REP_LIMIT_FORCE]) and is_single(f[REP_LIMIT_TORQUE])
    values = values and is_single(f[REP_LIMIT_RADIUS])
    stds = is_spread(f[REP_DEPTH_STD]) and is_spread(f[REP_FORCE_STD]) and is_spread(f[REP_RADIUS_STD])
    stds = stds and is_spread(f[REP_EXPONENT_STD]) and is_spread(f[REP_MU_STD])
    stds = stds and is_spread(f[REP_LIMIT_FORCE_STD]) and is_spread(f[REP_LIMIT_TORQUE_STD])
    return values and stds and is_spread(f[REP_LIMIT_RADIUS_STD])


def is_single(value: float) -> bool:
    """Return whether a single can carry ``value``; infinity means nothing."""
    return math.isnan(value) or abs(value) <= LARGEST_SINGLE


def is_spread(value: float) -> bool:
    """Return whether a single can carry a spread or a time, which may be infinite."""
    return is_single(value) or math.isinf(value)


def report_margin(f: Floats, t: Wholes, out: Bytes) -> float:
    """Pack the slip margin; return its lower bound, NaN: not known, inf: not to be carried."""
    gauge_now, relative, absolute = f[REP_GAUGE], f[REP_GAUGE_REL], f[REP_GAUGE_ABS]
    upper = upper_gauge(gauge_now, relative, absolute, f[SET_QUANTILE])
    seq, stamp, confidence = t[TURN_REPORTS], t[SAMPLE_STAMP], f[TOLD_CONFIDENCE]
    if not (is_sound(f, t) and touches(f, t) and math.isfinite(upper)):
        none, endless = math.nan, math.inf
        pack_margin(out, seq, stamp, 0, none, endless, endless, none, confidence, none, none, none)
        protect(out, MARGIN_LENGTH, t[SETUP_MARGIN_ID])
        return math.nan
    reserve = force_reserve(f, f[TAKEN_LOAD], f[TAKEN_TORQUE])
    chance = 0.5 * math.erfc(f[SET_QUANTILE] * 0.7071067811865476)
    likely, earliest = slip_times(f, f[TAKEN_LOAD], f[TAKEN_TORQUE], chance)
    spread = gauge_now * relative
    std = math.sqrt(spread * spread + absolute * absolute)
    value, bound = 1.0 - gauge_now, 1.0 - upper
    if not (is_single(value) and is_single(bound) and is_single(reserve) and is_spread(std)):
        return math.inf
    if not (is_spread(likely) and is_spread(earliest)):
        return math.inf
    age = float(elapsed_time(t[SAMPLE_STAMP], t[SAMPLE_INFORMED])) / 1e9
    pack_margin(out, seq, stamp, 1, value, std, age, bound, confidence, reserve, likely, earliest)
    protect(out, MARGIN_LENGTH, t[SETUP_MARGIN_ID])
    return bound


def report_contact(f: Floats, t: Wholes, first: Bytes, second: Bytes) -> None:
    """Pack the contact, both of its frames."""
    seq, stamp = t[TURN_REPORTS], t[SAMPLE_SHOWN]
    age = float(elapsed_time(stamp, t[SAMPLE_INFORMED])) / 1e9
    current = t[SAMPLE_TRUSTED] == 1 and is_sound(f, t)
    touching = touches(f, t)
    mu, mu_std = told_friction(f, t, f[REP_MU], f[REP_MU_STD])
    pack_contact1(
        first, seq, stamp, flag_of(touching), flag_of(current),
        flag_of(current and is_known(f[REP_FORCE], f[REP_FORCE_STD])),
        flag_of(current and f[REP_RADIUS_SOUND] > 0.5 and is_known(f[REP_RADIUS], f[REP_RADIUS_STD])),
        flag_of(current and touching and is_known(f[REP_EXPONENT], f[REP_EXPONENT_STD])),
        f[REP_DEPTH_NOW], f[REP_DEPTH_STD], age, f[REP_FORCE], f[REP_FORCE_STD],
        f[REP_RADIUS], f[REP_RADIUS_STD], f[REP_EXPONENT], f[REP_EXPONENT_STD],
        channels_used(f, t) if t[SAMPLE_TRUSTED] == 1 else 0,
    )  # fmt: skip
    protect(first, CONTACT_LENGTH, t[SETUP_CONTACT1_ID])
    pack_contact2(
        second, seq, stamp,
        flag_of(current and is_known(mu, mu_std)),
        flag_of(current and is_known(f[REP_LIMIT_FORCE], f[REP_LIMIT_FORCE_STD])),
        flag_of(current and is_known(f[REP_LIMIT_TORQUE], f[REP_LIMIT_TORQUE_STD])),
        flag_of(current and touching and is_known(f[REP_LIMIT_RADIUS], f[REP_LIMIT_RADIUS_STD])),
        mu, mu_std, age, f[REP_LIMIT_FORCE], f[REP_LIMIT_FORCE_STD],
        f[REP_LIMIT_TORQUE], f[REP_LIMIT_TORQUE_STD], f[REP_LIMIT_RADIUS], f[REP_LIMIT_RADIUS_STD],
    )  # fmt: skip
    protect(second, CONTACT_LENGTH, t[SETUP_CONTACT2_ID])


def channels_used(f: Floats, t: Wholes) -> int:
    """Return which measurements the last sample gave, as bits of :class:`vegrip.messages.Channel`."""
    bits = 0
    if f[CHANNEL0 + CHANNEL_FORCE * CHANNEL_SIZE + CH_USED] > 0.0:
        bits += 1
    if f[CHANNEL0 + CHANNEL_DISPLACEMENT * CHANNEL_SIZE + CH_USED] > 0.0:
        bits += 2
    if f[CHANNEL0 + CHANNEL_RADIUS * CHANNEL_SIZE + CH_USED] > 0.0:
        bits += 4
    if math.isfinite(f[TAKEN_LOAD]):
        bits += 8
    if math.isfinite(f[TAKEN_TORQUE]):
        bits += 16
    row = (t[TURN_NOTED] - 1) % max(HISTORY_STATES, 1)
    if math.isfinite(f[HISTORY0 + row * (MEASURED + 1) + SLIP_CHANNEL]):
        bits += 32
    return bits


def is_known(value: float, std: float) -> bool:
    """Return whether an estimate is a number, and its spread too."""
    return math.isfinite(value + std)


def flag_of(holds: bool) -> int:
    """Return a bit."""
    return 1 if holds else 0
