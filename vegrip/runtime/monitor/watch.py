"""Watch running nodes through their telemetry, whatever their transport is, as they come and go."""

import threading
import time
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Protocol

from rich.console import Console
from rich.live import Live

from vegrip.clock import NS
from vegrip.errors import UsageError
from vegrip.messages import (
    OF_NODES,
    ContactEstimate,
    DeviceReport,
    FingertipState,
    ForceCommand,
    Message,
    ModelHealth,
    NodeStatus,
    SlipMargin,
)
from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.rows import Present
from vegrip.runtime.monitor.table import finger_lines, log_line, render
from vegrip.runtime.registry import Entry, read_reports, running_nodes
from vegrip.runtime.telemetry_socket import NEWEST, TelemetryReader
from vegrip.transport.codec.msgpack_codec import MsgpackCodec

WATCHED_MESSAGES = (ContactEstimate, SlipMargin, ForceCommand, ModelHealth, DeviceReport)
"""What a table asks for. Not the states: at 500 Hz each they would cost the node more than they show here."""

TELEMETRY_WAIT_S = 0.05  # [s] of one look at the telemetry
REGISTRY_PERIOD = 0.2  # [s] between two looks at who runs


class Sink(Protocol):
    """Takes the messages: a :class:`~vegrip.runtime.monitor.board.Board`, or the screen in front of one."""

    def receive(self, message: Message, now: int, node: str = "") -> None:
        """Take a message that came at ``now`` [ns] from ``node``."""

    def attend(self, present: Iterable[Present], now: int) -> None:
        """Take note of which nodes run on this machine."""


class Watch:
    """Receives from all nodes of this machine; fingers carry their namespace."""

    def __init__(
        self,
        every: Sequence[type[Message]] = WATCHED_MESSAGES,
        newest: Sequence[
            type[Message]
        ] = (),  # alone, of nodes that send margins; states as they receive them
        *,
        waits: bool = False,  # begin without any node
    ) -> None:
        if not waits and not running_nodes():
            raise UsageError("no node runs; start one with `vegrip launch demo`")
        self._every, self._newest = every, newest
        self._reader = TelemetryReader(())
        self._connected: set[str] = set()
        self._estimating: set[str] = set()
        self._due = 0.0

    def run(self, sink: Sink, duration: float = 0.0) -> None:
        """Give ``sink`` what the nodes say until ``duration`` [s] has passed; 0 = for ever."""
        ends = time.monotonic() + duration if duration > 0.0 else None
        while ends is None or time.monotonic() < ends:
            self.step(sink)

    def step(self, sink: Sink) -> None:
        """Look once at which nodes run, if that is due, and at their messages."""
        if time.monotonic() >= self._due:
            self._due = time.monotonic() + REGISTRY_PERIOD
            self._attend(sink)
        for entry, _, direction, message in self._reader.read(TELEMETRY_WAIT_S):
            if direction == "out" or isinstance(message, (FingertipState, DeviceReport)):
                sink.receive(_named(message, entry.namespace), time.monotonic_ns(), entry.name)
            estimates = isinstance(message, SlipMargin) and direction == "out"
            if estimates and self._newest and entry.name not in self._estimating:
                self._estimating.add(entry.name)
                self._reader.add(entry, [NEWEST + topic for topic in _Topics(entry).of(self._newest)])

    def close(self) -> None:
        self._reader.close()

    def _attend(self, sink: Sink) -> None:
        entries = running_nodes()
        for entry in entries:
            if entry.name not in self._connected:
                self._connected.add(entry.name)
                topics = _Topics(entry)
                self._reader.add(entry, [*topics.of(self._every), *topics.status()])
        failed = [Present(name, failure=report.reason) for name, report in read_reports().items()]
        sink.attend([*failed, *map(_present, entries)], time.monotonic_ns())


class _Topics:
    def __init__(self, entry: Entry) -> None:
        self._entry = entry
        self._topics = MsgpackCodec(entry.namespace, remap=entry.remap).topics

    def of(self, kinds: Sequence[type[Message]]) -> list[str]:
        routes = [self._topics.outgoing(kind, finger) for kind in kinds for finger in self._entry.fingers]
        return [route.topic for route in routes if route is not None]

    def status(self) -> list[str]:
        route = self._topics.outgoing(NodeStatus, self._entry.name)
        return [route.topic] if route is not None else []


def _present(entry: Entry) -> Present:
    fingers = tuple(_in_namespace(finger, entry.namespace) for finger in entry.fingers)
    return Present(entry.name, entry.pid, entry.status_period, fingers)


def _named(message: Message, namespace: str) -> Message:
    if isinstance(message, OF_NODES):
        return message
    return replace(message, finger=_in_namespace(message.finger, namespace))


def _in_namespace(finger: str, namespace: str) -> str:
    return f"{namespace}/{finger}" if namespace else finger


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

    def receive(self, message: Message, now: int, node: str = "") -> None:
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
        now = self._refresh()
        live.update(render(self.board, now, self._title, size=self._console.size), refresh=True)

    def _print_lines(self) -> None:
        due, counted, fingers = self.board.start, 0, [""]
        while not self._stop.wait(REDRAW_PERIOD_S):
            now = self._refresh()
            news, counted = self.board.said - counted, self.board.said
            lines = [str(log_line(line)) for line in list(self.board.log)[-news:]] if news else []
            before = fingers
            if now >= due and (fingers := finger_lines(self.board, now)) != before:
                due = now + round(LINE_PERIOD_S * NS)
                lines += fingers
            for line in lines:
                self._console.print(line, soft_wrap=True, markup=False, highlight=False)

    def _refresh(self) -> int:
        for _ in range(len(self._queue)):
            news, then, node = self._queue.popleft()
            if isinstance(news, Message):
                self.board.receive(news, then, node)
            else:
                self.board.attend(news, then)
        now = time.monotonic_ns()
        self.board.refresh(now)
        return now
