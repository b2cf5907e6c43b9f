"""What a node says of its input in its log: of which finger it is lost, and when it is trusted again."""

import logging

from vegrip.messages import Condition, ModelHealth

LOST = {
    Condition.STALE: "no state came within the time-out",
    Condition.MISSING: "no channel of it can be used",
    Condition.OUT_OF_RANGE: "what it measures is out of range",
    Condition.FROZEN: "its counter runs, and its values do not",
    Condition.REPLAYED: "its counter or time runs backwards, or stands still",
    Condition.CORRUPT: "its frames are damaged",
}
"""What is wrong, by condition; with any other the input is trusted."""


class InputLog:
    """Says at once that the input of a finger is lost, and at a later report that it is trusted again.

    So input that comes and goes is said once in the period of the reports of health. Before it was trusted
    for the first time there is nothing to lose.
    """

    def __init__(self, node: str) -> None:
        self._logger = logging.getLogger(f"vegrip.{node}")
        self._is_lost: dict[str, bool] = {}  # of those that were trusted once

    def log_changes(self, health: ModelHealth, *, is_periodic: bool) -> None:
        """Log the input of the finger of ``health`` where that is news."""
        finger, why = health.finger, LOST.get(health.condition)
        if why is not None and self._is_lost.get(finger) is False:
            self._is_lost[finger] = True
            self._logger.warning("input of %s is lost: %s", finger, why)
        elif why is None and is_periodic:
            if self._is_lost.get(finger):
                self._logger.info("input of %s is trusted again", finger)
            self._is_lost[finger] = False
