"""For how long channels have repeated themselves to the last bit: a live sensor has noise.

A missing channel cannot freeze, others beside it can.
"""

from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.kernels.generated import (
    INPUT_FORCE_STILL_SINCE,
    INPUT_STILL_SINCE,
    MECHANICAL,
    REPEATED0,
    REPEATED_FORCE0,
    STATE0,
    STATE_NORMAL_FORCE,
    Floats,
    Wholes,
)


def all_still(f: Floats, t: Wholes, now: int) -> int:
    """Return for how long [ns] no mechanical channel has moved."""
    same, measured = True, False
    for i in range(MECHANICAL):
        value, last = f[STATE0 + i], f[REPEATED0 + i]
        measured = measured or value == value  # noqa: PLR0124 (NaN is not itself)
        same = same and (value == last or (value != value and last != last))  # noqa: PLR0124
        f[REPEATED0 + i] = value
    if not (same and measured):
        t[INPUT_STILL_SINCE] = now
    return elapsed_time(now, t[INPUT_STILL_SINCE])


def force_still(f: Floats, t: Wholes, now: int) -> int:
    """Return for how long [ns] the normal force has not moved."""
    if f[STATE_NORMAL_FORCE] != f[REPEATED_FORCE0]:
        t[INPUT_FORCE_STILL_SINCE] = now
    f[REPEATED_FORCE0] = f[STATE_NORMAL_FORCE]
    return elapsed_time(now, t[INPUT_FORCE_STILL_SINCE])
