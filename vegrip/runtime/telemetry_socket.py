"""Telemetry over ZeroMQ: one socket per node, and only what has a subscriber is encoded.

A subscription to a topic brings every message. One to ``newest:`` in front of a topic brings, of each
``NEWEST_PERIOD``, the newest message of that topic alone: a display needs no more, and 500 states per second
of five fingers would cost the node a tenth of a core to encode.
"""

import time
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import zmq

from vegrip.messages import OF_NODES, Message
from vegrip.runtime.registry import Entry
from vegrip.runtime.telemetry import Direction
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.connection_limit import ConnectionLimit

SUBSCRIBER_QUEUE_MESSAGES = 10_000  # messages kept for one subscriber
TURN_MESSAGES = 100  # read of one node before the next one is
MAX_SUBSCRIPTION_BYTES = 4096  # [bytes] of a subscription
MOST_STREAMS = 1024  # are counted besides those of configured fingers; names may be made up
MOST_PREFIXES = 256  # subscriptions that are distinguished; when there are more, everything is encoded
NEWEST = "newest:"  # in front of a topic: its newest message alone, every
NEWEST_PERIOD = 0.04  # [s]
CONNECTED_PERIOD = 0.2  # [s] between two looks whether a program is connected; each counts open files
SENDING = zmq.DONTWAIT | zmq.SNDMORE
DIRECTIONS = {direction: direction.value.encode() for direction in Direction}
NEWEST_WINDOW = 0.01  # [s] at its end, in which a newer message takes the place of one that is there
SUBSCRIBE, UNSUBSCRIBE = b"\x01", b"\x00"  # the first byte of what subscribers send


@dataclass(frozen=True, slots=True)
class _Stream:
    """The messages of one kind of one finger or node, and which of them are wanted."""

    topic: bytes
    every: bool
    newest: bool


UNSORTED = _Stream(b"", every=True, newest=False)
"""Stands for a stream of which it is not known yet who wants it."""


