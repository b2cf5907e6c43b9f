"""The control of one finger, from its demand to its command: policy, fail-safe, limits.

The first command equals the force that is there (no bump at activation); before it there is none at all.
"""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.kernels.choice import asked_force, forget_policy
from vegrip.grip.kernels.fail_safe import end_fault, hold_then_ramp, is_at_fault
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.limits import clamped, limited


def start_control(f: Floats, t: Wholes, present: float, now: int) -> None:
    """Take over at the force ``present`` [N] that the finger has; NaN counts as none."""
    f.grip.held = f.grip.required = clamped(f, present)
    f.grip.kept, f.grip.closed, t.turn.has_closed = 0.0, 0.0, 0
    t.turn.commanded = t.turn.asked = now
    t.turn.started = 1
    forget_policy(f, t)
    end_fault(f)


def require_force(f: Floats, t: Wholes, now: int) -> None:
    """Find what this finger needs at ``now`` [ns]."""
    if t.input.condition > CONDITION_DEGRADED:
        hold_without_input(f, t, now)
        return
    dt = time_asked(t, now)
    t.turn.asked = max(t.turn.asked, now)
    force, reason = asked_force(f, t, base_force(f, t), dt)
    if reason == REASON_UNTRUSTED or math.isnan(force):
        hold_then_ramp(f, t, dt, REASON_UNTRUSTED)
        return
    end_fault(f)
    f.grip.required = clamped(f, force)
    limit = REASON_MAX_LIMIT if force > f.grip.required else REASON_MIN_LIMIT
    t.turn.reason = reason if f.grip.required == force else limit


def hold_without_input(f: Floats, t: Wholes, now: int) -> None:
    """Require what a finger needs whose input is not believed, or not looked at."""
    dt = time_asked(t, now)
    t.turn.asked = max(t.turn.asked, now)
    hold_then_ramp(f, t, dt, REASON_INPUT_HOLD)


def time_asked(t: Wholes, now: int) -> float:
    """Return the time [s] since the need was last asked."""
    return max(0.0, float(elapsed_time(now, t.turn.asked)) / 1e9)


def base_force(f: Floats, t: Wholes) -> float:
    """Return the force [N] from which the policy starts: after slip or a fault what is held."""
    return f.grip.held if t.need.slipping == 1 or is_at_fault(f) else f.grip.required


def command_share(f: Floats, t: Wholes, share: float, pressed: float, now: int) -> tuple[float, int]:
    """Command this finger's ``share`` [N]; return the change of its force [N] and the reason.

    ``pressed`` [N] is what the others are commanded against it, NaN where it is no thumb.
    """
    wanted = max(share, f.grip.required)
    if is_at_fault(f):
        wanted, pressed = f.grip.required, math.nan
    # not longer than a command lives: after a silence the hand is on its own, and must not see a jump
    dt = min(float(elapsed_time(now, t.turn.commanded)) / 1e9, f.rule.lifetime)
    force, reason = limited(f, wanted, pressed, t.turn.reason, dt)
    adjustment = force - f.grip.held
    f.grip.held = force
    t.turn.commanded = max(t.turn.commanded, now)
    t.turn.seq += 1
    return adjustment, reason


def is_renewal_due(t: Wholes, now: int) -> bool:
    """Return whether the last command is so old that it must be renewed well before it expires."""
    return elapsed_time(now, t.turn.commanded) >= t.setup.renewal and t.turn.started == 1
