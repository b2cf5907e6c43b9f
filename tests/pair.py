"""Two endpoints joined back to back in one process: tests, and nodes that share a process."""

from __future__ import annotations

import queue
from collections import Counter
from collections.abc import Mapping, Sequence

from vegrip.clock import NS, Clock, WallClock
from vegrip.messages import Message
from vegrip.transport.endpoint import Endpoint

QUEUE_MESSAGES = 10_000
"""Messages held for a side that does not read; later ones are dropped and counted."""


class PairEndpoint(Endpoint):
    """One side of a :func:`pair`.

    With a clock, waiting is ``clock.sleep_until``: a simulated clock jumps to the end of the time-out and
    nothing ever blocks. Without one the thread waits for the other side.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self._waits_on_clock = clock is not None
        self._clock = clock or WallClock()
        self._inbox: queue.SimpleQueue[Message] = queue.SimpleQueue()
        self._other: PairEndpoint | None = None
        self._rejected: Counter[str] = Counter()
        self.arrivals: Sequence[int] = ()

    @property
    def rejected(self) -> Mapping[str, int]:
        return self._rejected

    def receive(self, timeout: float) -> Sequence[Message]:
        messages = self._drain()
        if not messages and timeout > 0.0:
            messages = self._wait(timeout)
        self.arrivals = [self._clock.now()] * len(messages)
        return messages

    def _wait(self, timeout: float) -> list[Message]:
        if self._waits_on_clock:
            self._clock.sleep_until(self._clock.now() + round(timeout * NS))
            return self._drain()
        try:
            return [self._inbox.get(timeout=timeout), *self._drain()]
        except queue.Empty:
            return []

    def send(self, message: Message) -> None:
        """Put ``message`` before the other side; dropped and counted when it does not read."""
        if self._other is None or self._other._inbox.qsize() >= QUEUE_MESSAGES:
            self._rejected["unsent"] += 1
        else:
            self._other._inbox.put(message)

    def close(self) -> None:
        """Leave the pair; what the other side sends from now on is counted as unsent there."""
        if self._other is not None:
            self._other._other = None
            self._other = None

    def _drain(self) -> list[Message]:
        return [self._inbox.get() for _ in range(self._inbox.qsize())]


def pair(clock: Clock | None = None) -> tuple[PairEndpoint, PairEndpoint]:
    """Return two endpoints; what one sends the other receives."""
    left, right = PairEndpoint(clock), PairEndpoint(clock)
    left._other, right._other = right, left
    return left, right
