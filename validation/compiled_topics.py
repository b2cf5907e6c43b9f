"""The compiled finger step against the objects on single topics: the states of a log in msgpack."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import msgpack
import numpy as np

from validation.compiled_finger import SILENCES, Event, Log, Replay
from vegrip.grip.batch_text import COMMANDED
from vegrip.grip.compiled_finger import LEFT_ALONE, REPORT
from vegrip.grip.parameters import GraspParameters
from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.transport.codec import CanCodec
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.codec.protection import P04, P04_COUNTER, P04_HEADER
from vegrip.transport.codec.topic_line import TopicLine
from vegrip.transport.codec.topics import data_id_of

VALUES = 9  # doubles of a state
HEAD = frozenset({"version", "finger", "seq", "stamp", "more"})
"""Of the body of a state: what is no value."""


def on_topics(log: Log) -> Log:
    """Return a ``log`` of CAN FD frames with the states as payloads; what was refused is broken here, too."""
    codec = CanCodec(log.fingers, fd=True, use_sender_time=True)
    out, last = MsgpackCodec("", log.fingers), dict.fromkeys(log.fingers, b"")
    owners = {line.state_id: finger for finger in log.fingers if (line := codec.line(finger)) is not None}
    found = replace(log, events=[])
    for event in log.events:
        frame = event.frame
        if frame is None:
            found.events.append(event)
            continue
        finger, refused = owners.get(frame.arbitration_id, ""), codec.rejected["counter"]
        message = codec.decode(frame)
        if not finger:
            continue
        if isinstance(message, FingertipState) and (encoded := out.encode(message)) is not None:
            last[finger] = encoded[1]
        elif codec.rejected["counter"] == refused:  # broken, and not only repeated
            last[finger] = last[finger][:-1] + b"\xc1"
        found.events.append(Event(event.now, None, finger, last[finger], frame.stamp))
    return found


class TopicReplay(Replay):
    """A node that meets a log of topics; the arguments are those of Replay."""

    def __init__(self, log: Log, mode: str = "", parameters: GraspParameters | None = None) -> None:
        super().__init__(log, "", parameters)
        self.codec: Any = MsgpackCodec("", log.fingers, use_sender_time=log.sender_time)
        self.topic_lines: dict[str, TopicLine] = {}
        self._bytes = bytearray(8 * VALUES)
        self._values = np.frombuffer(self._bytes)
        if mode:
            self.topic_lines = {f: line for f in log.fingers if (line := self.codec.line(f)) is not None}
            self.node.run_compiled(self.topic_lines, mode)

    def meet(self, event: Event) -> None:
        """Meet one event."""
        if not event.payload:
            super().meet(event)
            return
        if not self._is_compiled(event):
            message = self.codec.decode(f"/hand/{event.finger}/state", event.payload, event.arrival)
            if message is not None:
                self._answered(self.node.on_message(message, event.now))
        self.answers.conditions.append(tuple(self._condition(finger) for finger in self.log.fingers))

    def _is_compiled(self, event: Event) -> bool:
        line = self.topic_lines.get(event.finger)
        if line is None:
            return False
        found = line.unpack(event.payload, event.arrival, self._bytes)
        if found is None:
            self.node.take_back(event.finger)
            return False
        done = self.node.on_values(event.finger, self._values, *found, event.arrival, event.now)
        if done & COMMANDED:
            seq, force, adjustment, reason, lifetime = self.node.command_numbers(event.finger)
            payload = line.pack(seq, event.now, force, adjustment, reason, event.now + lifetime)
            self._note(event.finger, bytes(payload))
        if done & REPORT:
            self._answered(self.node.reports(event.finger, event.now))
        self.answers.compiled_frames += done != LEFT_ALONE
        return done != LEFT_ALONE

    def _answered(self, messages: Iterable[Message]) -> None:
        for message in messages:
            if isinstance(message, ForceCommand) and (encoded := self.codec.encode(message)) is not None:
                self._note(message.finger, encoded[1])

    def _note(self, finger: str, payload: bytes) -> None:
        self.answers.commands.append((self.log.fingers.index(finger), payload))


def hostile_topics(log: Log, seed: int) -> Log:
    """Return a ``log`` of topics with false states, and silences now and then."""
    liars = {finger: PayloadLiar((seed, number), finger) for number, finger in enumerate(log.fingers)}
    rng, later = np.random.default_rng(seed), 0  # [ns]
    found = replace(log, events=[])
    for event in log.events:
        if rng.random() < SILENCES:
            later += int(10 ** rng.uniform(6.0, 9.5))
        payloads = liars[event.finger].falsified(event.payload, later) if event.payload else [b""]
        found.events += [
            replace(event, now=event.now + later, arrival=event.arrival + later, payload=payload)
            for payload in payloads
        ]
    return found


Body = dict[Any, Any]


class PayloadLiar:
    """Makes the payloads of a finger's states false in bursts.

    Args:
        seed: of what is done when.
        finger: its name.

    """

    BURST = 60  # payloads at most
    WELL = 0.5  # share of bursts in which nothing is done
    ODD: tuple[Any, ...] = (
        0.0, -0.0, 1e-300, 1e38, -1e300, float("inf"), float("-inf"), float("nan"), 1, -3, 2**63, True, None,
        "1.0", [1.0], {}, 60.0, -5.0,
    )  # fmt: skip
    STAMPS: tuple[Any, ...] = (0, -1, -(2**63), 2**63 - 1, 2**64 - 1, 2**62, 1.5, "now", None, True)

    def __init__(self, seed: tuple[int, int], finger: str) -> None:
        self._rng = np.random.default_rng(seed)
        self._data_id = data_id_of(f"/hand/{finger}/state")
        self._ways: tuple[Callable[[Body], None], ...] = (
            self._odd_value, self._absent, self._all_absent, self._counter, self._version, self._finger,
            self._stamp, self._clock, self._more, self._frozen, self._whole_numbers, self._slip,
        )  # fmt: skip
        self._fates: tuple[Callable[[bytes], Sequence[bytes]], ...] = (
            lambda _: (), lambda data: (data, data), self._flipped, lambda data: (data[:-3],),
            self._other_counter, lambda _: (self._sealed(msgpack.packb([1, 2]), 1),), lambda _: (b"\0",),
        )  # fmt: skip
        self._left, self._way, self._fate = 0, -1, -1
        self._held: Body = {}
        self._clock_off = 0  # [ns]

    def falsified(self, payload: bytes, later: int) -> Sequence[bytes]:
        """Return what comes in place of a payload, whose stamp is to be ``later`` [ns]."""
        if self._left <= 0:
            self._left = int(self._rng.integers(1, self.BURST))
            self._way = self._fate = -1
            self._held = {}
            if self._rng.random() > self.WELL:
                self._way = int(self._rng.integers(-4, len(self._ways)))
                self._fate = int(self._rng.integers(-4, len(self._fates)))
        self._left -= 1
        try:
            body = msgpack.unpackb(payload[P04_HEADER:])
        except (ValueError, msgpack.UnpackException):
            return (payload,)
        body["stamp"] += later + self._clock_off
        if self._way >= 0:
            self._ways[self._way](body)
        seq = body["seq"] if type(body.get("seq")) is int else 0
        data = self._sealed(msgpack.packb(body), seq)
        is_struck = self._fate >= 0 and self._rng.random() < 0.2
        return self._fates[self._fate](data) if is_struck else (data,)

    def _sealed(self, packed: bytes, seq: int) -> bytes:
        data = bytearray(P04_HEADER) + packed
        data[P04_COUNTER] = (seq & 0xFFFF).to_bytes(2, "big")
        P04.protect(data, self._data_id)
        return bytes(data)

    def _flipped(self, data: bytes) -> Sequence[bytes]:
        broken = bytearray(data)
        broken[int(self._rng.integers(len(data)))] ^= 1 << int(self._rng.integers(8))
        return (bytes(broken),)

    def _other_counter(self, data: bytes) -> Sequence[bytes]:
        body = bytearray(data)
        body[P04_COUNTER] = bytes(reversed(body[P04_COUNTER]))
        P04.protect(body, self._data_id)
        return (bytes(body),)

    def _channel(self, body: Body) -> str:
        return str(self._rng.choice([name for name in body if name not in HEAD]))

    def _odd_value(self, body: Body) -> None:
        body[self._channel(body)] = self.ODD[int(self._rng.integers(len(self.ODD)))]

    def _absent(self, body: Body) -> None:
        if len(body) > 5:
            del body[self._channel(body)]

    def _all_absent(self, body: Body) -> None:
        if self._rng.random() < 0.2:
            body.pop(str(self._rng.choice(["seq", "stamp", "finger", "version", "normal_force"])), None)

    def _counter(self, body: Body) -> None:
        body["seq"] = (body["seq"] + int(self._rng.choice([-2, -1, 0, 1, 3, 20_000]))) % 2**32

    def _version(self, body: Body) -> None:
        body["version"] = [1, 2, "1", 1.0, True][int(self._rng.integers(5))]

    def _finger(self, body: Body) -> None:
        body["finger"] = ["thumb", "index", "", 3][int(self._rng.integers(4))]

    def _stamp(self, body: Body) -> None:
        if self._rng.random() < 0.1:
            body["stamp"] = self.STAMPS[int(self._rng.integers(len(self.STAMPS)))]

    def _clock(self, _: Body) -> None:
        if self._left == 1:
            self._clock_off = int(self._rng.choice([0, 10**6, -(10**6), 10**10, -(10**10), 10**15]))

    def _more(self, body: Body) -> None:
        body["more"] = ["of a later version", [1.0]]

    def _frozen(self, body: Body) -> None:
        self._held = self._held or {k: v for k, v in body.items() if k not in {"seq", "stamp"}}
        body.update(self._held)

    def _whole_numbers(self, body: Body) -> None:
        name = self._channel(body)
        if isinstance(body[name], float):
            body[name] = round(body[name])

    def _slip(self, body: Body) -> None:
        body["slip"], body["slip_speed"] = 1.0, float(self._rng.choice([0.0, 1e-3, float("nan")]))
