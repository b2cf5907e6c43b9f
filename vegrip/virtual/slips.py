"""Counting slips: a slip is a stretch of time in which a whole patch slides by more than a hair's breadth."""

import numpy as np
import numpy.typing as npt

from vegrip.types import Floats
from vegrip.virtual import kernels

Sliding = npt.NDArray[np.bool_]

SLIDING = 0.95
"""Ratio of slip speed to speed of the object over the patch from which the patch counts as sliding [-]."""

CREEPING = 1e-3
"""A patch that slips slower than this many contact radii per second is creeping [1/s]."""

DISTANCE = 1e-4
"""A patch that slid less than this in an event was creeping, not slipping [m]."""

SEPARATING_REST_S = 0.05
"""A slip is over when no patch has slid for this long [s]."""


CONSTANTS = np.array([SLIDING, CREEPING, DISTANCE, SEPARATING_REST_S])


def is_sliding(sliding: Floats, speed: Floats, a: Floats) -> Sliding:
    """Return which patches slide as a whole: ratio of speeds [-], slip speed [m/s], contact radius [m]."""
    whole: Sliding = (sliding > SLIDING) & (speed > CREEPING * a)
    return whole


class SlipCounter:
    """Counts the slips of a hand; patches that slide within :data:`SEPARATING_REST_S` are one slip.

    Args:
        fingers: how many patches there are.

    """

    def __init__(self, fingers: int) -> None:
        self.sliding = np.zeros(fingers)  # 1 for a patch that slides as a whole
        self.slid = np.zeros(fingers)  # [m] of each patch in this event
        self.event = np.zeros(5)  # slips so far, 1 in an event, 1 when it was counted, [s] of rest in it,
        # [m] largest slide of an event that was not counted

    @property
    def count(self) -> int:
        """Number of distinct slips so far."""
        return int(self.event[0])

    @property
    def largest_micro_slip(self) -> float:
        """How far a patch slid at most in an event that is too short to count as a slip [m]."""
        _, is_open, is_counted, _, largest = self.event.tolist()
        return max(largest, float(self.slid.max())) if is_open and not is_counted else largest

    def watch(self, slip: Floats, a: Floats, dt: float) -> None:
        """Look at the slip of every patch over ``dt`` [s].

        ``slip`` has the ratio of speeds [-] and the slip speed [m/s] of each, ``a`` the contact radii [m].
        """
        kernels.watch_slips(slip, a, self.sliding, self.slid, self.event, CONSTANTS, dt)
