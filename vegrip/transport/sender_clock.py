"""How the clock of a sender runs against ours, from nothing but the stamps of what it sends.

What arrives at ``a`` with the sender's stamp ``s`` shows a delay ``d = a - s``: the offset of the clocks, and
the time on the way, which is never less than its least. The line under all delays that comes closest to them
on the average [MoonSkellyTowsley1999]_,

    min over (alpha, beta) of  sum of (d_i - alpha - beta s_i)   with   d_i >= alpha + beta s_i ,

is the edge of their lower convex hull above the mean of the ``s_i``; ``beta`` is the drift of the clocks.
What lies above the line is jitter. The time that even the quickest message takes cannot be distinguished from
an offset [Cristian1989]_: it counts as part of it.
"""

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from vegrip.clock import NS

EPOCH_WITHIN = 3600 * NS  # [ns] a stamp so near to the wall clock counts from 1970
OFFSET_REFRESH_NS = (
    1 * NS
)  # [ns] between two looks at the offset of the wall clock, which may be slewed or set
OLDEST = 1 * NS  # [ns] a stamp further back than this is not believed
OFFSET_RISE_SHARE = (
    0.001  # share of the excess by which the offset of a free-running clock is raised per frame
)


class StampMap:
    """Maps the stamps of one driver; it recognises three kinds by their values.

    * seconds since 1970 (SocketCAN, most others): the offset of the wall clock, read once a second;
    * seconds of a clock of the device: the smallest delay seen is taken as no delay [Cristian1989]_, and
      forgotten slowly, because the two clocks drift;
    * zero or NaN: no stamp, the time of arrival counts.

    No stamp lies after its arrival, and none more than ``OLDEST`` before it.
    """

    def __init__(
        self, now: Callable[[], int] = time.monotonic_ns, wall: Callable[[], int] = time.time_ns
    ) -> None:
        self._now, self._wall = now, wall
        self._wall_offset, self._read_at = 0, -OFFSET_REFRESH_NS  # [ns] monotonic minus wall
        self._device_offset: float | None = None  # [ns] monotonic minus device

    def to_monotonic(self, stamp: float) -> int:
        """Return the monotonic time [ns] of a driver's ``stamp`` [s]."""
        arrival = self._now()
        if not math.isfinite(stamp) or stamp <= 0.0:
            return arrival
        device = round(stamp * NS)
        if arrival - self._read_at >= OFFSET_REFRESH_NS:
            self._wall_offset, self._read_at = arrival - self._wall(), arrival
        time_of_frame = device + self._wall_offset
        if abs(time_of_frame - arrival) > EPOCH_WITHIN:
            time_of_frame = device + self._free_running(arrival - device)
        return time_of_frame if arrival - OLDEST <= time_of_frame <= arrival else arrival

    def _free_running(self, delay: int) -> int:
        offset = self._device_offset
        if (
            offset is None or delay < offset or delay - offset > OLDEST
        ):  # first, faster, or the clock was reset
            offset = float(delay)
        self._device_offset = offset + OFFSET_RISE_SHARE * (delay - offset)
        return math.floor(offset)


BUCKET: Final = NS // 4  # [ns] of each only the quickest message is kept
BUCKETS: Final = 64  # sixteen seconds
MIN_DRIFT_BUCKETS: Final = 8  # buckets before the drift is believed
FASTEST_DRIFT: Final = 500e-6  # [-] quartz clocks keep within; more is noise
JUMP: Final = NS  # [ns] a delay so far from the line is a clock that was set


@dataclass(frozen=True, slots=True)
class ClockEstimate:
    """The sender's clock against ours."""

    offset: float  # [s] ours minus theirs, now; NaN: nothing has come
    drift: float  # [-] how fast the offset grows
    jitter: float  # [s] root mean square of what messages take beyond the quickest
    worst: float  # [s] most of it
    jumps: int  # how often their clock was set


class _Bucket:
    __slots__ = ("count", "delay", "number", "squares", "stamp", "worst")

    def __init__(self, number: int, stamp: int, delay: int) -> None:
        self.number, self.stamp, self.delay = number, stamp, delay
        self.count, self.worst, self.squares = 0, 0.0, 0.0


class SenderClock:
    """The clock of one sender; each quarter of a second the line is laid anew."""

    def __init__(self) -> None:
        self.jumps = 0
        self._forget()

    def observe(self, stamp: int, arrival: int) -> int:
        """Take a message stamped ``stamp`` that came at ``arrival`` [ns]; return its time on our clock.

        Never later than ``arrival``.
        """
        delay = arrival - stamp
        if self._buckets and abs(delay - self._line(stamp)) > JUMP:
            self.jumps += 1
            self._forget()
        bucket = self._bucket(stamp, delay)
        if delay < bucket.delay:
            bucket.stamp, bucket.delay = stamp, delay
        excess = max(0.0, delay - self._line(stamp)) / NS
        bucket.count += 1
        bucket.squares += excess * excess
        bucket.worst = max(bucket.worst, excess)
        return min(stamp + math.floor(min(self._line(stamp), bucket.delay)), arrival)

    def estimate(self) -> ClockEstimate:
        count = sum(bucket.count for bucket in self._buckets)
        if not count:
            return ClockEstimate(math.nan, 0.0, math.nan, math.nan, self.jumps)
        squares = sum(bucket.squares for bucket in self._buckets)
        worst = max(bucket.worst for bucket in self._buckets)
        offset = self._line(self._buckets[-1].stamp) / NS
        return ClockEstimate(offset, self._beta, math.sqrt(squares / count), worst, self.jumps)

    def _forget(self) -> None:
        self._buckets: deque[_Bucket] = deque(maxlen=BUCKETS)
        self._at, self._alpha, self._beta = 0, 0.0, 0.0  # the line: alpha [ns] at the stamp _at, slope beta

    def _bucket(self, stamp: int, delay: int) -> _Bucket:
        number = stamp // BUCKET
        if not self._buckets:
            self._at, self._alpha = stamp, float(delay)
        if not self._buckets or number > self._buckets[-1].number:
            if self._buckets:
                self._lay_line()
            self._buckets.append(_Bucket(number, stamp, delay))
        return self._buckets[-1]

    def _line(self, stamp: int) -> float:
        return self._alpha + self._beta * (stamp - self._at)

    def _lay_line(self) -> None:
        points = [(bucket.stamp, bucket.delay) for bucket in self._buckets]
        if len(points) < MIN_DRIFT_BUCKETS:
            self._at, self._alpha = min(points, key=lambda point: point[1])
            return
        mean = sum(stamp for stamp, _ in points) / len(points)
        left, right = _edge_above(_lower_hull(points), mean)
        slope = (right[1] - left[1]) / (right[0] - left[0])
        self._beta = min(max(slope, -FASTEST_DRIFT), FASTEST_DRIFT)
        self._at, self._alpha = left[0], float(left[1])


Point = tuple[int, int]


def _lower_hull(points: list[Point]) -> list[Point]:
    """Return the lower convex hull of ``points``, which are in the order of their first coordinate."""
    hull: list[Point] = []
    for point in points:
        while len(hull) > 1 and _turns_down(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    return hull


def _turns_down(a: Point, b: Point, c: Point) -> bool:
    return (b[1] - a[1]) * (c[0] - a[0]) >= (c[1] - a[1]) * (b[0] - a[0])


def _edge_above(hull: list[Point], mean: float) -> tuple[Point, Point]:
    for left, right in pairwise(hull):
        if right[0] >= mean:
            return left, right
    return hull[-2], hull[-1]
