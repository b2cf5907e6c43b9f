"""Clocks: integer nanoseconds, monotonic; the simulated one makes tests and replays run without waiting."""

import time
from typing import Protocol

NS = 1_000_000_000
"""Nanoseconds in a second."""
NOT_YET = -(1 << 62)
"""[ns] Before all that comes or is sent."""


class Clock(Protocol):
    """What a loop needs from time."""

    def now(self) -> int:
        """Return the present time in nanoseconds; never runs backwards."""

    def sleep_until(self, deadline: int) -> None:
        """Return at ``deadline`` [ns], at once when it has passed."""


class WallClock:
    """The monotonic clock of this machine (``CLOCK_MONOTONIC``: the same in all its processes)."""

    def now(self) -> int:
        return time.monotonic_ns()

    def sleep_until(self, deadline: int) -> None:
        """Sleep until ``deadline`` [ns]."""
        remaining = deadline - time.monotonic_ns()
        if remaining > 0:
            time.sleep(remaining / NS)


class SimulatedClock:
    """A clock that moves only when asked to; sleeping is instantaneous."""

    def __init__(self, start: int = 0) -> None:
        self._now = start

    def now(self) -> int:
        return self._now

    def sleep_until(self, deadline: int) -> None:
        """Jump to ``deadline`` [ns]; a deadline in the past leaves the clock as it is."""
        self._now = max(self._now, deadline)

    def advance(self, seconds: float) -> None:
        self._now += round(seconds * NS)
