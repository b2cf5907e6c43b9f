"""Limits that every command passes: rate first, then magnitude, so that the magnitude always holds."""

import math

from vegrip.grip.kernels.generated import *


def clamped(f: Floats, force: float) -> float:
    """Return ``force`` [N] within the least and largest force; NaN gives the least."""
    return min(max(f.rule.min_force, force), f.rule.max_force)  # this order: max(x, nan) is x


def limited(f: Floats, wanted: float, pressed: float, reason: int, dt: float) -> tuple[float, int]:
    """Return ``wanted`` [N] after rate and magnitude limits, and the last stage that changed it.

    A thumb against which the others press with ``pressed`` [N] is lowered to that at once, and no further;
    NaN: this is none.
    """
    held = f.grip.held
    if math.isnan(wanted):
        wanted, reason = held, REASON_UNTRUSTED
    dt = max(0.0, dt)
    least = held - f.rule.lower_rate * dt if math.isnan(pressed) else min(pressed, held)
    reachable = min(max(wanted, least), held + f.rule.raise_rate * dt)
    force = clamped(f, reachable)
    if force > reachable:
        return force, REASON_MIN_LIMIT
    if force < reachable:
        return force, REASON_MAX_LIMIT
    return force, reason if reachable == wanted else REASON_RATE_LIMIT
