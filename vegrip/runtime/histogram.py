"""A histogram of durations: fixed size, relative resolution of 3 %, cheap enough for the loop."""

from collections.abc import Iterable
from itertools import accumulate

_SUB = 5  # 2^5 linear buckets per octave: a bucket is at most 1/32 of its value wide
_OCTAVES = 35
SIZE = (_OCTAVES + 1) << _SUB
LONGEST = (1 << (_OCTAVES + _SUB)) - 1
"""Longest duration told apart, 1100 s in nanoseconds; longer ones count as this."""


class Histogram:
    """Counts of durations [ns]. Memory is allocated once; ``add`` allocates nothing."""

    def __init__(self) -> None:
        self._counts = [0] * SIZE
        self.count = 0
        self.maximum = 0  # [ns] exact

    def add(self, duration: int) -> None:
        """Count one ``duration`` [ns]; a negative one counts as zero."""
        if duration < 0:  # comparisons, because this runs twice for every command: min and max cost more
            duration = 0
        elif duration > LONGEST:
            duration = LONGEST
        self._counts[_bucket(duration)] += 1
        self.count += 1
        if duration > self.maximum:  # noqa: PLR1730
            self.maximum = duration

    def add_equal(self, duration: int, times: int) -> None:
        """Count ``duration`` [ns] several ``times``."""
        duration = min(max(duration, 0), LONGEST)
        self._counts[_bucket(duration)] += times
        self.count += times
        self.maximum = max(self.maximum, duration)

    def percentile(self, share: float) -> float:
        """Return the duration [ns] that a ``share`` (0 .. 1) of all does not exceed; NaN when empty.

        The upper edge of the bucket is returned, so that it is never too small.
        """
        if not self.count:
            return float("nan")
        wanted = share * self.count
        for bucket, below in enumerate(accumulate(self._counts)):
            if below >= wanted and below:
                return float(min(_upper_edge(bucket), self.maximum))
        return float(self.maximum)

    @classmethod
    def sum_of(cls, parts: Iterable["Histogram"]) -> "Histogram":
        """Return a histogram of all that ``parts`` have counted."""
        total = cls()
        for part in parts:
            total._counts = [a + b for a, b in zip(total._counts, part._counts, strict=True)]
            total.count += part.count
            total.maximum = max(total.maximum, part.maximum)
        return total

    def clear(self) -> None:
        for bucket in range(SIZE):
            self._counts[bucket] = 0
        self.count = self.maximum = 0


def _bucket(duration: int) -> int:
    octave = duration.bit_length() - _SUB - 1
    if octave <= 0:
        return duration
    return (octave << _SUB) + (duration >> octave)


def _upper_edge(bucket: int) -> int:
    octave = max((bucket >> _SUB) - 1, 0)
    mantissa = bucket - (octave << _SUB)
    return ((mantissa + 1) << octave) - 1
