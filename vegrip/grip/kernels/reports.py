"""What is published of a finger: its contact in two frames and its slip margin in one, as in messages.

A message carries the first report, and every one while the input is not believed
(:class:`vegrip.grip.finger_reports.FingerReports`).
"""

import math

from vegrip.estimator.elapsed import bounded_time, elapsed_time
from vegrip.estimator.kernels.forecast import force_reserve, slip_times
from vegrip.estimator.kernels.report import margin_gauge
from vegrip.estimator.kernels.sense import is_sound, touches
from vegrip.grip.kernels.frame_bytes import protect
from vegrip.grip.kernels.friction_shared import stated_friction
from vegrip.grip.kernels.generated import *

LARGEST_SINGLE = 3.4028234663852886e38
SLIP_CHANNEL = 6  # of a state that is kept
NOT_REPORTED = 0  # messages have to carry it; nothing has changed
REPORTED = 1


def finger_report(f: Floats, t: Wholes, now: int, contact1: Bytes, contact2: Bytes, margin: Bytes) -> int:
    """Pack contact and slip margin at ``now`` [ns], if they are due; return whether that was done."""
    if not is_reported_here(t, now) or not is_carried(f):
        return NOT_REPORTED
    bound = report_margin(f, t, margin)
    if math.isinf(bound):
        return NOT_REPORTED
    report_contact(f, t, contact1, contact2)
    f.taken.bound = bound
    t.turn.reports += 1
    t.turn.reported = now
    t.turn.contact_due = bounded_time(now) + t.setup.report_period
    t.turn.report_due = min(t.turn.contact_due, t.turn.health_due)
    return REPORTED


def is_reported_here(t: Wholes, now: int) -> bool:
    """Return whether a report is due that is not the first, of a contact that is believed."""
    is_begun = t.sample.begun == 1 and t.sample.is_informed == 1 and t.turn.seen == 1
    is_due = t.turn.contact_due > 0 and now >= t.turn.contact_due
    return is_begun and is_due and t.turn.has_margin == 1 and t.input.condition <= CONDITION_DEGRADED


def is_carried(f: Floats) -> bool:
    """Return whether frames can carry every number of the contact."""
    values = is_single(f.report.depth_now) and is_single(f.report.force) and is_single(f.report.radius)
    values = values and is_single(f.report.exponent) and is_single(f.report.mu)
    values = values and is_single(f.report.limit_force) and is_single(f.report.limit_torque)
    values = values and is_single(f.report.limit_radius)
    stds = is_spread(f.report.depth_std) and is_spread(f.report.force_std) and is_spread(f.report.radius_std)
    stds = stds and is_spread(f.report.exponent_std) and is_spread(f.report.mu_std)
    stds = stds and is_spread(f.report.limit_force_std) and is_spread(f.report.limit_torque_std)
    return values and stds and is_spread(f.report.limit_radius_std)


def is_single(value: float) -> bool:
    """Return whether a single can carry ``value``; infinity means nothing."""
    return math.isnan(value) or abs(value) <= LARGEST_SINGLE


def is_spread(value: float) -> bool:
    """Return whether a single can carry a spread or a time, which may be infinite."""
    return is_single(value) or math.isinf(value)


