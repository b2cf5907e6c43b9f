"""Recording beside a loop that must not wait: a bounded queue and a thread that writes."""

import contextlib
import os
import sys
import threading
import time
from collections import deque
from typing import Final

from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import Message

CAPACITY: Final = 100_000  # messages; four seconds of five fingers at 500 Hz with all that is said of them
PERIOD: Final = 0.05  # [s] between two looks at the queue; what gathers in a second takes a core for a while
FLUSH: Final = 1.0  # [s] between two flushes: the most that a power cut costs
NICENESS: Final = 10  # of the writing thread: the loops of a hand on the same machine come first


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
        self.writer.dropped = self.dropped
        self.writer.close()

    def _run(self) -> None:
        if sys.platform == "linux":  # elsewhere this is the priority of the whole process
            with contextlib.suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
        due = 0.0
        while not self._stop.wait(self._period):
            self._drain()
            if time.monotonic() >= due:
                due = time.monotonic() + FLUSH
                self.writer.flush()

    def _drain(self) -> None:
        for _ in range(len(self._queue)):
            message = self._queue.popleft()
            self._taken += 1
            self.writer.write(message)
