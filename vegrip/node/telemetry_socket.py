"""Telemetry over ZeroMQ: one socket per node, and only what somebody has subscribed to is encoded."""

import time
from collections.abc import Iterator, Sequence

import zmq

from vegrip.codec.msgpack_codec import MsgpackCodec
from vegrip.messages import Message, NodeStatus
from vegrip.node.registry import Entry
from vegrip.node.telemetry import Direction

HIGH_WATER = 10_000  # messages kept for one subscriber
MOST_STREAMS = 1024  # are counted; a sender of made-up names must not make the table grow


class TelemetrySocket:
    """Publishes ``[topic, direction, payload]``; a sink of :class:`~vegrip.node.telemetry.Telemetry`."""

    def __init__(self, address: str, codec: MsgpackCodec) -> None:
        self._codec = codec
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.XPUB)
        self._socket.set_hwm(HIGH_WATER)
        self._socket.bind(address)
        self._subscribed: set[bytes] = set()
        self._counts: dict[tuple[type[Message], str, Direction], int] = {}
        self.wanted = False

    def count(self, message: Message, direction: Direction) -> None:
        """Count a message."""
        stream = (type(message), _owner(message), direction)
        known = self._counts.get(stream)
        if known is not None or len(self._counts) < MOST_STREAMS:
            self._counts[stream] = (known or 0) + 1

    def publish(self, messages: Sequence[tuple[Message, Direction]]) -> None:
        """Send the messages that somebody wants."""
        for message, direction in messages:
            self._send(message, _owner(message), direction)

    def topics(self) -> dict[str, dict[str, int]]:
        """Return how many messages were received (``in``) and sent (``out``) on each topic."""
        table: dict[str, dict[str, int]] = {}
        for (kind, owner, direction), count in list(self._counts.items()):
            route = self._codec.topics.outgoing(kind, owner)
            if route is not None:
                table.setdefault(route.topic, {"in": 0, "out": 0})[direction.value] += count
        return table

    def close(self) -> None:
        """Close the socket; what is queued has 100 ms to leave."""
        self._socket.close(linger=100)
        self._context.term()

    def listen(self) -> None:
        """Take note of who subscribes to what."""
        while int(self._socket.getsockopt(zmq.EVENTS)) & zmq.POLLIN:
            request = self._socket.recv()
            change = self._subscribed.add if request[:1] == b"\x01" else self._subscribed.discard
            change(request[1:])
        self.wanted = bool(self._subscribed)

    def _send(self, message: Message, owner: str, direction: Direction) -> None:
        route = self._codec.topics.outgoing(type(message), owner)
        if route is None:
            return
        topic = route.topic.encode()
        if any(topic.startswith(prefix) for prefix in self._subscribed):
            encoded = self._codec.encode(message)
            if encoded is not None:
                self._socket.send_multipart([topic, direction.value.encode(), encoded[1]], zmq.DONTWAIT)


def _owner(message: Message) -> str:
    return message.node if isinstance(message, NodeStatus) else message.finger


def _waiting(socket: zmq.Socket[bytes]) -> Iterator[tuple[str, str, bytes]]:
    for _ in range(HIGH_WATER):
        try:
            topic, direction, payload = socket.recv_multipart(zmq.DONTWAIT)
        except zmq.Again:
            return
        yield topic.decode(), direction.decode(), payload


class TelemetryReader:
    """Reads the telemetry of several nodes."""

    def __init__(self, entries: Sequence[Entry], prefixes: Sequence[str] = ("",)) -> None:
        self._context = zmq.Context()
        self._poller = zmq.Poller()
        self._sources: dict[zmq.Socket[bytes], tuple[Entry, MsgpackCodec]] = {}
        for entry in entries:
            self.add(entry, prefixes)

    def add(self, entry: Entry, prefixes: Sequence[str]) -> None:
        """Also read what ``entry`` says on topics that begin like one of ``prefixes``.

        A node that is started again under its name is heard again.
        """
        socket = self._context.socket(zmq.SUB)
        socket.set_hwm(HIGH_WATER)
        socket.connect(entry.telemetry)
        for prefix in prefixes:
            socket.subscribe(prefix)
        self._poller.register(socket, zmq.POLLIN)
        self._sources[socket] = (entry, MsgpackCodec(entry.namespace, remap=entry.remap))

    def read(self, timeout: float) -> Iterator[tuple[Entry, str, str, Message]]:
        """Yield node, topic, direction (``in``, ``out``) and message of what comes within ``timeout`` [s]."""
        for socket, _ in self._poller.poll(round(timeout * 1000)):
            entry, codec = self._sources[socket]
            for topic, direction, payload in _waiting(socket):
                message = codec.decode(topic, payload, time.monotonic_ns())
                if message is not None:
                    yield entry, topic, direction, message

    def close(self) -> None:
        """Close the sockets."""
        for socket in self._sources:
            socket.close(linger=0)
        self._context.term()
