"""What a drive can do: its steps, its pace, its ends. Data of its map, in ``[drive]``."""

import math
from dataclasses import dataclass

from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.grip.safety import MAX_FORCE_N


@dataclass(frozen=True)
class DriveLimits:
    """``[drive]`` of a map; every key left out says that the drive sets no such limit.

    Raises:
        ConfigError: ends of the force that cannot be, or steps and hysteresis that do not fit between them.

    """

    resolution: float = parameter(0.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="one step of the force")
    rate: float = parameter(0.0, unit="Hz", low=0.0, high=1e5, doc="most commands a second; 0: no limit")
    delay: float = parameter(0.0, unit="s", low=0.0, high=10.0, doc="from a command to its force")
    minimum: float = parameter(
        0.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="least force that it presses with"
    )
    maximum: float = parameter(math.inf, unit="N", low=0.0, doc="largest force")
    hysteresis: float = parameter(
        0.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="a change of the force smaller than this may do nothing"
    )

    def __post_init__(self) -> None:
        if not self.minimum < self.maximum:
            raise ConfigError(
                f"drive: 'minimum' is {self.minimum:g} N and 'maximum' {self.maximum:g} N; "
                "the least force must be below the largest"
            )
        between = self.maximum - self.minimum
        for key in ("resolution", "hysteresis"):
            if getattr(self, key) > between:
                raise ConfigError(
                    f"drive: {key!r} is {getattr(self, key):g} N, but from 'minimum' to 'maximum' there are "
                    f"only {between:g} N; such a drive cannot be set"
                )
