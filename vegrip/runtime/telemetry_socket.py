"""Telemetry over ZeroMQ: one socket per node, and only what somebody has subscribed to is encoded."""

import time
from collections import Counter
from collections.abc import Collection, Iterator, Sequence

import zmq

from vegrip.messages import Message, NodeStatus
from vegrip.runtime.registry import Entry
from vegrip.runtime.telemetry import Direction
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.connection_limit import ConnectionLimit

HIGH_WATER = 10_000  # messages kept for one subscriber
LARGEST = 4096  # [bytes] of a subscription
MOST_STREAMS = 1024  # are counted besides those of configured fingers; names may be made up
MOST_PREFIXES = 256  # subscriptions told apart; when there are more, everything is encoded
SUBSCRIBE, UNSUBSCRIBE = b"\x01", b"\x00"  # the first byte of what subscribers send


class TelemetrySocket:
    """Publishes ``[topic, direction, payload]``; a sink of :class:`~vegrip.runtime.telemetry.Telemetry`.

    Args:
        address: to bind.
        codec: how messages are encoded, and their topics.
        fingers: those that are configured; their messages are counted whatever else comes.
        counts: where ``subscription`` is counted, what subscribers sent that is none, and ``connections``.

    """

    def __init__(
        self,
        address: str,
        codec: MsgpackCodec,
        fingers: Collection[str] = (),
        counts: Counter[str] | None = None,
    ) -> None:
        self._codec = codec
        self._fingers = frozenset(fingers)
        self._refused: Counter[str] = Counter() if counts is None else counts
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.XPUB)
        self._socket.set_hwm(HIGH_WATER)
        # every subscription is told, also while one who has gone still counts as a subscriber of the same
        self._socket.setsockopt(zmq.XPUB_VERBOSE, 1)
        self._socket.setsockopt(zmq.MAXMSGSIZE, LARGEST)
        self._limit = ConnectionLimit(self._socket, address, self._refused)
        self._socket.bind(address)
        self._limit.start()
        self._subscribed: set[bytes] = set()
        self._counts: dict[tuple[type[Message], str, Direction], int] = {}
        self.wanted = False

    def count(self, message: Message, direction: Direction) -> None:
        """Count a message."""
        stream = (type(message), _owner(message), direction)
        known = self._counts.get(stream)
        if known is not None or len(self._counts) < MOST_STREAMS or stream[1] in self._fingers:
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
        self._limit.close()
        self._socket.close(linger=100)
        self._context.term()

    def listen(self) -> None:
        """Take note of what is subscribed to.

        A prefix is forgotten when nobody is connected any more, and not when somebody unsubscribes: libzmq
        passes on what it is sent, also by one who had not subscribed to what others want. What nobody wants
        is not sent in any case, only encoded.
        """
        for _ in range(HIGH_WATER):
            if not int(self._socket.getsockopt(zmq.EVENTS)) & zmq.POLLIN:
                break
            self._subscribe(self._socket.recv(zmq.DONTWAIT))
        if (
            self._subscribed and not self._limit.connected()
        ):  # asked last: who subscribed was connected before
            self._subscribed.clear()
        self.wanted = bool(self._subscribed)

    def _subscribe(self, frame: bytes) -> None:
        """Take one frame; to wait for all of a message would be to wait for ever, since libzmq drops some."""
        kind, prefix = frame[:1], frame[1:]
        if kind not in (SUBSCRIBE, UNSUBSCRIBE):
            self._refused["subscription"] += 1
        elif kind == SUBSCRIBE:
            self._subscribed.add(prefix if len(self._subscribed) < MOST_PREFIXES else b"")

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
