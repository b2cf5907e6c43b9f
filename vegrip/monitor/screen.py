"""A live screen in a thread of its own: the loop that feeds it never waits for the terminal."""

import threading
import time
from collections import deque

from rich.console import Console
from rich.live import Live

from vegrip.messages import Message
from vegrip.monitor.board import Board
from vegrip.monitor.table import render

CAPACITY = 20_000  # messages between two drawings; the oldest give way
PERIOD = 0.1  # [s]


class Screen:
    """Draws what it is offered, from :meth:`open` to :meth:`close`."""

    def __init__(self, title: str, fingers: tuple[str, ...] = (), console: Console | None = None) -> None:
        self.board = Board(time.monotonic_ns(), fingers)  # belongs to the thread once it runs
        self._title, self._console = title, console or Console()
        self._queue: deque[tuple[Message, int]] = deque(maxlen=CAPACITY)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def offer(self, message: Message, now: int) -> None:
        """Queue ``message`` that came at ``now`` [ns]; never waits."""
        self._queue.append((message, now))

    def open(self) -> None:
        """Begin to draw."""
        self._thread = threading.Thread(target=self._run, name="screen", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Draw once more and end."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        with Live(console=self._console, auto_refresh=False) as live:
            while not self._stop.wait(PERIOD):
                self._draw(live)
            self._draw(live)

    def _draw(self, live: Live) -> None:
        for _ in range(len(self._queue)):
            message, now = self._queue.popleft()
            self.board.take(message, now)
        live.update(render(self.board, time.monotonic_ns(), self._title), refresh=True)
