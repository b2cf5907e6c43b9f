"""The short way through the loop for single topics: the numbers of a state in, those of its command out.

As :mod:`vegrip.runtime.hot_path` for frames; what is left alone goes the way of messages.
"""

from collections.abc import Iterator, Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np

from vegrip.messages import FingertipState, Message
from vegrip.runtime.hot_path import COMMANDED, LEFT_ALONE, AnswersFrames, show
from vegrip.runtime.short_way import OfLoop, ShortWay
from vegrip.transport.codec.schema import message_set
from vegrip.transport.codec.topic_line import TopicLine
from vegrip.transport.zmq_endpoint import TopicIntercept


@runtime_checkable
class GivesTopics(Protocol):
    """An endpoint that lets others look at what comes on a topic first."""

    intercept_topic: TopicIntercept | None

    def topic_line(self, finger: str) -> TopicLine | None:
        """Return how states and commands of ``finger`` travel; None: not by topics of ours."""

    def send_payload(self, topic: bytes, payload: bytes | bytearray) -> None:
        """Publish a payload as it is."""


@runtime_checkable
class AnswersValues(AnswersFrames, Protocol):
    """A node that answers the values of states with the numbers of commands."""

    def on_values(self, name: str, values: Any, counter: int, stamp: int, arrival: int, now: int) -> int:
        """Answer the values of a state of the finger ``name``; return in bits what was done."""

    def command_numbers(self, name: str) -> tuple[int, float, float, int, int]:
        """Return counter, force [N], its change [N], reason and lifetime [ns] of the last command."""


class TopicPath(ShortWay[AnswersValues, GivesTopics]):
    """Answers the states of one node that come on topics."""

    def __init__(self, node: AnswersValues, endpoint: GivesTopics, loop: OfLoop) -> None:
        super().__init__(node, endpoint, loop)
        self._lines: dict[bytes, tuple[str, TopicLine]] = {}  # by the topic of states
        fields = message_set().messages[FingertipState].fields
        self._bytes = bytearray(8 * sum(field.kind == "float" for field in fields))
        self._values = np.frombuffer(self._bytes)

    def prepare(self) -> None:
        """Compile what will run; the node has been configured."""
        fingers = self.node.frame_fingers
        lines = {f: line for f in fingers if (line := self._endpoint.topic_line(f)) is not None}
        self.node.run_compiled(lines)
        self._lines = {line.state_topic: (finger, line) for finger, line in lines.items()}

    def look(self, intercept: TopicIntercept | None) -> None:
        """Let ``intercept`` look at payloads from now on, if there are any to answer; None: at none."""
        self._endpoint.intercept_topic = intercept if self._lines else None

    def answer(self, topic: bytes, payload: bytes, arrival: int) -> tuple[int, str]:
        """Answer a payload; return what was done, LEFT_ALONE for nothing, and the finger."""
        known = self._lines.get(topic)
        if known is None:
            return LEFT_ALONE, ""
        finger, line = known
        if self._channels is not None and not self._channels.knows(finger):
            self.node.leave_lines(finger)
            return LEFT_ALONE, finger
        found = line.unpack(payload, arrival, self._bytes)
        if found is None:
            self.node.leave_lines(finger)
            return LEFT_ALONE, finger
        now = self._clock.now()
        done = self.node.on_values(finger, self._values, *found, arrival, now)
        if done == LEFT_ALONE:
            return LEFT_ALONE, finger
        self.frames += 1
        self._statistics.state(finger, arrival)
        if done & COMMANDED:
            self._send(finger, line, now)
        if self._senders.has_turn(finger):
            self._senders.note_values(finger, *self.node.felt(finger))
        if self._telemetry is not None:
            show(self._telemetry, self.node, finger, done)
        return done, finger

    def reports(self, fingers: Sequence[str], now: int) -> Iterator[Message]:
        """Yield what is due to be told of ``fingers``."""
        for finger in fingers:
            yield from self.node.reports(finger, now)

    def _send(self, finger: str, line: TopicLine, now: int) -> None:
        seq, force, adjustment, reason, lifetime = self.node.command_numbers(finger)
        payload = line.pack(seq, now, force, adjustment, reason, now + lifetime)
        self._endpoint.send_payload(line.command_topic, payload)
        self._statistics.command(finger, self._clock.now())
