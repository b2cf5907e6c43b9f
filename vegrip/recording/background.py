"""Recording beside a loop that must not wait: a bounded queue and a thread that writes."""

import threading
from collections import deque
from typing import Final

from vegrip.messages import Message
from vegrip.recording.writer import RecordingWriter

CAPACITY: Final = 100_000  # messages; four seconds of five fingers at 500 Hz with all that is said of them
PERIOD: Final = 1.0  # [s] between two writes


class BackgroundWriter:
    """Hands messages to a :class:`RecordingWriter` in a thread; the oldest give way, and are counted."""

    def __init__(self, writer: RecordingWriter, capacity: int = CAPACITY, period: float = PERIOD) -> None:
        self.writer = writer
        self._queue: deque[Message] = deque(maxlen=capacity)
        self._offered = 0  # raised by the loop only
        self._taken = 0  # raised by the writing thread only
        self._period = period
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """Messages that newer ones pushed out before they were written."""
        return max(self._offered - self._taken - len(self._queue), 0)

    def offer(self, message: Message) -> None:
        """Queue ``message``; never waits."""
        self._queue.append(message)
        self._offered += 1

    def close(self) -> None:
        """Write what is left and close the recording."""
        self._stop.set()
        self._thread.join()
        self._drain()
        self.writer.close()

    def _run(self) -> None:
        while not self._stop.wait(self._period):
            self._drain()
            self.writer.flush()

    def _drain(self) -> None:
        for _ in range(len(self._queue)):
            message = self._queue.popleft()
            self._taken += 1
            self.writer.write(message)
