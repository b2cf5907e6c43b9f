"""Logs of a node: named, written by a thread of their own, and at most one a second per source line."""

import logging
import queue
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from logging.handlers import QueueHandler, QueueListener

PERIOD = 1.0  # [s]
MOST_LINES = 1024  # source lines remembered


class OncePerSecond(logging.Filter):
    """Lets one record of a source line through per ``PERIOD``, with the number of those held back."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._now = now
        self._lines: dict[tuple[str, int], tuple[float, int]] = {}  # (when let through, how many not since)

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether ``record`` is to be written."""
        line, now = (record.pathname, record.lineno), self._now()
        last, suppressed = self._lines.get(line, (-PERIOD, 0))
        if now - last < PERIOD:
            self._lines[line] = (last, suppressed + 1)
            return False
        if line in self._lines or len(self._lines) < MOST_LINES:
            self._lines[line] = (now, 0)
        if suppressed:
            record.msg = f"{record.msg} ({suppressed} more like this in the last second)"
        return True


@contextmanager
def node_logs(name: str, level: int = logging.INFO) -> Iterator[None]:
    """Write the logs of this process to standard error under ``name``, without making the loop wait."""
    records: queue.SimpleQueue[logging.LogRecord] = queue.SimpleQueue()
    writer = logging.StreamHandler()
    writer.setFormatter(logging.Formatter(f"%(levelname)s {name}: %(message)s"))
    listener = QueueListener(records, writer)
    handler = QueueHandler(records)
    handler.addFilter(OncePerSecond())
    root = logging.getLogger()
    before = root.level
    root.addHandler(handler)
    root.setLevel(logging.WARNING)
    logging.getLogger("vegrip").setLevel(level)
    listener.start()
    try:
        yield
    finally:
        root.removeHandler(handler)
        root.setLevel(before)
        listener.stop()
