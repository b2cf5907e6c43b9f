"""What the nodes of a CAN bus may still do, what goes wrong at them on purpose, and how busy it is."""

from collections import deque
from dataclasses import dataclass
from enum import IntEnum

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.transport.canbus.bus_records import ACTIVE, NOBODY, OFF, PASSIVE


class ErrorState(IntEnum):
    """What a node may still do."""

    ACTIVE = ACTIVE  # signals errors with dominant bits, which all others see
    PASSIVE = PASSIVE  # signals them with recessive bits, and waits 8 bits after each frame of its own
    OFF = OFF  # takes no part in the bus


@dataclass(frozen=True)
class NodeFaults:
    """Faults of one node, by chance that is seeded; the default has none.

    Shares are per frame, or per attempt to send one.
    """

    loss: float = parameter(
        0.0, low=0.0, high=1.0, doc="share of its frames that no node receives, though the bus carries them"
    )
    corruption: float = parameter(
        0.0, low=0.0, high=1.0, doc="share of its attempts in which a bit is disturbed for all nodes"
    )
    misreading: float = parameter(
        0.0, low=0.0, high=1.0, doc="share of others' frames in which this node alone misreads a bit"
    )
    flips: float = parameter(
        0.0,
        low=0.0,
        high=1.0,
        doc="share of its frames with a bit of data wrong that no CRC of the bus catches",
    )
    delay: float = parameter(0.0, unit="s", low=0.0, high=10.0, doc="from sending to asking for the bus")
    jitter: float = parameter(0.0, unit="s", low=0.0, high=10.0, doc="at most added to the delay")
    babble: int = parameter(
        NOBODY, low=NOBODY, high=0x7FF, doc="identifier it sends without pause; -1 = it does not"
    )
    seed: int = parameter(0, low=0, doc="of its chance")


NO_FAULTS = NodeFaults()


class BusLoad:
    """Sum of frame durations over the last second; memory is bounded by buckets of a twentieth of it."""

    BUCKETS = 20
    WIDTH = NS // BUCKETS  # [ns]

    def __init__(self, busy: int = 0) -> None:
        self._buckets: deque[list[int]] = deque(maxlen=self.BUCKETS + 1)  # [number, busy ns]
        self._first: int | None = None  # [ns]
        self._busy = busy  # [ns] of all frames so far

    def add(self, end: int, duration: int) -> None:
        """Count a frame that took ``duration`` [ns] and ended at ``end`` [ns]."""
        if self._first is None:
            self._first = end - duration
        number = end // self.WIDTH
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
        last = now // self.WIDTH
        start = max((last - self.BUCKETS) * self.WIDTH, self._first)
        elapsed = now - start
        busy = sum(busy for number, busy in self._buckets if number >= last - self.BUCKETS)
        return min(busy / elapsed, 1.0) if elapsed > 0 else 0.0
