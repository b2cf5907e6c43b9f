"""The share of time for which a bus is busy, over a sliding window."""

from collections import deque

from vegrip.clock import NS


class BusLoad:
    """Sum of frame durations over the last ``window``; memory is bounded by buckets of a twentieth of it."""

    BUCKETS = 20

    def __init__(self, window: float = 1.0, busy: int = 0) -> None:
        self._width = round(window * NS / self.BUCKETS)  # [ns]
        self._buckets: deque[list[int]] = deque(maxlen=self.BUCKETS + 1)  # [number, busy ns]
        self._first: int | None = None  # [ns]
        self._busy = busy  # [ns] of all frames so far

    def add(self, end: int, duration: int) -> None:
        """Count a frame that took ``duration`` [ns] and ended at ``end`` [ns]."""
        if self._first is None:
            self._first = end - duration
        number = end // self._width
        if self._buckets and self._buckets[-1][0] >= number:
            self._buckets[-1][1] += duration
        else:
            self._buckets.append([number, duration])

    def carried(self, end: int, busy: int) -> None:
        """Take note that a frame ended at ``end`` [ns] and all frames so far took ``busy`` [ns]."""
        self.add(end, busy - self._busy)
        self._busy = busy

    def share(self, now: int) -> float:
        """Return the load (0 .. 1) at ``now`` [ns], over the window or since the first frame."""
        if self._first is None:
            return 0.0
        last = now // self._width
        start = max((last - self.BUCKETS) * self._width, self._first)
        elapsed = now - start
        busy = sum(busy for number, busy in self._buckets if number >= last - self.BUCKETS)
        return min(busy / elapsed, 1.0) if elapsed > 0 else 0.0
