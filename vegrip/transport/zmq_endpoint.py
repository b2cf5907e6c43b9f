"""A hand on a network: ZeroMQ publish and subscribe below, msgpack above.

Each node binds one publisher and connects to the publishers it listens to; there is no broker to start first
and the order of starting does not matter.
"""

import math
import select
import time
from collections import Counter
from collections.abc import Mapping, Sequence

import zmq

from vegrip.codec.msgpack_codec import MsgpackCodec
from vegrip.errors import DeviceError
from vegrip.messages import Message
from vegrip.transport.curve import Keys
from vegrip.transport.handshakes import Handshakes
from vegrip.transport.losses import losses
from vegrip.transport.zmq_address import check_reach, resolve

HIGH_WATER = 1000  # messages kept for one subscriber; then the newest are lost for it
LARGEST = 65_536  # [bytes] a peer that sends more is cut off by ZeroMQ
MOST_MESSAGES = 256  # taken in one go; a flood must not keep the loop from its ticks


class ZmqEndpoint:
    """Messages in and out as ``[topic, payload]``.

    After opening nothing raises. Besides the names of the codec ``rejected`` has ``unsent``, ``parts`` for
    messages not made of two parts, ``lost`` for gaps in the numbers of messages, and ``clipped``; with keys
    also those of :class:`~vegrip.transport.handshakes.Handshakes`.

    Args:
        publish: address to bind, "" to send nothing.
        subscribe: addresses to connect to.
        codec: what the messages look like; its namespace selects the topics.
        keys: CURVE keys; required as soon as an address is not of this machine.

    Raises:
        ConfigError: an address that is none, or open to the world without keys.
        DeviceError: an address in use.

    """

    def __init__(
        self,
        publish: str,
        subscribe: Sequence[str],
        codec: MsgpackCodec,
        keys: Keys | None = None,
    ) -> None:
        self.arrivals: Sequence[int] = ()
        self._codec = codec
        self._faults: Counter[str] = Counter()
        bound, connected = _checked([publish] if publish else [], keys), _checked(subscribe, keys)
        self._keys = keys
        self._context = zmq.Context()
        self._closed = False
        if keys is not None:
            keys.guard(self._context)
        self._publisher = self._socket(zmq.PUB)
        self._subscriber = self._socket(zmq.SUB)
        self._handshakes = Handshakes(self._publisher, self._subscriber) if keys is not None else None
        try:
            self._open(bound, connected)
        except zmq.ZMQError as error:
            self.close()
            raise DeviceError(_sentence(error, publish, subscribe)) from None

    @property
    def rejected(self) -> Mapping[str, int]:
        """What went wrong so far, by name."""
        refused = self._handshakes.refused() if self._handshakes is not None else {}
        return {**self._codec.rejected, **self._faults, **losses(self._codec), **refused}

    @property
    def broken(self) -> Mapping[str, int]:
        """States that arrived and could not be understood, by finger."""
        return self._codec.broken

    @property
    def in_trouble(self) -> bool:
        """Whether a publisher that we need refuses us, or is not the one we know."""
        return self._handshakes is not None and self._handshakes.in_trouble

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a message, then take what is there, at most ``MOST_MESSAGES``."""
        messages: list[Message] = []
        deadline = time.monotonic() + timeout
        while not messages and self._readable(deadline):
            self._drain(messages)
        self.arrivals = [time.monotonic_ns()] * len(messages)
        return messages

    def send(self, message: Message) -> None:
        """Publish ``message``; ZeroMQ queues it or drops it, and never waits."""
        encoded = self._codec.encode(message)
        if encoded is None:
            return  # counted by the codec
        topic, payload = encoded
        try:
            self._publisher.send_multipart([topic.encode(), payload], zmq.DONTWAIT)
        except zmq.ZMQError:
            self._faults["unsent"] += 1

    def bus_load(self) -> float:
        """Return NaN: a network has no one load."""
        return math.nan

    def close(self) -> None:
        """Close the sockets; what is queued has 100 ms to leave."""
        if self._closed:
            return
        self._closed = True
        if self._keys is not None:
            self._keys.close()
        if self._handshakes is not None:
            self._handshakes.close()
        self._publisher.close(linger=100)
        self._subscriber.close(linger=0)
        self._context.term()

    def _socket(self, kind: int) -> zmq.Socket[bytes]:
        socket = self._context.socket(kind)
        socket.set_hwm(HIGH_WATER)
        socket.setsockopt(zmq.MAXMSGSIZE, LARGEST)
        return socket

    def _open(self, publish: Sequence[str], subscribe: Sequence[str]) -> None:
        if self._keys is not None:
            self._keys.serve(self._publisher)
            self._keys.subscribe(self._subscriber)
        for address in publish:
            self._publisher.bind(address)
        for address in subscribe:
            self._subscriber.connect(address)
        self._subscriber.subscribe("")

    def _drain(self, messages: list[Message]) -> None:
        for _ in range(MOST_MESSAGES):
            try:
                parts = self._subscriber.recv_multipart(zmq.DONTWAIT)
            except zmq.Again:
                return
            message = self._decoded(parts)
            if message is not None:
                messages.append(message)

    def _decoded(self, parts: Sequence[bytes]) -> Message | None:
        if len(parts) != 2:
            self._faults["parts"] += 1
            return None
        return self._codec.decode(parts[0].decode("utf-8", "replace"), parts[1], time.monotonic_ns())

    def _readable(self, deadline: float) -> bool:
        """Wait for a message until ``deadline`` [s].

        ``Socket.poll`` counts in whole milliseconds, too coarse for a tick. The descriptor of the socket
        signals edges only, so ``EVENTS`` is asked before each wait.
        """
        while not int(self._subscriber.getsockopt(zmq.EVENTS)) & zmq.POLLIN:
            remaining = deadline - time.monotonic()
            if remaining <= 0.0:
                return False
            select.select([self._subscriber], [], [], remaining)
        return True


def _checked(addresses: Sequence[str], keys: Keys | None) -> list[str]:
    resolved = [resolve(address) for address in addresses]
    for address in resolved:
        check_reach(address, encrypted=keys is not None)
    return resolved


def _sentence(error: zmq.ZMQError, publish: str, subscribe: Sequence[str]) -> str:
    if error.errno == zmq.EADDRINUSE:
        return f"{publish} is in use by another program; choose another port or end that program"
    return f"cannot publish at {publish} and listen to {', '.join(subscribe)}: {error}"
