"""The endpoint of a foreign hand on ZeroMQ: messages of a topic and a payload, or of a payload alone."""

import time
from collections import Counter
from collections.abc import Mapping, Sequence

import zmq

from vegrip.messages import Message
from vegrip.transport.curve import Keys
from vegrip.transport.mapped.endpoint import NO_TRAFFIC_NS
from vegrip.transport.mapped.price import price
from vegrip.transport.mapped.topics import TopicCodec
from vegrip.transport.zmq_endpoint import MOST_MESSAGES, ZmqEndpoint

ALONE = "-"
"""The topic, in a map, of messages that have none."""


class MappedZmqEndpoint(ZmqEndpoint):
    """JSON or msgpack of another shape, in and out.

    Besides the names of :class:`~vegrip.transport.zmq_endpoint.ZmqEndpoint` and of the codec ``rejected`` has
    ``no_traffic`` and ``command_held``.
    """

    def __init__(
        self, publish: str, subscribe: Sequence[str], codec: TopicCodec, keys: Keys | None = None
    ) -> None:
        self._mapped = codec
        self._opened = time.monotonic_ns()
        self._was_heard = False
        super().__init__(publish, subscribe, codec, keys)  # type: ignore[arg-type]

    @property
    def sentences(self) -> Sequence[str]:
        """What the owner of the hand must know before it grips."""
        return price(self._mapped.plan)

    @property
    def rejected(self) -> Mapping[str, int]:
        """What went wrong so far, by name."""
        found = Counter(super().rejected)
        if not self._was_heard and time.monotonic_ns() - self._opened > NO_TRAFFIC_NS:
            found["no_traffic"] = 1
        found["command_held"] = self._mapped.held
        return {name: count for name, count in found.items() if count}

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a state, then take what is there; repeat commands that are due."""
        for topic, payload in self._mapped.due(time.monotonic_ns()):
            self._publish(topic, payload)
        messages = super().receive(timeout)
        self._was_heard = self._was_heard or bool(messages)
        return messages

    def _drain(self, messages: list[Message]) -> bool:
        is_dry = True
        for subscription in self._subscriptions:
            for _ in range(MOST_MESSAGES // len(self._subscriptions) or 1):
                parts = subscription.take()
                if parts is None:
                    break
                if len(parts) > 2:
                    self._faults["parts"] += 1
                    continue
                topic = parts[0].decode("utf-8", "replace") if len(parts) == 2 else ALONE
                messages += self._mapped.decode_all(topic, parts[-1], time.monotonic_ns())
            else:
                is_dry = False
        return is_dry

    def _publish(self, topic: str, payload: bytes) -> None:
        parts = [payload] if topic == ALONE else [topic.encode(), payload]
        try:
            self._publisher.send_multipart(parts, zmq.DONTWAIT)
        except zmq.ZMQError:
            self._faults["unsent"] += 1

    def topic_line(self, finger: str) -> None:
        """Return None: what comes through a map goes by messages."""

    def send(self, message: Message) -> None:
        """Publish a command; other messages are not for a foreign hand."""
        encoded = self._mapped.encode(message)
        if encoded is not None:
            self._publish(*encoded)
