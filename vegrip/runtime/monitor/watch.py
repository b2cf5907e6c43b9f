"""Watch running nodes through their telemetry, whatever their transport is, as they come and go."""

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Protocol

from vegrip.errors import UsageError
from vegrip.messages import (
    ContactEstimate,
    FingertipState,
    ForceCommand,
    Message,
    ModelHealth,
    NodeStatus,
    SlipMargin,
)
from vegrip.runtime.exit_reports import read_reports
from vegrip.runtime.monitor.rows import Present
from vegrip.runtime.registry import Entry, running_nodes
from vegrip.runtime.telemetry_socket import NEWEST, TelemetryReader
from vegrip.transport.codec.msgpack_codec import MsgpackCodec

WATCHED_MESSAGES = (ContactEstimate, SlipMargin, ForceCommand, ModelHealth)
"""What a table asks for. Not the states: at 500 Hz each they would cost the node more than they show here."""

TELEMETRY_WAIT_S = 0.05  # [s] of one look at the telemetry
REGISTRY_PERIOD = 0.2  # [s] between two looks at who runs


class Sink(Protocol):
    """Takes the messages: a :class:`~vegrip.runtime.monitor.board.Board`, or the screen in front of one."""

    def take(self, message: Message, now: int, node: str = "") -> None:
        """Take a message that came at ``now`` [ns] from ``node``."""

    def attend(self, present: Iterable[Present], now: int) -> None:
        """Take note of which nodes run on this machine."""


class Watch:
    """Hears all nodes of this machine; fingers carry their namespace.

    Args:
        every: what is asked for of all nodes.
        newest: of which the newest messages are enough, of nodes that send margins; a FingertipState is one
            that the node has received.
        waits: whether to begin without any node.

    Raises:
        UsageError: no node runs.

    """

    def __init__(
        self,
        every: Sequence[type[Message]] = WATCHED_MESSAGES,
        newest: Sequence[type[Message]] = (),
        *,
        waits: bool = False,
    ) -> None:
        if not waits and not running_nodes():
            raise UsageError("no node runs; start one with `vegrip launch demo`")
        self._every, self._newest = every, newest
        self._reader = TelemetryReader(())
        self._connected: set[str] = set()
        self._estimating: set[str] = set()
        self._due = 0.0

    def run(self, sink: Sink, duration: float = 0.0) -> None:
        """Tell ``sink`` what the nodes say until ``duration`` [s] has passed; 0 = for ever."""
        ends = time.monotonic() + duration if duration > 0.0 else None
        while ends is None or time.monotonic() < ends:
            self.step(sink)

    def step(self, sink: Sink) -> None:
        """Look once at which nodes run, if that is due, and at their messages."""
        if time.monotonic() >= self._due:
            self._due = time.monotonic() + REGISTRY_PERIOD
            self._attend(sink)
        for entry, _, direction, message in self._reader.read(TELEMETRY_WAIT_S):
            if direction == "out" or isinstance(message, FingertipState):
                sink.take(_named(message, entry.namespace), time.monotonic_ns(), entry.name)
            if isinstance(message, SlipMargin) and direction == "out":
                self._ask_for_newest(entry)

    def close(self) -> None:
        self._reader.close()

    def _ask_for_newest(self, entry: Entry) -> None:
        if self._newest and entry.name not in self._estimating:
            self._estimating.add(entry.name)
            self._reader.add(entry, [NEWEST + topic for topic in _Topics(entry).of(self._newest)])

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
    """The topics of one node."""

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
    if isinstance(message, NodeStatus):
        return message
    return replace(message, finger=_in_namespace(message.finger, namespace))


def _in_namespace(finger: str, namespace: str) -> str:
    return f"{namespace}/{finger}" if namespace else finger
