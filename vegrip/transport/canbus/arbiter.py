"""Who may send when on a CAN bus: arbitration by identifier. Pure: time comes in.

Each node sends its own frames in the order it queued them, as a SocketCAN transmit queue does; among the
first frames of all nodes the lowest arbitration field wins.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from vegrip.transport.canbus.frame_time import BusFrame


class _Request(NamedTuple):
    time: int  # [ns]
    key: int  # of arbitration; the lower one wins
    frame: BusFrame


class Arbiter:
    """The frames that wait, and which of them comes next.

    A request may come in late, as long as those of one node are in order: when the bus has been given away
    for its time already, it waits until the bus is free.
    """

    def __init__(self) -> None:
        self._queues: dict[int, deque[_Request]] = {}  # only those with a frame
        self._suspended: dict[int, int] = {}  # [ns] until when a node may not begin

    def request(self, time: int, node: int, frame: BusFrame) -> None:
        """Queue ``frame`` of ``node`` at ``time`` [ns]."""
        queue = self._queues.get(node)
        if queue is None:
            queue = self._queues[node] = deque()
        queue.append(_Request(time, frame.arbitration_key, frame))

    def suspend(self, node: int, until: int) -> None:
        """Let ``node`` begin no frame before ``until`` [ns]."""
        self._suspended[node] = until

    def waiting(self, node: int) -> int:
        """Return how many frames of ``node`` wait."""
        queue = self._queues.get(node)
        return len(queue) if queue else 0

    @property
    def queued(self) -> int:
        """How many frames wait."""
        return sum(map(len, self._queues.values()))

    def next_start(self, free: int) -> int | None:
        """Return when the next frame begins if the bus is free from ``free`` [ns] on; None: none waits."""
        earliest: int | None = None
        for node in self._queues:
            ready = self._ready(node)
            if ready <= free:
                return free
            if earliest is None or ready < earliest:
                earliest = ready
        return earliest

    def winner(self, start: int) -> tuple[int, BusFrame]:
        """Return the node that wins the bus at ``start`` [ns], and its frame, which stays in the queue."""
        _, node = min(
            [(queue[0].key, node) for node, queue in self._queues.items() if self._ready(node) <= start]
        )
        return node, self._queues[node][0].frame

    def done(self, node: int) -> None:
        """Take the first frame of ``node`` out: it was sent."""
        queue = self._queues[node]
        queue.popleft()
        if not queue:
            del self._queues[node]

    def drop(self, node: int) -> int:
        """Forget the frames of ``node``; return how many there were."""
        self._suspended.pop(node, None)
        return len(self._queues.pop(node, ()))

    def resume(self) -> None:
        """Forget the suspensions: another node has begun a frame."""
        self._suspended.clear()

    def queues(self) -> dict[int, list[tuple[int, BusFrame]]] | None:
        """Return times and frames that wait, by node; None while a node is suspended."""
        if self._suspended:
            return None
        return {node: [(one.time, one.frame) for one in queue] for node, queue in self._queues.items()}

    def restore(self, queues: Mapping[int, Sequence[tuple[int, BusFrame]]]) -> None:
        """Let exactly the frames of ``queues`` wait."""
        self._queues.clear()
        for node, queue in queues.items():
            for time, frame in queue:
                self.request(time, node, frame)

    def _ready(self, node: int) -> int:
        time = self._queues[node][0].time
        return max(time, self._suspended[node]) if node in self._suspended else time
