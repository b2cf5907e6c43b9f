"""Bumpless transfer: a finger goes on with the force that is there, in a grasp and at its beginning.

**A contact met in its middle.**

An estimator that has not seen a contact begin, or has not seen it for a while, knows little of it, and its
first samples may ask for several times the force that is needed. What is known without it: the load of that
instant is held, by the normal force of that instant. So for ``TRANSFER_TIME`` the least force is bounded by
what this shows::

    bound = max(N0 g^2, min(N0 + ramp_rate t, fail-safe force)),    g = max(1, load / load at the beginning)

The load is ``hypot(f_t, m / a)``. Coulomb's friction needs ``N0 g``; the friction coefficient of soft tips
falls as the normal force grows, hardly faster than with its square root, and then ``N0 g^2`` is needed.
Slip ends it at once: then what was held is held no more.

**An object that still stands.** Without a load nothing says what the object weighs, and next to no force
would be asked for; when it is lifted, its load comes faster than many drives follow. So until a load is
felt, force is not lowered. A hand may also close by itself, whatever is commanded meanwhile: the largest
force until then is taken over when it begins to fall, or when the first load comes. Only once: a drive that
gives more than it is asked for would be asked for more and more. A grip that learns friction by lowering
force keeps nothing, for it begins low, and feels a slide.
"""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.confirmed_load import CONFIRM_NOISE
from vegrip.grip.kernels.generated import *

TRANSFER_TIME = 0.3  # [s] after which the estimate rules whatever it says; within 0.1 s it has mostly settled


def begin_transfer(f: Floats, t: Wholes, force: float, arm: float, now: int) -> None:
    """Take over at ``now`` [ns] with ``force`` [N]; ``arm`` [m] makes a force of the torque."""
    t.turn.transfer_since, t.turn.in_transfer = now, 1
    f.transfer.force, f.transfer.arm = force, arm
    f.transfer.load = load_in_transfer(f)


def bound_takeover(f: Floats, t: Wholes, now: int) -> None:
    """Ask for no more force than a contact met in its middle shows to suffice."""
    if t.turn.in_transfer == 0:
        return
    elapsed = float(elapsed_time(now, t.turn.transfer_since)) / 1e9
    if t.need.slipping == 1 or not 0.0 <= elapsed < TRANSFER_TIME:
        t.turn.in_transfer = 0
        return
    growth = growth_of_load(f)
    held = f.transfer.force * growth * growth
    ramped = min(f.transfer.force + f.rule.ramp_rate * elapsed, f.rule.safe_force)
    f.demand.least = min(f.demand.least, max(held, ramped))  # this order: min(nan, x) is nan


def growth_of_load(f: Floats) -> float:
    """Return by how much the load has grown; what held no load shows nothing."""
    load = load_in_transfer(f)
    if f.transfer.load > 0.0:
        return max(1.0, load / f.transfer.load)
    return math.inf if load > 0.0 else 1.0


def load_in_transfer(f: Floats) -> float:
    """Return the load [N], the torque as a force at the arm."""
    turning = f.demand.torque / f.transfer.arm if f.transfer.arm > 0.0 else 0.0
    turning = 0.0 if math.isnan(turning) else turning
    return math.sqrt(f.demand.load * f.demand.load + turning * turning)


def hold_unloaded(f: Floats, t: Wholes) -> None:
    """Keep no less than is held until a load is felt: what the margin grip does not go below."""
    f.grip.kept = 0.0
    if t.need.in_contact == 0:
        t.turn.bears = 0
        return
    if t.need.trusted == 0 or t.turn.bears == 1 or t.setup.shares == 1:
        return
    t.turn.bears = 1 if is_load_felt(f) else 0
    f.grip.kept = f.grip.required if t.turn.bears == 0 else 0.0
    if t.turn.has_closed == 0:
        take_over_closed(f, t)


def take_over_closed(f: Floats, t: Wholes) -> None:
    """Keep once the force with which the hand has closed by itself, where it is more than is held."""
    force, much = f.state.normal_force, (1.0 - f.rule.dead_band) * f.grip.closed
    if t.turn.bears == 1 or force < much:
        t.turn.has_closed = 1
        if much > f.grip.held:
            f.grip.kept = f.grip.closed
    f.grip.closed = max(f.grip.closed, force)


def is_load_felt(f: Floats) -> bool:
    """Return whether the load is more than the noise of its channels."""
    turns = f.demand.torque > CONFIRM_NOISE * f.set.s_torque
    return turns or f.demand.load > CONFIRM_NOISE * f.set.s_tangential
