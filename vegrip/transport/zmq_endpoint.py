"""A hand on a network: ZeroMQ publish and subscribe below, msgpack above.

Each node binds one publisher and connects to the publishers it listens to; there is no broker to start first
and the order of starting does not matter.
"""

import functools
import select
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import zmq

from vegrip.errors import DeviceError
from vegrip.messages import FingertipState, Message
from vegrip.transport.codec.batch_codec import BATCHED_MESSAGES, BatchCodec
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.connection_limit import ConnectionLimit
from vegrip.transport.curve import Keys, check_reach, resolve
from vegrip.transport.endpoint import BATCHES, Endpoint, losses
from vegrip.transport.socket_monitor import DONTWAIT, HANDSHAKES, Handshakes, Subscription

SUBSCRIBER_QUEUE_MESSAGES = 1000  # messages kept for one subscriber; then the newest are lost for it
MAX_MESSAGE_BYTES = 65_536  # [bytes] a peer that sends more is cut off by ZeroMQ, and connected to anew by us
MOST_MESSAGES = 256  # taken in one go; a flood must not keep the loop from its ticks
CONNECTION_POLL_S = 0.05  # [s] between two looks at the connections


class ZmqEndpoint(Endpoint):
    """Messages in and out as ``[topic, payload]``.

    After opening nothing raises. Besides the names of the codec ``rejected`` has ``unsent``, ``parts`` for
    messages not made of two parts, ``cut_off`` for connections that ZeroMQ ended for what came over them,
    ``connections`` for the times that no more subscribers were let in, ``lost`` for gaps in the numbers of
    messages, ``crowded`` and ``clipped``; with keys also those of
    :class:`~vegrip.transport.socket_monitor.Handshakes`.
    """

    def __init__(
        self,
        publish: str,  # address to bind, "" to send nothing
        subscribe: Sequence[str],
        codec: MsgpackCodec,
        keys: Keys | None = None,  # required as soon as an address is not of this machine
    ) -> None:
        self.arrivals: Sequence[int] = ()
        self._codec, self.broken = codec, codec.broken
        self._faults: Counter[str] = Counter()
        bound, connected = _checked([publish] if publish else [], keys), _checked(subscribe, keys)
        self._keys = keys
        self._context = zmq.Context()
        self._closed = False
        if keys is not None:
            keys.guard(self._context)
        self._publisher = self._socket(zmq.PUB)
        self._subscriptions: list[Subscription] = []
        self._descriptors: list[int] = []
        self._look_at = 0.0  # [s]
        self._handshakes = Handshakes() if keys is not None else None
        self._limit = self._limited(bound[0] if bound else "")
        try:
            if self._keys is not None:
                self._keys.serve(self._publisher)
            for address in bound:
                self._publisher.bind(address)
                self._limit.start()
            for address in connected:
                self._subscriptions.append(self._subscription(address))
            self._descriptors = [each.descriptor for each in self._subscriptions]
        except zmq.ZMQError as error:
            self.close()
            raise DeviceError(_sentence(error, publish, subscribe)) from None

    @property
    def rejected(self) -> Mapping[str, int]:
        self._look(time.monotonic())
        refused = self._handshakes.refused if self._handshakes is not None else {}
        more = {"cut_off": sum(each.cut_off for each in self._subscriptions), "crowded": self._codec.crowded}
        more = {name: count for name, count in more.items() if count}
        return {**self._codec.rejected, **self._faults, **losses(self._codec), **refused, **more}

    @property
    def in_trouble(self) -> bool:
        self._look(time.monotonic())
        return self._handshakes is not None and self._handshakes.in_trouble

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a message, then take what is there, at most ``MOST_MESSAGES``."""
        messages: list[Message] = []
        now = time.monotonic()
        if now >= self._look_at:
            self._look(now)
            self._look_at = now + CONNECTION_POLL_S
        is_dry = self._drain(messages)
        while not messages:
            remaining = now + timeout - time.monotonic()
            if remaining <= 0.0:
                break
            if is_dry:  # ``Socket.poll`` counts in whole milliseconds, too coarse for a tick
                select.select(self._descriptors, [], [], remaining)
            is_dry = self._drain(messages)
        self.arrivals = [time.monotonic_ns()] * len(messages)
        return messages

    def send(self, message: Message) -> None:
        """Publish ``message``; ZeroMQ queues it or drops it, and never waits."""
        encoded = self._codec.encode(message)
        if encoded is None:
            return  # counted by the codec
        topic, payload = encoded
        self.send_payload(topic.encode(), payload)

    def send_payload(self, topic: bytes, payload: bytes | bytearray) -> None:
        """Publish a payload as it is."""
        try:
            self._publisher.send_multipart(self.parts_of(topic, payload), zmq.DONTWAIT)
        except zmq.ZMQError:
            self._faults["unsent"] += 1

    def parts_of(self, topic: bytes, payload: bytes | bytearray) -> list[bytes | bytearray]:
        return [topic, payload]

    def close(self) -> None:
        """Close the sockets; what is queued has 100 ms to leave."""
        if self._closed:
            return
        self._closed = True
        if self._keys is not None:
            self._keys.close()
        self._limit.close()
        self._publisher.close(linger=100)
        for each in self._subscriptions:
            each.close()
        self._context.term()

    def _socket(self, kind: int) -> zmq.Socket[bytes]:
        socket = self._context.socket(kind)
        socket.set_hwm(SUBSCRIBER_QUEUE_MESSAGES)
        socket.setsockopt(zmq.MAXMSGSIZE, MAX_MESSAGE_BYTES)
        return socket

    def _limited(self, address: str) -> ConnectionLimit:
        if self._handshakes is None:
            return ConnectionLimit(self._publisher, address, self._faults)
        on_event = self._handshakes.published
        return ConnectionLimit(self._publisher, address, self._faults, int(HANDSHAKES), on_event)

    def _subscription(self, address: str) -> Subscription:
        socket = self._socket(zmq.SUB)
        if self._keys is None or self._handshakes is None:
            return Subscription(socket, address)
        self._keys.subscribe(socket)
        return Subscription(socket, address, functools.partial(self._handshakes.subscribed, address))

    def _look(self, now: float) -> None:
        for each in self._subscriptions:
            each.look(now)

    def _drain(self, messages: list[Message]) -> bool:
        """Take what is there; return whether that was all, so that the descriptors may be waited for."""
        is_dry = True
        for subscription in self._subscriptions:
            for _ in range(MOST_MESSAGES // len(self._subscriptions) or 1):
                parts = subscription.take()
                if parts is None:
                    break
                self._take(parts, time.monotonic_ns(), messages)
            else:
                is_dry = False
        return is_dry

    def _take(self, parts: Sequence[bytes], arrived: int, messages: list[Message]) -> None:
        """Add what the parts say, which arrived at ``arrived`` [ns]."""
        if len(parts) != 2:
            self._faults["parts"] += 1
            return
        message = self._codec.decode(parts[0].decode("utf-8", "replace"), parts[1], arrived)
        if message is not None:
            messages.append(message)


def _checked(addresses: Sequence[str], keys: Keys | None) -> list[str]:
    resolved = [resolve(address) for address in addresses]
    for address in resolved:
        check_reach(address, encrypted=keys is not None)
    return resolved


def _sentence(error: zmq.ZMQError, publish: str, subscribe: Sequence[str]) -> str:
    if error.errno == zmq.EADDRINUSE:
        return f"{publish} is in use by another program; choose another port or end that program"
    return f"cannot publish at {publish} and listen to {', '.join(subscribe)}: {error}"


TOPIC_FLAGS = DONTWAIT | int(zmq.SNDMORE)

BatchIntercept = Callable[[bytes, int, int], Sequence[int] | None]
"""Looks at a batch of states first, with its number of rows and its arrival [ns].

