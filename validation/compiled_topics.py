"""The compiled finger step against the objects on single topics: the states of a log in msgpack."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from validation.compiled_finger import SILENCES, Event, Log, Replay
from validation.liars import PayloadLiar
from vegrip.grip.batch_text import COMMANDED
from vegrip.grip.finger import LEFT_ALONE, REPORT
from vegrip.grip.parameters import GraspParameters
from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.transport.codec import CanCodec
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.codec.topic_line import TopicLine

VALUES = 9  # doubles of a state


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
            self.node.leave_lines(event.finger)
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
