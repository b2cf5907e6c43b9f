"""The control of one finger, from its demand to its command: policy, fail-safe, limits.

The first command equals the force that is there (no bump at activation); before it there is none at all.
"""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.kernels.choice import asked_force, forget_policy
from vegrip.grip.kernels.fail_safe import end_fault, is_at_fault, ride_out_fault
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.limits import clamped, limited


def start_control(f: Floats, t: Wholes, present: float, now: int) -> None:
    """Take over at the force ``present`` [N] that the finger has; NaN counts as none."""
    f[GRIP_HELD] = f[GRIP_REQUIRED] = clamped(f, present)
    t[TURN_COMMANDED] = t[TURN_ASKED] = now
    t[TURN_STARTED] = 1
    forget_policy(f, t)
    end_fault(f)


def require_force(f: Floats, t: Wholes, now: int) -> None:
    """Find what this finger needs at ``now`` [ns]."""
    if t[INPUT_CONDITION] > CONDITION_DEGRADED:
        ride_out_input(f, t, now)
        return
    dt = time_asked(t, now)
    t[TURN_ASKED] = max(t[TURN_ASKED], now)
    force, reason = asked_force(f, t, base_force(f, t), dt)
    if reason == REASON_UNTRUSTED or math.isnan(force):
        ride_out_fault(f, t, dt, REASON_UNTRUSTED)
        return
    end_fault(f)
    f[GRIP_REQUIRED] = clamped(f, force)
    limit = REASON_MAX_LIMIT if force > f[GRIP_REQUIRED] else REASON_MIN_LIMIT
    t[TURN_REASON] = reason if f[GRIP_REQUIRED] == force else limit


def ride_out_input(f: Floats, t: Wholes, now: int) -> None:
    """Require what a finger needs whose input is not believed, or not looked at."""
    dt = time_asked(t, now)
    t[TURN_ASKED] = max(t[TURN_ASKED], now)
    ride_out_fault(f, t, dt, REASON_INPUT_HOLD)


def time_asked(t: Wholes, now: int) -> float:
    """Return the time [s] since the need was last asked."""
    return max(0.0, float(elapsed_time(now, t[TURN_ASKED])) / 1e9)


def base_force(f: Floats, t: Wholes) -> float:
    """Return the force [N] from which the policy starts: after slip or a fault what is held."""
    return f[GRIP_HELD] if t[NEED_SLIPPING] == 1 or is_at_fault(f) else f[GRIP_REQUIRED]


def command_share(f: Floats, t: Wholes, share: float, now: int) -> tuple[float, int]:
    """Command this finger's ``share`` [N]; return the change of its force [N] and the reason."""
    wanted = f[GRIP_REQUIRED] if is_at_fault(f) else max(share, f[GRIP_REQUIRED])
    # not longer than a command lives: after a silence the hand is on its own, and must not see a jump
    dt = min(float(elapsed_time(now, t[TURN_COMMANDED])) / 1e9, f[RULE_LIFETIME])
    force, reason = limited(f, wanted, t[TURN_REASON], dt)
    adjustment = force - f[GRIP_HELD]
    f[GRIP_HELD] = force
    t[TURN_COMMANDED] = max(t[TURN_COMMANDED], now)
    t[TURN_SEQ] += 1
    return adjustment, reason


def is_renewal_due(t: Wholes, now: int) -> bool:
    """Return whether the last command is so old that it must be renewed well before it expires."""
    return elapsed_time(now, t[TURN_COMMANDED]) >= t[SETUP_RENEWAL] and t[TURN_STARTED] == 1
