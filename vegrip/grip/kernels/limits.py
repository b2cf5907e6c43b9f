"""Limits that every command passes: rate first, then magnitude, so that the magnitude always holds."""

import math

from vegrip.grip.kernels.generated import *


def clamped(f: Floats, force: float) -> float:
    """Return ``force`` [N] within the least and largest force; NaN gives the least."""
    return min(max(f[RULE_MIN_FORCE], force), f[RULE_MAX_FORCE])  # this order: max(x, nan) is x


def limited(f: Floats, wanted: float, reason: int, dt: float) -> tuple[float, int]:
    """Return ``wanted`` [N] after rate and magnitude limits, and the last stage that changed it."""
    held = f[GRIP_HELD]
    if math.isnan(wanted):
        wanted, reason = held, REASON_UNTRUSTED
    dt = max(0.0, dt)
    reachable = min(max(wanted, held - f[RULE_LOWER_RATE] * dt), held + f[RULE_RAISE_RATE] * dt)
    force = clamped(f, reachable)
    if force > reachable:
        return force, REASON_MIN_LIMIT
    if force < reachable:
        return force, REASON_MAX_LIMIT
    return force, reason if reachable == wanted else REASON_RATE_LIMIT
