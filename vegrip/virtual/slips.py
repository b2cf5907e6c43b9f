"""Counting slips: a slip is a stretch of time in which a whole patch slides by more than a hair's breadth."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

SLIDING = 0.99
"""Share of the normal force on sliding elements from which a patch counts as sliding [-]."""

DISTANCE = 1e-4
"""A patch that slid less than this in an event was creeping, not slipping [m]."""

QUIET = 0.05
"""A slip is over when no patch has slid for this long [s]."""


class SlipCounter:
    """Counts the slips of a hand; patches that slide together, or within :data:`QUIET`, are one slip."""

    def __init__(self) -> None:
        self.count = 0
        self._open = False
        self._counted = False
        self._still = 0.0
        self._slid = np.zeros(0)

    def watch(self, sliding: Array, speed: Array, dt: float) -> None:
        """Look at the sliding shares [-] and slip speeds [m/s] of all patches over ``dt`` [s]."""
        whole = sliding > SLIDING
        if whole.any():
            if not self._open:
                self._open, self._counted, self._slid = True, False, np.zeros(len(sliding))
            self._still = 0.0
            self._slid += np.where(whole, speed * dt, 0.0)
            if not self._counted and self._slid.max() > DISTANCE:
                self._counted, self.count = True, self.count + 1
        elif self._open:
            self._still += dt
            self._open = self._still < QUIET
