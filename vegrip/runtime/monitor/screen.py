"""A live screen in a thread of its own: the loop that feeds it never waits for the terminal.

Where there is no terminal it prints lines: what happens, and every second a line for each finger.
"""

import threading
import time
from collections import deque
from collections.abc import Iterable

from rich.console import Console
from rich.live import Live

from vegrip.clock import NS
from vegrip.messages import Message
from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.rows import Present
from vegrip.runtime.monitor.table import finger_lines, log_line, render

QUEUE_MESSAGES = 20_000  # messages between two drawings; the oldest give way
REDRAW_PERIOD_S = 0.1  # [s]
LINE_PERIOD_S = 1.0  # [s] between two lines of a finger


class Screen:
    """Draws what it is offered, from :meth:`open` to :meth:`close`."""

    def __init__(self, title: str, fingers: tuple[str, ...] = (), console: Console | None = None) -> None:
        self.board = Board(time.monotonic_ns(), fingers)  # belongs to the thread once it runs
        self._title, self._console = title, console or Console()
        self._queue: deque[tuple[Message | tuple[Present, ...], int, str]] = deque(maxlen=QUEUE_MESSAGES)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def take(self, message: Message, now: int, node: str = "") -> None:
        """Queue ``message`` that came at ``now`` [ns] from ``node``; never waits."""
        self._queue.append((message, now, node))

    def attend(self, present: Iterable[Present], now: int) -> None:
        """Queue which nodes run on this machine at ``now`` [ns]; never waits."""
        self._queue.append((tuple(present), now, ""))

    def open(self) -> None:
        self._thread = threading.Thread(target=self._run, name="screen", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        if not self._console.is_terminal:
            self._print_lines()
            return
        with Live(console=self._console, auto_refresh=False) as live:
            while not self._stop.wait(REDRAW_PERIOD_S):
                self._draw(live)
            self._draw(live)

    def _draw(self, live: Live) -> None:
        now = self._look()
        live.update(render(self.board, now, self._title, size=self._console.size), refresh=True)

    def _print_lines(self) -> None:
        due, told, fingers = self.board.start, 0, [""]
        while not self._stop.wait(REDRAW_PERIOD_S):
            now = self._look()
            news, told = self.board.said - told, self.board.said
            lines = [str(log_line(line)) for line in list(self.board.log)[-news:]] if news else []
            before = fingers
            if now >= due and (fingers := finger_lines(self.board, now)) != before:
                due = now + round(LINE_PERIOD_S * NS)
                lines += fingers
            for line in lines:
                self._console.print(line, soft_wrap=True, markup=False, highlight=False)

    def _look(self) -> int:
        """Put on the board what has come, and return the time [ns]."""
        for _ in range(len(self._queue)):
            news, then, node = self._queue.popleft()
            if isinstance(news, tuple):
                self.board.attend(news, then)
            else:
                self.board.take(news, then, node)
        now = time.monotonic_ns()
        self.board.look(now)
        return now