Returns in bits what it did with each row, 0 = left alone, or None when it left alone all.
"""


class BatchEndpoint(ZmqEndpoint):
    """States, commands, contacts and slip margins as batches.

    What one call of the loop sends goes out with :meth:`flush`.

    ``rejected`` has besides, for batches and rows, the names of
    :class:`~vegrip.transport.codec.batch_codec.BatchCodec`.
    """

    brings = BATCHES

    def __init__(
        self,
        publish: str,
        subscribe: Sequence[str],
        codec: MsgpackCodec,
        batches: BatchCodec,
        keys: Keys | None = None,
    ) -> None:
        self.intercept_batch: BatchIntercept | None = None
        self.batches = batches
        self._kinds = {topic.encode(): kind for kind, topic in batches.topics.items()}
        self._topics = {kind: topic for topic, kind in self._kinds.items()}
        self._put_off: list[tuple[bytes, bytes | bytearray]] = []  # topic and payload
        self._gathered: dict[type[Any], dict[int, Frame]] = {kind: {} for kind in BATCHED_MESSAGES}
        super().__init__(publish, subscribe, codec, keys)
        self.broken = batches.broken

    @property
    def rejected(self) -> Mapping[str, int]:
        found = dict(super().rejected)
        clipped = {"clipped": sum(self.batches.clipped.values()), "lost": self.batches.lost}
        for name, count in [*self.batches.rejected.items(), *clipped.items()]:
            if count:
                found[name] = found.get(name, 0) + count
        return found

    def line(self, finger: str) -> Line | None:
        return self.batches.line(finger)

    def send(self, message: Message) -> None:
        """Publish ``message``; one that travels in batches with the others at the next :meth:`flush`."""
        if not isinstance(message, BATCHED_MESSAGES):
            super().send(message)
            return
        gathered = self._gathered[type(message)]
        for frame in self.batches.encode(message):
            if frame.arbitration_id in gathered:
                self.flush()
            gathered[frame.arbitration_id] = frame

    def put_off(self, message: Message) -> None:
        """Publish ``message`` behind the next batch, or at the next :meth:`flush`."""
        if isinstance(message, BATCHED_MESSAGES):
            frames = self.batches.encode(message)
            if frames:
                self.put_off_batch(type(message), self.batches.pack(type(message), frames))
        elif (encoded := self._codec.encode(message)) is not None:
            topic, payload = encoded
            self._put_off.append((topic.encode(), payload))

    def flush(self) -> None:
        for kind, frames in self._gathered.items():
            if frames:
                self.send_batch(kind, bytes(self.batches.pack(kind, list(frames.values()))))
                frames.clear()
        self._send_put_off()

    def send_batch(self, kind: type[Message], payload: bytes | bytearray) -> None:
        self._publish(self._topics[kind], payload)
        self._send_put_off()

    def put_off_batch(self, kind: type[Message], payload: bytes | bytearray) -> None:
        """Publish a batch behind the next one, or at the next :meth:`flush`.

        To wake the thread of ZeroMQ takes six times as long as to give it another message while it is awake.
        """
        self._put_off.append((self._topics[kind], payload))

    def _send_put_off(self) -> None:
        for topic, payload in self._put_off:
            self._publish(topic, payload)
        self._put_off.clear()

    def _publish(self, topic: bytes, payload: bytes | bytearray) -> None:
        try:
            self._publisher.send(topic, TOPIC_FLAGS)
            self._publisher.send(payload, DONTWAIT)
        except zmq.ZMQError:
            self._faults["unsent"] += 1

    def _take(self, parts: Sequence[bytes], arrived: int, messages: list[Message]) -> None:
        kind = self._kinds.get(parts[0]) if len(parts) == 2 else None
        if kind is None:
            super()._take(parts, arrived, messages)
            return
        payload = parts[1]
        rows = self.batches.rows_in(payload, kind)
        done: Sequence[int] | None = None
        if kind is FingertipState and self.intercept_batch is not None and rows > 0:
            done = self.intercept_batch(payload, rows, arrived)
        for row in range(rows):
            if done is None or not done[row]:
                message = self.batches.decode(self.batches.frame(payload, kind, row, arrived))
                if message is not None:
                    messages.append(message)
