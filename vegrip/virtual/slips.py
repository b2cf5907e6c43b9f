"""Counting slips: a slip is a stretch of time in which a whole patch slides by more than a hair's breadth."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Sliding = npt.NDArray[np.bool_]

SLIDING = 0.95
"""Ratio of slip speed to speed of the object over the patch from which the patch counts as sliding [-]."""

CREEPING = 1e-3
"""A patch that slips slower than this many contact radii per second is creeping [1/s]."""

DISTANCE = 1e-4
"""A patch that slid less than this in an event was creeping, not slipping [m]."""

QUIET = 0.05
"""A slip is over when no patch has slid for this long [s]."""


def is_sliding(sliding: Array, speed: Array, a: Array) -> Sliding:
    """Return which patches slide as a whole: ratio of speeds [-], slip speed [m/s], contact radius [m]."""
    whole: Sliding = (sliding > SLIDING) & (speed > CREEPING * a)
    return whole


class SlipCounter:
    """Counts the slips of a hand; patches that slide together, or within :data:`QUIET`, are one slip."""

    def __init__(self) -> None:
        self.count = 0
        self._open = False
        self._counted = False
        self._still = 0.0
        self._slid = np.zeros(0)

    def watch(self, whole: Sliding, speed: Array, dt: float) -> None:
        """Look at which patches slide, and their slip speeds [m/s], over ``dt`` [s]."""
        if whole.any():
            if not self._open:
                self._open, self._counted, self._slid = True, False, np.zeros(len(speed))
            self._still = 0.0
            self._slid += np.where(whole, speed * dt, 0.0)
            if not self._counted and self._slid.max() > DISTANCE:
                self._counted, self.count = True, self.count + 1
        elif self._open:
            self._still += dt
            self._open = self._still < QUIET