class TelemetrySocket:
    """Publishes ``[topic, direction, payload]``: where :class:`~vegrip.runtime.telemetry.Telemetry` goes.

    ``count``, ``tally``, ``wants`` and ``takes`` are called from the loop, the rest from the thread.
    """

    def __init__(
        self,
        address: str,
        codec: MsgpackCodec,
        fingers: Collection[str] = (),  # their messages are counted whatever else comes
        counts: Counter[str] | None = None,  # gets ``subscription``, which was none, and ``connections``
    ) -> None:
        self._codec = codec
        self._fingers = frozenset(fingers)
        self._refused: Counter[str] = Counter() if counts is None else counts
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.XPUB)
        self._socket.set_hwm(SUBSCRIBER_QUEUE_MESSAGES)
        # every subscription is announced, also while a lost one still counts as a subscriber of the same
        self._socket.setsockopt(zmq.XPUB_VERBOSE, 1)
        self._socket.setsockopt(zmq.MAXMSGSIZE, MAX_SUBSCRIPTION_BYTES)
        self._limit = ConnectionLimit(self._socket, address, self._refused)
        self._socket.bind(address)
        self._limit.start()
        self._subscribed: set[bytes] = set()
        self._streams: dict[tuple[type[Message], str], _Stream | None] = {}
        self._newest: dict[tuple[type[Message], str, Direction], Message] = {}
        self._newest_due = self._connected_due = 0.0  # [s] of the monotonic clock
        self._counts: dict[tuple[type[Message], str, Direction], int] = {}
        self.wanted = False
        """Whether a subscriber wants the messages themselves."""

    def count(self, message: Message, direction: Direction) -> None:
        self.tally(type(message), _owner(message), direction)

    def tally(self, kind: type[Message], owner: str, direction: Direction) -> None:
        """Count a message of this kind that was never made."""
        stream = (kind, owner, direction)
        known = self._counts.get(stream)
        if known is not None or len(self._counts) < MOST_STREAMS or stream[1] in self._fingers:
            self._counts[stream] = (known or 0) + 1

    def wants(self, kind: type[Message], owner: str, direction: Direction) -> bool:
        """Whether a message of this stream is to be shown now: every one, or the newest of a period."""
        stream = self._streams.get((kind, owner), UNSORTED)  # the thread may clear it at any time
        if stream is None or not stream.newest or stream.every:
            return stream is not None and stream.every
        is_late = time.monotonic() >= self._newest_due - NEWEST_WINDOW
        return is_late or (kind, owner, direction) not in self._newest

    def takes(self, message: Message, direction: Direction) -> bool:
        """Whether a subscriber wants every message of this stream; else the newest is kept here."""
        key = kind, owner = type(message), _owner(message)
        stream = self._streams.get(key, UNSORTED)  # the thread may clear it at any time
        if stream is UNSORTED:
            return True  # :meth:`publish` finds out who wants it
        if stream is not None and stream.newest:
            self._newest[kind, owner, direction] = message
        return stream is not None and stream.every

    def publish(self, messages: Sequence[tuple[Message, Direction]]) -> None:
        """Send the messages that have subscribers, and keep the newest where that suffices."""
        for message, direction in messages:
            owner = _owner(message)
            stream = self._stream(type(message), owner)
            if stream is None:
                continue
            if stream.every:
                self._send(stream.topic, message, direction)
            if stream.newest:  # unless the loop has kept a newer one
                key = (type(message), owner, direction)
                if key not in self._newest or message.stamp >= self._newest[key].stamp:
                    self._newest[key] = message
        self._send_newest()

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

        A prefix is forgotten when no program is connected any more, not when one unsubscribes: libzmq passes
        on every cancellation, also of a program that had not subscribed. A message without subscribers is
        not sent, only encoded.
        """
        for _ in range(SUBSCRIBER_QUEUE_MESSAGES):
            if not int(self._socket.getsockopt(zmq.EVENTS)) & zmq.POLLIN:
                break
            # one frame: to wait for all of a message would be to wait for ever, since libzmq drops some
            frame = self._socket.recv(zmq.DONTWAIT)
            kind, prefix = frame[:1], frame[1:]
            if kind not in (SUBSCRIBE, UNSUBSCRIBE):
                self._refused["subscription"] += 1
            elif kind == SUBSCRIBE:
                self._subscribed.add(prefix if len(self._subscribed) < MOST_PREFIXES else b"")
                self._streams.clear()
        if self._subscribed and self._is_left():  # asked last: who subscribed was connected before
            self._subscribed.clear()
            self._streams.clear()
            self._newest.clear()
        self.wanted = bool(self._subscribed)
        self._send_newest()

    def _is_left(self) -> bool:
        now = time.monotonic()
        if now < self._connected_due:
            return False
        self._connected_due = now + CONNECTED_PERIOD
        return not self._limit.connected()

    def _stream(self, kind: type[Message], owner: str) -> _Stream | None:
        key = (kind, owner)
        if key in self._streams:
            return self._streams[key]
        route = self._codec.topics.outgoing(kind, owner)
        stream = None
        if route is not None:
            topic = route.topic.encode()
            thin = NEWEST.encode()
            every = any(topic.startswith(prefix) for prefix in self._subscribed)
            newest = any((thin + topic).startswith(p) for p in self._subscribed if p.startswith(thin))
            stream = _Stream(topic, every, newest)
        if len(self._streams) < MOST_STREAMS or owner in self._fingers:
            self._streams[key] = stream
        return stream

    def _send_newest(self) -> None:
        now = time.monotonic()
        if not self._newest or now < self._newest_due:
            return
        self._newest_due = now + NEWEST_PERIOD
        for key in list(self._newest):  # the loop puts others in meanwhile
            message = self._newest.pop(key)
            if (stream := self._stream(*key[:2])) is not None:
                self._send(NEWEST.encode() + stream.topic, message, key[2])

    def _send(self, topic: bytes, message: Message, direction: Direction) -> None:
        encoded = self._codec.encode(message)
        if encoded is not None:
            self._socket.send(topic, SENDING)
            self._socket.send(DIRECTIONS[direction], SENDING)
            self._socket.send(encoded[1], zmq.DONTWAIT)


def _owner(message: Message) -> str:
    return message.node if isinstance(message, OF_NODES) else message.finger


def _waiting(socket: zmq.Socket[bytes]) -> list[tuple[str, str, bytes]]:
    taken: list[tuple[str, str, bytes]] = []
    while len(taken) < TURN_MESSAGES:
        try:
            topic, direction, payload = socket.recv_multipart(zmq.DONTWAIT)
        except zmq.Again:
            break
        taken.append((topic.decode().removeprefix(NEWEST), direction.decode(), payload))
    return taken


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

        A prefix that begins with :data:`NEWEST` brings the newest messages alone.

        A node that is started again under its name is received again.
        """
        there = (socket for socket, (known, _) in self._sources.items() if known.name == entry.name)
        socket = next(there, None) or self._connected(entry)
        for prefix in prefixes:
            socket.subscribe(prefix)

    def _connected(self, entry: Entry) -> "zmq.Socket[bytes]":
        socket = self._context.socket(zmq.SUB)
        socket.set_hwm(SUBSCRIBER_QUEUE_MESSAGES)
        socket.connect(entry.telemetry)
        self._poller.register(socket, zmq.POLLIN)
        self._sources[socket] = (entry, MsgpackCodec(entry.namespace, remap=entry.remap))
        return socket

    def read(self, timeout: float) -> Iterator[tuple[Entry, str, str, Message]]:
        """Yield node, topic, direction (``in``, ``out``) and message of what comes within ``timeout`` [s].

        Nodes take turns, and after another ``timeout`` it ends: one that sends faster than it is read would
        keep the others from being received.
        """
        ready = [socket for socket, _ in self._poller.poll(round(timeout * 1000))]
        ends = time.monotonic() + timeout
        while ready:
            for socket in tuple(ready):
                entry, codec = self._sources[socket]
                taken = _waiting(socket)
                if len(taken) < TURN_MESSAGES:
                    ready.remove(socket)
                for topic, direction, payload in taken:
                    message = codec.decode(topic, payload, time.monotonic_ns())
                    if message is not None:
                        yield entry, topic, direction, message
            if time.monotonic() >= ends:
                return

    def close(self) -> None:
        for socket in self._sources:
            socket.close(linger=0)
        self._context.term()
