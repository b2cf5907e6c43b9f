"""For how long channels have repeated themselves to the last bit: a live sensor has noise.

A missing channel cannot freeze, others beside it can.

A coarse sensor may stand still at rest, but not while the indentation changes by several of its steps. Creep
under a held force does that too, but slowly: what counts is how far the indentation is from its average over
``TRAVEL_SECONDS``, for ``doubt_after``, so a few wrong values prove nothing. What is proven stays until
the force moves. Below ``HELD_FORCE`` the finger may be in the air.
"""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.kernels.generated import *

TRAVEL_SECONDS = 0.5
HELD_FORCE = 0.3  # [N]


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


def has_travelled(f: Floats, t: Wholes, now: int, still: int) -> bool:
    """Return whether the tip was pressed in or let go while the normal force stood for ``still`` [ns]."""
    far, displacement = False, f[STATE_DISPLACEMENT]
    passed = 0 if t[INPUT_IS_HEARD] == 0 else elapsed_time(now, t[INPUT_HEARD])
    if displacement == displacement:  # noqa: PLR0124 (NaN is not itself)
        place = displacement if displacement > 0.0 else 0.0
        level = place if still == 0 or math.isnan(f[WATCH_LEVEL]) else f[WATCH_LEVEL]
        f[WATCH_LEVEL] = level + (place - level) * min(float(passed) / 1e9 / TRAVEL_SECONDS, 1.0)
        far = f[STATE_NORMAL_FORCE] > HELD_FORCE and abs(place - f[WATCH_LEVEL]) > f[RULE_STUCK_TRAVEL]
    was_proven = float(elapsed_time(now, t[INPUT_TRAVEL_SINCE]) - passed) > f[RULE_DOUBT_AFTER]
    if still == 0 or not (was_proven or (far and float(passed) <= f[RULE_DOUBT_AFTER])):
        t[INPUT_TRAVEL_SINCE] = now
    return float(elapsed_time(now, t[INPUT_TRAVEL_SINCE])) > f[RULE_DOUBT_AFTER]
