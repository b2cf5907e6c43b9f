"""A hand on a network whose states, commands and reports travel together: one message for all fingers.

Everything else goes by topics as in :class:`~vegrip.transport.zmq_endpoint.ZmqEndpoint`.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import zmq

from vegrip.messages import FingertipState, Message
from vegrip.transport.codec.batch_codec import BATCHED_MESSAGES, BatchCodec
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.curve import Keys
from vegrip.transport.endpoint import BATCHES
from vegrip.transport.zmq_endpoint import ZmqEndpoint

DONTWAIT, TOPIC_FLAGS = int(zmq.DONTWAIT), int(zmq.DONTWAIT) | int(zmq.SNDMORE)

BatchIntercept = Callable[[bytes, int, int], Sequence[int] | None]
"""Looks at a batch of states first, with its number of rows and its arrival [ns].

Returns in bits what it did with each row, 0 = left alone, or None when it left alone all.
"""


class BatchEndpoint(ZmqEndpoint):
    """States, commands, contacts and slip margins as batches.

    What one call of the loop sends goes out with :meth:`flush`.

    ``rejected`` has besides, for batches and rows, the names of
    :class:`~vegrip.transport.codec.batch_codec.BatchCodec`.

    Args:
        publish: address to bind, "" to send nothing.
        subscribe: addresses to connect to.
        codec: of all other messages.
        batches: of those.
        keys: CURVE keys.

    Raises:
        ConfigError: an address that is none, or open to the world without keys.
        DeviceError: an address in use.

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
        """What went wrong so far, by name."""
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
        """Publish what was gathered."""
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
