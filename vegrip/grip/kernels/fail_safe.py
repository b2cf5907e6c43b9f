"""What a finger does while its input or its estimate cannot be believed.

::

    normal --fault--> hold (last safe command) --hold_time--> ramp to the fail-safe grip --recovered--> normal

Never make the grip worse because of a fault: from the first faulty instant the command does not fall, neither
to zero nor to a fail-safe grip that happens to be smaller than what is held. What had been lowered to learn
friction comes back at the same rate: a slide would not be noticed.
"""

import math

from vegrip.grip.kernels.choice import forget_policy
from vegrip.grip.kernels.generated import *


def end_fault(f: Floats) -> None:
    """Return to normal; the next fault starts anew."""
    f.grip.elapsed = -math.inf


def is_at_fault(f: Floats) -> bool:
    """Return whether a fault is being ridden out."""
    return f.grip.elapsed >= 0.0


def hold_then_ramp(f: Floats, t: Wholes, dt: float, holding: int) -> None:
    """Require what is held, or was asked for while all was well, and after a while the fail-safe grip."""
    safe = max(f.grip.held, f.grip.required)
    safe = max(safe, min(safe + f.rule.ramp_rate * dt, f.grip.lowered_from))
    forget_policy(f, t)
    f.grip.elapsed = f.grip.elapsed + dt if is_at_fault(f) else 0.0
    if f.grip.elapsed < f.rule.hold_time or safe >= f.rule.safe_force:
        f.grip.required = safe
        t.turn.reason = holding
    else:
        f.grip.required = min(safe + f.rule.ramp_rate * dt, f.rule.safe_force)
        t.turn.reason = REASON_FAIL_SAFE
