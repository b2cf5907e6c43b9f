"""Bounds of the commanded grip force (:mod:`vegrip.grip.kernels.limits` keeps them)."""

import math
from dataclasses import dataclass
from typing import Final

from vegrip.config import parameter
from vegrip.errors import ConfigError

MAX_FORCE_N: Final = 1e3
"""[N] Beyond any fingertip; a limit that is set higher by mistake would be none."""

MOST_RATE: Final = 1e5
"""[N/s] The same of rates."""


@dataclass(frozen=True)
class LimitSettings:
    """Bounds of the commanded grip force."""

    min_force: float = parameter(
        0.3, unit="N", low=0.0, high=MAX_FORCE_N, doc="least commanded force; keeps touch"
    )
    max_force: float = parameter(15.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="largest commanded force")
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
