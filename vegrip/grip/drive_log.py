"""What a node says of the drives in its log: how far they lag behind, and what that costs."""

import logging
import math

from vegrip.grip.grasp_friction import GraspFriction
from vegrip.grip.load_lead import LEAD_MOST, reserve_for
from vegrip.grip.policies.margin_grip import GripSettings

CHANGED = 0.3
"""Relative change of a measured lag from which on it is said again."""


def describe_lag(lag: float, grip: GripSettings) -> str:
    """Return what a measured ``lag`` [s] means, in a sentence without its subject."""
    said = f"lag {1e3 * lag:.0f} ms"
    if grip.drive_lag > 0.0:
        said += f", configured {1e3 * grip.drive_lag:.0f} ms"
    more = 100.0 * (reserve_for(lag, grip.burst_rate) - 1.0)
    if lag <= LEAD_MOST:
        return said
    saved = f", for the rest {more:.0f} % more is held, which a quicker drive would not need"
    return f"{said}; {1e3 * LEAD_MOST:.0f} ms of it are led" + (saved if more >= 0.5 else "")


class DriveLog:
    """Says what is measured of each drive once it is known, and again when it changes."""

    def __init__(self, node: str) -> None:
        self._logger = logging.getLogger(f"vegrip.{node}")
        self._said: dict[str, float] = {}  # lag [s] by finger, as it was last said

    def log_changes(self, finger: str, friction: GraspFriction, grip: GripSettings) -> None:
        """Log the drive of ``finger`` where that is news."""
        lag, said = friction.drive_lag(finger), self._said.get(finger, math.inf)
        if math.isnan(lag) or abs(lag - said) <= CHANGED * said < math.inf:
            return
        self._said[finger] = lag
        self._logger.info("drive of %s: %s", finger, describe_lag(lag, grip))
