"""The usual need of the last seconds: a median in slots, to which short errors of a sensor do not matter."""

import math

SLOTS = 25
"""Of one window; the largest need of each counts."""


class UsualNeed:
    """The median of what was needed over a window.

    Args:
        window: [s]; 0 forgets at once.

    """

    def __init__(self, window: float) -> None:
        self._slot = window / SLOTS
        self._largest: list[float] = []  # of each slot, oldest first
        self._present = -math.inf  # largest of the slot that is being filled
        self._filled = 0.0  # [s]
        self._median = -math.inf

    def add(self, need: float, dt: float) -> float:
        """Take in a ``need`` [N] that lasted ``dt`` [s]; return the usual one [N].

        Until half of the window has been seen, the largest need so far is the usual one.
        """
        if self._slot <= 0.0:
            return need
        self._present = max(self._present, need)
        self._filled += dt
        if self._filled >= self._slot:
            self._largest = [*self._largest, self._present][-SLOTS:]
            self._present, self._filled = -math.inf, 0.0
            ordered = sorted(self._largest)
            half = SLOTS // 2
            self._median = ordered[len(ordered) // 2] if len(ordered) > half else ordered[-1]
        return max(self._median, need) if len(self._largest) <= SLOTS // 2 else self._median
