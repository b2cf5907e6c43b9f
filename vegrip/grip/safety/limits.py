"""Limits that every command passes: rate first, then magnitude, so that the magnitude always holds."""

import math
from dataclasses import dataclass
from typing import Final

from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.messages import Reason

MOST_FORCE: Final = 1e3
"""[N] Beyond any fingertip; a limit that is set higher by mistake would be none."""

MOST_RATE: Final = 1e5
"""[N/s] The same of rates."""


@dataclass(frozen=True)
class LimitSettings:
    """Bounds of the commanded grip force."""

    min_force: float = parameter(
        0.3, unit="N", low=0.0, high=MOST_FORCE, doc="least commanded force; keeps touch"
    )
    max_force: float = parameter(15.0, unit="N", low=0.0, high=MOST_FORCE, doc="largest commanded force")
    raise_rate: float = parameter(
        80.0, unit="N/s", low=0.0, high=MOST_RATE, doc="fastest rise of the command"
    )
    lower_rate: float = parameter(8.0, unit="N/s", low=0.0, high=MOST_RATE, doc="fastest fall of the command")
    lifetime: float = parameter(0.1, unit="s", low=0.001, high=10.0, doc="a command expires after so long")

    def __post_init__(self) -> None:
        if not self.min_force <= self.max_force < math.inf:
            raise ConfigError(
                f"limits: 'min_force' is {self.min_force:g} N and 'max_force' {self.max_force:g} N;"
                " the least force must not exceed the largest, which must be finite"
            )


def clamped(force: float, limits: LimitSettings) -> float:
    """Return ``force`` [N] within the least and largest force; NaN gives the least."""
    return min(max(limits.min_force, force), limits.max_force)  # this order: max(x, nan) is x


def limited(
    wanted: float, reason: Reason, held: float, dt: float, limits: LimitSettings
) -> tuple[float, Reason]:
    """Return ``wanted`` [N] after rate and magnitude limits, and the last stage that changed it.

    Args:
        wanted: force asked for [N]; one that is not a number holds.
        reason: why it was asked for.
        held: force commanded last [N], finite.
        dt: time since then [s]; negative counts as zero.
        limits: the bounds.

    """
    if math.isnan(wanted):
        wanted, reason = held, Reason.UNTRUSTED
    dt = max(0.0, dt)
    reachable = min(max(wanted, held - limits.lower_rate * dt), held + limits.raise_rate * dt)
    force = clamped(reachable, limits)
    if force > reachable:
        return force, Reason.MIN_LIMIT
    if force < reachable:
        return force, Reason.MAX_LIMIT
    return force, reason if reachable == wanted else Reason.RATE_LIMIT
