"""Settings of what a finger does while its input or its estimate cannot be believed."""

from dataclasses import dataclass

from vegrip.config import parameter
from vegrip.grip.safety.limits import MAX_FORCE_N, MOST_RATE


@dataclass(frozen=True)
class FailSafeSettings:
    """The grip of last resort."""

    force: float = parameter(
        5.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="fail-safe grip; lower commands ramp up to it"
    )
    hold_time: float = parameter(
        0.25, unit="s", low=0.0, high=60.0, doc="the last safe command is held so long"
    )
    ramp_rate: float = parameter(
        10.0, unit="N/s", low=0.0, high=MOST_RATE, doc="rate of the ramp to the fail-safe grip"
    )
