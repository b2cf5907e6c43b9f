"""Finds two hands that speak as one: their states come in turn, and their counters may fit into each other.

Of the values ``x_i`` of one channel compare, over the last states,

    S_1 = mean of (x_i - x_{i-1})^2     and     S_2 = mean of (x_i - x_{i-2})^2 .

For a value that moves slowly ``S_1 < S_2``, for noise alone they are equal. Two streams in turn that differ
by ``D``, each with noise of standard deviation ``sigma``, have ``S_1 / S_2 = 1 + D^2 / (2 sigma^2)``: every
other value is near, the next one is not. A vibration at half the rate of the states looks the same, so this
only tells.
"""

import math
from typing import Final

from vegrip.messages import FingertipState

WINDOW_STATES: Final = 64  # states
TWO_SENDERS_RATIO: Final = (
    6.0  # of S_1 to S_2; noise alone comes to 1, streams three standard deviations apart to 5.5
)
IN_A_ROW: Final = 16  # states for which the ratio holds; coarse values alternate by chance, but not for long
TURN_STATES: Final = 512  # of all fingers until another one is looked at: a hundred of each of five
MOST_FINGERS: Final = 256  # are watched; a sender of made-up names must not make the table grow


class _Channel:
    __slots__ = ("_above", "_before", "_last", "_one", "_two")

    def __init__(self) -> None:
        self._last = self._before = math.nan
        self._one = self._two = 0.0  # S_1, S_2, forgetting
        self._above = 0  # states in a row with too large a ratio

    def note(self, value: float) -> bool:
        one, two = value - self._last, value - self._before
        self._before, self._last = self._last, value
        if two != two:  # noqa: PLR0124 (NaN: the first two)
            return False
        self._one += (one * one - self._one) / WINDOW_STATES
        self._two += (two * two - self._two) / WINDOW_STATES
        self._above = self._above + 1 if self._one > TWO_SENDERS_RATIO * self._two else 0
        return self._above >= IN_A_ROW


class _Finger:
    __slots__ = ("_count", "_displacement", "_force")

    def __init__(self) -> None:
        self._count = 0
        self._force, self._displacement = _Channel(), _Channel()

    def note(self, force: float, displacement: float) -> bool:
        self._count += 1
        alternates = force - force == 0.0 and self._force.note(force)
        alternates |= displacement - displacement == 0.0 and self._displacement.note(displacement)
        return alternates and self._count > WINDOW_STATES


class SenderWatch:
    """Counts the states in which a finger seems to be two."""

    def __init__(self) -> None:
        self.count = 0
        self._fingers: dict[str, _Finger] = {}
        self._turn, self._passed = "", TURN_STATES

    def has_turn(self, name: str) -> bool:
        """Return whether the next state of the finger ``name`` is to be looked at.

        For one who cannot afford to look at all: one finger after the other has its turn.
        """
        self._passed += 1
        if self._passed > TURN_STATES and name != self._turn:
            self._turn, self._passed = name, 0
        return name == self._turn

    def note(self, state: FingertipState) -> None:
        self.note_values(state.finger, state.normal_force, state.displacement)

    def note_values(self, name: str, force: float, displacement: float) -> None:
        """Take in normal force [N] and displacement [m] of the next state of the finger ``name``."""
        finger = self._fingers.get(name)
        if finger is None:
            if len(self._fingers) >= MOST_FINGERS:
                return
            finger = self._fingers[name] = _Finger()
        self.count += finger.note(force, displacement)
