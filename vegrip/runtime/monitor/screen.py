"""A live screen in a thread of its own: the loop that feeds it never waits for the terminal."""

import threading
import time
from collections import deque
from collections.abc import Iterable

from rich.console import Console
from rich.live import Live

from vegrip.messages import Message
from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.node_row import Present
from vegrip.runtime.monitor.table import render

CAPACITY = 20_000  # messages between two drawings; the oldest give way
PERIOD = 0.1  # [s]


class Screen:
    """Draws what it is offered, from :meth:`open` to :meth:`close`."""

    def __init__(self, title: str, fingers: tuple[str, ...] = (), console: Console | None = None) -> None:
        self.board = Board(time.monotonic_ns(), fingers)  # belongs to the thread once it runs
        self._title, self._console = title, console or Console()
        self._queue: deque[tuple[Message | tuple[Present, ...], int, str]] = deque(maxlen=CAPACITY)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def take(self, message: Message, now: int, node: str = "") -> None:
        """Queue ``message`` that came at ``now`` [ns] from ``node``; never waits."""
        self._queue.append((message, now, node))

    def attend(self, present: Iterable[Present], now: int) -> None:
        """Queue which nodes run on this machine at ``now`` [ns]; never waits."""
        self._queue.append((tuple(present), now, ""))

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
            news, then, node = self._queue.popleft()
            if isinstance(news, tuple):
                self.board.attend(news, then)
            else:
                self.board.take(news, then, node)
        now = time.monotonic_ns()
        self.board.look(now)
        live.update(render(self.board, now, self._title, size=self._console.size), refresh=True)
