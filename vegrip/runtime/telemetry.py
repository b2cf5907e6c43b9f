"""Telemetry: what a node receives and sends, on a bounded queue that drops the oldest and counts.

The loop only counts, and appends to a deque, which takes no lock, what subscribers want. A thread of its own
empties the deque and hands it to a sink; it looks every few milliseconds instead of being woken, because
waking would need a lock. It looks seldom while nothing comes, and more seldom while there is no subscriber: a
thread that shares the interpreter more often delays the commands by a quarter of their latency.
"""

import threading
from collections import deque
from collections.abc import Sequence
from enum import Enum
from typing import Protocol

from vegrip.messages import Message

QUEUE_MESSAGES = 4096  # messages; a second of five fingers at 500 Hz with one answer each
LOOK_PERIOD_S = 0.01  # [s] between two looks
QUIET_PERIOD_S = 0.02  # [s] the same after a look that found nothing
IDLE = 0.05  # [s] the same while no subscriber wants messages


class Direction(Enum):
    """Whether the node received a message or sent it."""

    IN = "in"
    OUT = "out"


class Sink(Protocol):
    """Where telemetry goes: :class:`~vegrip.runtime.telemetry_socket.TelemetrySocket`, which documents it."""

    wanted: bool

    def count(self, message: Message, direction: Direction) -> None: ...
    def tally(self, kind: type[Message], owner: str, direction: Direction) -> None: ...
    def wants(self, kind: type[Message], owner: str, direction: Direction) -> bool: ...
    def takes(self, message: Message, direction: Direction) -> bool: ...
    def publish(self, messages: Sequence[tuple[Message, Direction]]) -> None: ...
    def listen(self) -> None: ...
    def close(self) -> None: ...


class Telemetry:
    """The queue and its thread. Without :meth:`start` it only keeps the newest messages."""

    def __init__(self, sink: Sink, capacity: int = QUEUE_MESSAGES) -> None:
        self._queue: deque[tuple[Message, Direction]] = deque(maxlen=capacity)
        self._offered = 0  # raised by the loop only
        self._taken = 0  # raised by the thread only
        self._sink = sink
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def dropped(self) -> int:
        return max(self._offered - self._taken - len(self._queue), 0)

    def offer(self, message: Message, direction: Direction) -> None:
        """Count ``message``, and queue it if it is wanted; never waits, the oldest is dropped."""
        self._sink.count(message, direction)
        if self._sink.wanted:
            self._put(message, direction)

    def wants(self, kind: type[Message], owner: str, direction: Direction) -> bool:
        return self._sink.wanted and self._sink.wants(kind, owner, direction)

    def count(self, kind: type[Message], owner: str, direction: Direction) -> bool:
        """Count a message of a finger or node that travelled unmade; return whether it is to be shown."""
        self._sink.tally(kind, owner, direction)
        return self.wants(kind, owner, direction)

    def show(self, message: Message, direction: Direction) -> None:
        self._put(message, direction)

    def _put(self, message: Message, direction: Direction) -> None:
        if self._sink.takes(message, direction):
            self._queue.append((message, direction))
            self._offered += 1

    def drain(self) -> bool:
        """Hand everything queued to the sink; return whether there was anything."""
        found = bool(self._queue)
        while self._queue:
            gathered = [self._queue.popleft() for _ in range(len(self._queue))]
            self._taken += len(gathered)
            self._sink.publish(gathered)
        return found

    def start(self) -> None:
        self._thread = threading.Thread(target=self._run, name="telemetry", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        self.drain()
        self._sink.close()

    def _run(self) -> None:
        period = IDLE
        while not self._stop.wait(period):
            self._sink.listen()
            found = self.drain()
            period = LOOK_PERIOD_S if found else QUIET_PERIOD_S if self._sink.wanted else IDLE
