"""The time of the steps of a hand as its owner tells it: one wrong time must not hold the grip up.

A time before the last one, or further after it than a drive would obey, is not believed until another such
time follows: one of a kind is wrong, two are a pause, or a clock that was set.
"""

from vegrip.grip.finger_step import NOT_NUMBERS, as_whole
from vegrip.grip.safety import AHEAD


class StepTime:
    """What is believed of the time."""

    def __init__(self) -> None:
        self.now = 0
        """[ns] of the last step."""
        self._has_begun = self._is_sure = False  # sure: the last step followed on another
        self._doubts = False

    def take(self, now: object) -> int | None:
        """Go on to ``now`` [ns]; return by what the clock was set, or None where that is not believed."""
        try:
            told = as_whole(now)
        except NOT_NUMBERS:
            return None
        passed = told - self.now
        is_odd = self._has_begun and not 0 <= passed <= AHEAD
        if is_odd and not self._doubts:
            self._doubts = True
            return None
        is_set = is_odd and (passed < 0 or not self._is_sure)  # else it is a pause
        self._is_sure, self._has_begun = self._has_begun and not is_odd, True
        self.now, self._doubts = told, False
        return passed if is_set else 0
