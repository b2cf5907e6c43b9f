"""Whether a tip is pressed in, or let go, while its normal force stands still: then that sensor is stuck.

A coarse sensor may stand still at rest, but not while the indentation changes by several of its steps. Creep
under a held force does that too, but slowly: what counts is how far the indentation is from its average over
:data:`TRAVEL_TIME_S`, for ``doubt_after``, so a few wrong values prove nothing. What is proven stays until
the force moves. Below :data:`HELD_N` the finger may be in the air.
"""

import math

from vegrip.clock import NS
from vegrip.estimator.elapsed import elapsed_time
from vegrip.messages import FingertipState
from vegrip.types import NamedNumbers

TRAVEL_TIME_S = 0.5
HELD_N = 0.3


class Travel:
    """Watches the displacement of one finger beside its normal force.

    Args:
        least: travel that counts [m].
        proof: for how long it must last [ns].

    """

    def __init__(self, least: float, proof: float) -> None:
        self._least, self._proof = least, proof
        self._level = math.nan  # [m]
        self._since = 0  # [ns]

    def is_proven(self, state: FingertipState, now: int, passed: int, still: int) -> bool:
        """Take in ``state``, ``passed`` [ns] after the last; the force has stood for ``still`` [ns]."""
        far, displacement = False, state.displacement
        if displacement == displacement:  # noqa: PLR0124 (NaN is not itself)
            place = displacement if displacement > 0.0 else 0.0
            level = place if still == 0 or math.isnan(self._level) else self._level
            self._level = level + (place - level) * min(passed / NS / TRAVEL_TIME_S, 1.0)
            far = state.normal_force > HELD_N and abs(place - self._level) > self._least
        was_proven = elapsed_time(now, self._since) - passed > self._proof
        if still == 0 or not (was_proven or (far and passed <= self._proof)):  # a silence proves nothing
            self._since = now
        return elapsed_time(now, self._since) > self._proof

    def write_to(self, memory: NamedNumbers) -> None:
        """Put what is known into a memory."""
        memory["WATCH_LEVEL"], memory["INPUT_TRAVEL_SINCE"] = self._level, self._since

    def read_from(self, memory: NamedNumbers) -> None:
        """Take what is known from where :meth:`write_to` puts it."""
        self._level, self._since = memory["WATCH_LEVEL"], int(memory["INPUT_TRAVEL_SINCE"])
