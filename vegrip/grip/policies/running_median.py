"""The usual need of the last seconds: a median in slots, to which short errors of a sensor do not matter."""

import math

from vegrip.types import NamedNumbers

WINDOW_SLOTS = 25
"""Of one window; the largest need of each counts."""


class RunningMedian:
    """The median of what was needed over a window.

    Args:
        window: [s]; 0 forgets at once.
        proven_time: [s] within which the lowest median rises to the present one; 0 keeps none.

    """

    def __init__(self, window: float, proven_time: float = 0.0) -> None:
        self._slot = window / WINDOW_SLOTS
        self._largest: list[float] = []  # of each slot, oldest first
        self._present = -math.inf  # largest of the slot that is being filled
        self._filled = 0.0  # [s]
        self._median = -math.inf
        self._proven, self._proven_time = math.inf, proven_time

    def write_to(self, memory: NamedNumbers) -> None:
        """Put everything into a memory."""
        memory.section("LARGEST")[: len(self._largest)] = self._largest
        memory["TURN_SLOTS"], memory["TURN_NEXT_SLOT"] = len(self._largest), len(self._largest) % WINDOW_SLOTS
        memory["GRIP_SLOT"], memory["GRIP_PRESENT"] = self._slot, self._present
        memory["GRIP_FILLED"], memory["GRIP_MEDIAN"] = self._filled, self._median
        memory["GRIP_PROVEN"], memory["GRIP_PROVEN_TIME"] = self._proven, self._proven_time

    def read_from(self, memory: NamedNumbers) -> None:
        """Take everything from where :meth:`write_to` puts it, or where the kernels go on from there."""
        slots, following = int(memory["TURN_SLOTS"]), int(memory["TURN_NEXT_SLOT"])
        largest = memory.section("LARGEST").tolist()
        self._largest = largest[:slots] if slots < WINDOW_SLOTS else largest[following:] + largest[:following]
        self._slot, self._present = memory["GRIP_SLOT"], memory["GRIP_PRESENT"]
        self._filled, self._median = memory["GRIP_FILLED"], memory["GRIP_MEDIAN"]
        self._proven, self._proven_time = memory["GRIP_PROVEN"], memory["GRIP_PROVEN_TIME"]

    def add(self, need: float, dt: float) -> float:
        """Take in a ``need`` [N] that lasted ``dt`` [s]; return the usual one [N].

        Where a lower one was usual of late, that one. Until half of the window has been seen, the largest
        need so far is the usual one.
        """
        if self._slot <= 0.0:
            return need
        self._present = max(self._present, need)
        self._filled += dt
        if self._filled >= self._slot:
            self._largest = [*self._largest, self._present][-WINDOW_SLOTS:]
            self._present, self._filled = -math.inf, 0.0
            ordered = sorted(self._largest)
            half = WINDOW_SLOTS // 2
            self._median = ordered[len(ordered) // 2] if len(ordered) > half else ordered[-1]
            if len(ordered) > half:
                self._prove(self._median)
        if len(self._largest) <= WINDOW_SLOTS // 2:
            return max(self._median, need)
        return min(self._median, self._proven)

    def _prove(self, usual: float) -> None:
        """Keep the lowest median, and let it rise to the present one."""
        if self._proven_time > 0.0:
            part = min(self._slot / self._proven_time, 1.0)
            rise = part * (usual - self._proven) if self._proven < usual else 0.0
            self._proven = min(usual, self._proven + rise)
