"""What a finger does while its input or its estimate cannot be believed.

::

    normal --fault--> hold (last safe command) --hold_time--> ramp to the fail-safe grip --recovered--> normal

Never make the grip worse because of a fault: from the first faulty instant the command does not fall, neither
to zero nor to a fail-safe grip that happens to be smaller than what is held.
"""

import math

from vegrip.grip.kernels.choice import forget_policy
from vegrip.grip.kernels.generated import *


def end_fault(f: Floats) -> None:
    """Return to normal; the next fault starts anew."""
    f[GRIP_ELAPSED] = -math.inf


def is_at_fault(f: Floats) -> bool:
    """Return whether a fault is being ridden out."""
    return f[GRIP_ELAPSED] >= 0.0


def ride_out_fault(f: Floats, t: Wholes, dt: float, holding: int) -> None:
    """Require what is held, or was asked for while all was well, and after a while the fail-safe grip."""
    safe = max(f[GRIP_HELD], f[GRIP_REQUIRED])
    forget_policy(f, t)
    f[GRIP_ELAPSED] = f[GRIP_ELAPSED] + dt if is_at_fault(f) else 0.0
    if f[GRIP_ELAPSED] < f[RULE_HOLD_TIME] or safe >= f[RULE_SAFE_FORCE]:
        f[GRIP_REQUIRED] = safe
        t[TURN_REASON] = holding
    else:
        f[GRIP_REQUIRED] = min(safe + f[RULE_RAMP_RATE] * dt, f[RULE_SAFE_FORCE])
        t[TURN_REASON] = REASON_FAIL_SAFE
