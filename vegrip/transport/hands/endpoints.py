"""Endpoints of foreign hands, on a CAN bus and on ZeroMQ, opened as their maps say."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import can

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import Message
from vegrip.transport.can_endpoint import MOST_FRAMES, CanEndpoint, Open
from vegrip.transport.can_port import CanPort
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.codec.frame import EXTENDED
from vegrip.transport.curve import Keys
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.mapped.codec import MappedCodec, TopicCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.price import price, settings
from vegrip.transport.open import CanSettings, Hand, ZmqSettings, open_bus
from vegrip.transport.zmq_endpoint import ZmqEndpoint

MASKS: Final = {False: 0x7FF, True: 0x1FFFFFFF}
NO_TRAFFIC_NS: Final = 2 * NS
"""[ns] after opening without one message of the map: the wrong bus, rate or database."""


class MappedCanEndpoint(CanEndpoint):
    """Frames of a foreign hand in and out.

    Besides the names of :class:`~vegrip.transport.can_endpoint.CanEndpoint` and of the codec, ``rejected``
    has ``no_traffic`` (nothing of the map has ever come), ``foreign`` (frames that the map does not read,
    sent only with it) and ``command_held`` (frames that repeated a command whose lifetime was over).
    """

    def __init__(
        self, bus: can.BusABC, codec: MappedCodec, reopen: Open | None = None, timing: BitTiming | None = None
    ) -> None:
        super().__init__(bus, codec, reopen, timing, extended=True)
        self._mapped = codec
        self._opened = time.monotonic_ns()
        self._was_received = False
        self._begin()

    def _begin(self) -> None:
        for frame in self._mapped.begin():
            self.send_frame(frame)

    def _reopened(self) -> CanPort | None:
        port = super()._reopened()
        if port is not None:
            self._begin()
        return port

    @property
    def sentences(self) -> Sequence[str]:
        return price(self._mapped.plan)

    @property
    def rejected(self) -> Mapping[str, int]:
        found = _faults(super().rejected, self._mapped, None if self._was_received else self._opened)
        return found | {"foreign": self._mapped.foreign} if "no_traffic" in found else found

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a state, then take what is there; repeat commands that are due."""
        deadline = time.monotonic() + timeout
        messages: list[Message] = []
        arrivals: list[int] = []
        self._repeat()
        for _ in range(MOST_FRAMES):
            frame = self.next_frame(0.0 if messages else max(deadline - time.monotonic(), 0.0))
            if frame is None:
                break
            states = self._mapped.decode_all(frame)
            messages += states
            arrivals += [frame.stamp] * len(states)
        self._repeat()
        if messages and not self._was_received:
            self._was_received = True
            self._bring_only_its_own()
        self._mapped.add_reports(messages, arrivals, time.monotonic_ns())
        self.arrivals = arrivals
        return messages

    def _repeat(self) -> None:
        for frame in self._mapped.due(time.monotonic_ns()):
            self.send_frame(frame)

    def zero(self) -> bool:
        return self._mapped.dialogue is not None and self._mapped.dialogue.zero()

    def close(self) -> None:
        """Say what is sent to the hand at the end, and leave the bus."""
        if self._mapped.dialogue is not None:
            for step in self._mapped.dialogue.closing:
                self.send_frame(step.frame)
        super().close()

    def _bring_only_its_own(self) -> None:
        """Filter the frames of others out in the controller; only once this is known to be the right bus."""
        self._filters = [
            {
                "can_id": one & ~EXTENDED,
                "can_mask": MASKS[bool(one & EXTENDED)],
                "extended": bool(one & EXTENDED),
            }
            for one in sorted(self._mapped.identifiers)
        ]
        self._filter()


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
        self._was_received = False
        super().__init__(publish, subscribe, codec, keys)  # type: ignore[arg-type]

    @property
    def sentences(self) -> Sequence[str]:
        return price(self._mapped.plan)

    @property
    def rejected(self) -> Mapping[str, int]:
        return _faults(super().rejected, self._mapped, None if self._was_received else self._opened)

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a state, then take what is there; repeat commands that are due."""
        for topic, payload in self._mapped.due(time.monotonic_ns()):
            self.send_payload(topic.encode(), payload)
        messages = super().receive(timeout)
        self._was_received = self._was_received or bool(messages)
        return messages

    def _take(self, parts: Sequence[bytes], arrived: int, messages: list[Message]) -> None:
        if len(parts) > 2:
            self._faults["parts"] += 1
            return
        topic = parts[0].decode("utf-8", "replace") if len(parts) == 2 else ALONE
        messages += self._mapped.decode_all(topic, parts[-1], arrived)

    def parts_of(self, topic: bytes, payload: bytes | bytearray) -> list[bytes | bytearray]:
        return [payload] if topic == ALONE.encode() else [topic, payload]


def _faults(
    rejected: Mapping[str, int], codec: MappedCodec | TopicCodec, silent_since: int | None
) -> dict[str, int]:
    is_silent = silent_since is not None and time.monotonic_ns() - silent_since > NO_TRAFFIC_NS
    found = {**rejected, "no_traffic": int(is_silent), "command_held": codec.encoder.held}
    return {name: count for name, count in found.items() if count}


def open_mapped_can(table: CanSettings, hand: Hand) -> Endpoint:
    """Open a hand of another make on a CAN bus."""
    plan = open_plan(table.map, hand.fingers)
    if plan.hand.format:
        raise ConfigError(f"{table.map}: is for ZeroMQ; on CAN a map has a database = '...'")
    codec = MappedCodec(plan)
    bus, again, timing = open_bus(table)
    return MappedCanEndpoint(bus, codec, again, timing)


def open_mapped_zmq(table: ZmqSettings, hand: Hand, keys: Keys | None) -> Endpoint:
    """Open a hand of another make on a network."""
    plan = open_plan(table.map, hand.fingers)
    if not plan.hand.format:
        raise ConfigError(
            f"{table.map}: is for CAN; over ZeroMQ a map has format = 'json', 'msgpack' or 'protobuf'"
        )
    return MappedZmqEndpoint(table.publish, table.subscribe, TopicCodec(plan), keys)


def settings_of(path: Path) -> dict[str, Any]:
    return settings(open_plan(path))