def report_margin(f: Floats, t: Wholes, out: Bytes) -> float:
    """Pack the slip margin; return its lower bound, NaN: not known, inf: not to be carried."""
    gauge_now, relative, absolute = f.report.gauge, f.report.gauge_rel, f.report.gauge_abs
    upper = margin_gauge(f)
    seq, stamp, confidence = t.turn.reports, t.sample.stamp, f.published.confidence
    if not (is_sound(f, t) and touches(f, t) and math.isfinite(upper)):
        none, endless = math.nan, math.inf
        pack_margin(out, seq, stamp, 0, none, endless, endless, none, confidence, none, none, none)
        protect(out, MARGIN_LENGTH, t.setup.margin_id)
        return math.nan
    reserve = force_reserve(f, f.taken.load, f.taken.torque)
    chance = 0.5 * math.erfc(f.set.quantile * 0.7071067811865476)
    likely, earliest = slip_times(f, f.taken.load, f.taken.torque, chance)
    spread = gauge_now * relative
    std = math.sqrt(spread * spread + absolute * absolute)
    value, bound = 1.0 - gauge_now, 1.0 - upper
    if not (is_single(value) and is_single(bound) and is_single(reserve) and is_spread(std)):
        return math.inf
    if not (is_spread(likely) and is_spread(earliest)):
        return math.inf
    age = float(elapsed_time(t.sample.stamp, t.sample.informed)) / 1e9
    pack_margin(out, seq, stamp, 1, value, std, age, bound, confidence, reserve, likely, earliest)
    protect(out, MARGIN_LENGTH, t.setup.margin_id)
    return bound


def report_contact(f: Floats, t: Wholes, first: Bytes, second: Bytes) -> None:
    """Pack the contact, both of its frames."""
    seq, stamp = t.turn.reports, t.sample.shown
    age = float(elapsed_time(stamp, t.sample.informed)) / 1e9
    current = t.sample.trusted == 1 and is_sound(f, t)
    touching = touches(f, t)
    mu, mu_std = stated_friction(f, t, f.report.mu, f.report.mu_std)
    pack_contact1(
        first, seq, stamp, flag_of(touching), flag_of(current),
        flag_of(current and is_known(f.report.force, f.report.force_std)),
        flag_of(current and f.report.radius_sound > 0.0 and is_known(f.report.radius, f.report.radius_std)),
        flag_of(current and touching and is_known(f.report.exponent, f.report.exponent_std)),
        f.report.depth_now, f.report.depth_std, age, f.report.force, f.report.force_std,
        f.report.radius, f.report.radius_std, f.report.exponent, f.report.exponent_std,
        channels_used(f, t) if t.sample.trusted == 1 else 0,
    )  # fmt: skip
    protect(first, CONTACT_LENGTH, t.setup.contact1_id)
    pack_contact2(
        second, seq, stamp,
        flag_of(current and is_known(mu, mu_std)),
        flag_of(current and is_known(f.report.limit_force, f.report.limit_force_std)),
        flag_of(current and is_known(f.report.limit_torque, f.report.limit_torque_std)),
        flag_of(current and touching and is_known(f.report.limit_radius, f.report.limit_radius_std)),
        mu, mu_std, age, f.report.limit_force, f.report.limit_force_std,
        f.report.limit_torque, f.report.limit_torque_std, f.report.limit_radius, f.report.limit_radius_std,
    )  # fmt: skip
    protect(second, CONTACT_LENGTH, t.setup.contact2_id)


def channels_used(f: Floats, t: Wholes) -> int:
    """Return which measurements the last sample gave, as bits of :class:`vegrip.messages.Channel`."""
    bits = 0
    if f.channel[CHANNEL_FORCE * CHANNEL_SIZE + CH_USED] > 0.0:
        bits += 1
    if f.channel[CHANNEL_DISPLACEMENT * CHANNEL_SIZE + CH_USED] > 0.0:
        bits += 2
    if f.channel[CHANNEL_RADIUS * CHANNEL_SIZE + CH_USED] > 0.0:
        bits += 4
    if math.isfinite(f.taken.load):
        bits += 8
    if math.isfinite(f.taken.torque):
        bits += 16
    row = (t.turn.noted - 1) % max(HISTORY_STATES, 1)
    if math.isfinite(f.history[row * (MEASURED + 1) + SLIP_CHANNEL]):
        bits += 32
    return bits


def is_known(value: float, std: float) -> bool:
    """Return whether an estimate is a number, and its spread too."""
    return math.isfinite(value + std)


def flag_of(holds: bool) -> int:
    """Return a bit."""
    return 1 if holds else 0
