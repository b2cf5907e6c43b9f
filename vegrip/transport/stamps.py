"""From the time stamps of a CAN driver to the monotonic clock of this machine."""

import math
import time
from collections.abc import Callable

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
