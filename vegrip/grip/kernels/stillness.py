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
        value, last = f.state[i], f.repeated[i]
        measured = measured or value == value  # noqa: PLR0124 (NaN is not itself)
        same = same and (value == last or (value != value and last != last))  # noqa: PLR0124
        f.repeated[i] = value
    if not (same and measured):
        t.input.still_since = now
    return elapsed_time(now, t.input.still_since)


def force_still(f: Floats, t: Wholes, now: int) -> int:
    """Return for how long [ns] the normal force has not moved."""
    if f.state.normal_force != f.repeated_force[0]:
        t.input.force_still_since = now
    f.repeated_force[0] = f.state.normal_force
    return elapsed_time(now, t.input.force_still_since)


def has_travelled(f: Floats, t: Wholes, now: int, still: int) -> bool:
    """Return whether the tip was pressed in or unloaded while the normal force stood for ``still`` [ns]."""
    far, displacement = False, f.state.displacement
    passed = 0 if t.input.is_received == 0 else elapsed_time(now, t.input.received)
    if displacement == displacement:  # noqa: PLR0124 (NaN is not itself)
        place = displacement if displacement > 0.0 else 0.0
        level = place if still == 0 or math.isnan(f.watch.level) else f.watch.level
        f.watch.level = level + (place - level) * min(float(passed) / 1e9 / TRAVEL_SECONDS, 1.0)
        far = f.state.normal_force > HELD_FORCE and abs(place - f.watch.level) > f.rule.stuck_travel
    was_proven = float(elapsed_time(now, t.input.travel_since) - passed) > f.rule.doubt_after
    if still == 0 or not (was_proven or (far and float(passed) <= f.rule.doubt_after)):
        t.input.travel_since = now
    return float(elapsed_time(now, t.input.travel_since)) > f.rule.doubt_after
