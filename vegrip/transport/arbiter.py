"""Who may send when on a CAN bus: arbitration by identifier, one frame at a time. Pure: time comes in.

Each node sends its own frames in the order it queued them, as a SocketCAN transmit queue does; among the
first frames of all nodes the lowest arbitration field wins.
"""

from collections import deque
from typing import NamedTuple

from vegrip.transport.frame_time import BitTiming, BusFrame, frame_duration


class Transmission(NamedTuple):
    """One frame on the bus."""

    start: int  # [ns]
    end: int  # [ns] the bus is free again and every node has the frame
    node: int
    frame: BusFrame


class Arbiter:
    """The order and the times of frames on one bus.

    A request may come in late, as long as those of one node are in order: when the bus has been given away
    for its time already, it waits until the bus is free.
    """

    def __init__(self, timing: BitTiming) -> None:
        self.timing = timing
        self._queues: dict[int, deque[tuple[int, BusFrame]]] = {}
        self._free = 0  # [ns] when the bus is (or was) free
        self._current: Transmission | None = None

    def request(self, time: int, node: int, frame: BusFrame) -> None:
        """Queue ``frame`` of ``node`` at ``time`` [ns]."""
        self._queues.setdefault(node, deque()).append((time, frame))

    def advance(self, now: int) -> list[Transmission]:
        """Let time pass up to ``now`` [ns] and return the frames that were finished, in order."""
        finished = []
        while (current := self._begin(now)) is not None and current.end <= now:
            finished.append(current)
            self._current = None
        return finished

    def next_event(self) -> int | None:
        """Return when :meth:`advance` will have something to do [ns]; None: not before the next request."""
        if self._current is not None:
            return self._current.end
        return self._next_start()

    def _begin(self, now: int) -> Transmission | None:
        """Return the frame on the bus, having put the next one there if its time has come."""
        if self._current is None and (start := self._next_start()) is not None and start <= now:
            node = min(
                (node for node, queue in self._queues.items() if queue[0][0] <= start),
                key=lambda node: (self._queues[node][0][1].arbitration_key, node),
            )
            frame = self._take(node)
            self._free = start + frame_duration(frame, self.timing)
            self._current = Transmission(start, self._free, node, frame)
        return self._current

    def _next_start(self) -> int | None:
        if not self._queues:
            return None
        return max(self._free, min(queue[0][0] for queue in self._queues.values()))

    def _take(self, node: int) -> BusFrame:
        queue = self._queues[node]
        frame = queue.popleft()[1]
        if not queue:
            del self._queues[node]
        return frame
