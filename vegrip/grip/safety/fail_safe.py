"""What a finger does while its input or its estimate cannot be believed.

::

    normal --fault--> hold (last safe command) --hold_time--> ramp to the fail-safe grip --recovered--> normal

Never make the grip worse because of a fault: from the first faulty instant the command does not fall, neither
to zero nor to a fail-safe grip that happens to be smaller than what is held.
"""

import math
from dataclasses import dataclass

from vegrip.config import parameter
from vegrip.grip.safety.limits import MAX_FORCE_N, MOST_RATE
from vegrip.messages import Reason
from vegrip.types import NamedNumbers


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


class FailSafe:
    """Hold, then ramp; one per finger."""

    def __init__(self, settings: FailSafeSettings) -> None:
        self.settings = settings
        self.recovered()

    def recovered(self) -> None:
        """Return to normal; the next fault starts anew."""
        self._elapsed = -math.inf  # [s] since the fault began; -inf = there is none

    @property
    def active(self) -> bool:
        """Whether a fault is being ridden out."""
        return self._elapsed >= 0.0

    def write_to(self, memory: NamedNumbers) -> None:
        """Put settings and state into a memory."""
        settings = self.settings
        memory["RULE_SAFE_FORCE"], memory["RULE_HOLD_TIME"] = settings.force, settings.hold_time
        memory["RULE_RAMP_RATE"], memory["GRIP_ELAPSED"] = settings.ramp_rate, self._elapsed

    def read_from(self, memory: NamedNumbers) -> None:
        """Take the state from where :meth:`write_to` puts it."""
        self._elapsed = memory["GRIP_ELAPSED"]

    def command(self, held: float, dt: float, holding: Reason) -> tuple[float, Reason]:
        """Return the force [N] under a fault and its reason.

        Args:
            held: force commanded last [N].
            dt: time since then [s].
            holding: the reason given while the last safe command is held.

        """
        self._elapsed = self._elapsed + dt if self.active else 0.0
        if self._elapsed < self.settings.hold_time or held >= self.settings.force:
            return held, holding
        return min(held + self.settings.ramp_rate * dt, self.settings.force), Reason.FAIL_SAFE
