"""States that were sent and never came, by the counter of one finger: holes in a recording."""

from typing import Final

from vegrip.clock import NS
from vegrip.messages import FingertipState

SILENCE_S: Final = 0.5  # [s] after which a counter may go on anywhere, because its sender has started again
LIKE: Final = 0.1  # part of the states of a silence by which counter and time may differ
MISSING: Final = "missing_states"
"""Key in ``[source]`` of ``recording.toml``."""


class MissingStates:
    """Counts them; a longer silence counts when the counter has moved on as time has."""

    def __init__(self) -> None:
        self.count = 0
        self._first: FingertipState | None = None
        self._last: FingertipState | None = None

    def take(self, state: FingertipState) -> None:
        """Take the next state that came."""
        first, last = self._first, self._last
        if first is None or last is None:
            self._first = self._last = state
            return
        step, silence = state.seq - last.seq, state.stamp - last.stamp
        if step <= 0:  # it was overtaken, and has been counted
            self.count -= self.count > 0
            return
        self._last = state
        expected = silence * (last.seq - first.seq) / max(last.stamp - first.stamp, 1)
        if silence < SILENCE_S * NS or abs(step - expected) <= LIKE * expected:
            self.count += step - 1


def told(count: int) -> str:
    return f"{count} states were sent and are not in it: the recorder was too slow, or the bus lost them"
