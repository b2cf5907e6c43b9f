"""The short way through the loop: a frame of a state in, the frame of its command out, no message in between.

A node that can answer frames (:class:`AnswersFrames`) on a bus that gives them (:class:`GivesFrames`) is
asked before a frame is decoded. What the node leaves alone, and everything while it is not active, goes the
way of messages. Who watches the telemetry gets the messages all the same: they are made of what the node
keeps.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np

from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, SlipMargin
from vegrip.runtime.short_way import OfLoop, ShortWay
from vegrip.runtime.telemetry import Direction, Telemetry
from vegrip.transport.codec import Frame
from vegrip.transport.codec.line import Line
from vegrip.transport.endpoint import Intercept

LONGEST_FRAME: Final = 64  # [bytes]
LEFT_ALONE: Final = 0
COMMANDED: Final = 2
REPORT: Final = 4
"""What a node says it did with a frame, in bits."""


@runtime_checkable
class GivesFrames(Protocol):
    """An endpoint that lets others look at a frame first."""

    intercept: Intercept | None

    def line(self, finger: str) -> Line | None:
        """Return how states and commands of ``finger`` travel; None: not by single frames."""

    def send_frame(self, frame: Frame) -> None:
        """Send a frame as it is."""


@runtime_checkable
class AnswersFrames(Protocol):
    """A node that answers frames without messages."""

    @property
    def frame_fingers(self) -> tuple[str, ...]:
        """The fingers whose frames it may answer."""

    def number_commands_from(self, numbers: Mapping[str, int]) -> None:
        """Give every next command a number above these."""

    def run_compiled(self, lines: Mapping[str, Line]) -> None:
        """Prepare to answer the frames of ``lines``, as far as that is possible."""

    def on_frame(self, name: str, frame: Any, length: int, arrival: int, now: int) -> int:
        """Answer a frame of the finger ``name``; return in bits what was done, LEFT_ALONE for nothing."""

    def command_frame(self, name: str) -> Any:
        """Return the frame of the last command."""

    def felt(self, name: str) -> tuple[float, float]:
        """Return normal force [N] and displacement [m] of the last frame that was answered."""

    def state(self, name: str) -> FingertipState:
        """Return the state of the last frame that was answered."""

    def command(self, name: str) -> ForceCommand:
        """Return the command of the last frame that was answered with one."""

    def reports(self, name: str, now: int) -> Iterator[Message]:
        """Return what is due to be told besides."""

    def report_frames(self, name: str, now: int) -> Iterable[tuple[int, Any]]:
        """Return identifiers and frames of what is due to be told and ready as bytes."""

    def has_more_to_tell(self, name: str, now: int) -> bool:
        """Return whether :meth:`reports` has something to tell besides."""

    @property
    def path_taken(self) -> str:
        """Which way states go, and why, in a sentence."""

    def leave_lines(self, name: str = "") -> None:
        """Let the codec go on with the counters of the finger ``name`` or of all."""

    def read_counters(self) -> None:
        """Bring up to date what was counted of frames, and nothing else."""


class HotPath(ShortWay[AnswersFrames, GivesFrames]):
    """Answers the frames of states of one node."""

    def __init__(self, node: AnswersFrames, endpoint: GivesFrames, loop: OfLoop) -> None:
        super().__init__(node, endpoint, loop)
        self._bytes = bytearray(LONGEST_FRAME)
        self._array = np.frombuffer(self._bytes, dtype=np.uint8)
        self._lines: dict[int, tuple[str, int]] = {}  # state's identifier -> finger, command's identifier

    def prepare(self) -> None:
        """Compile what will run; the node has been configured."""
        fingers = self.node.frame_fingers
        lines = {finger: line for finger in fingers if (line := self._endpoint.line(finger)) is not None}
        self.node.run_compiled(lines)
        self._lines = {line.state_id: (finger, line.command_id) for finger, line in lines.items()}
        self._knows_all = False

    def look(self, intercept: Intercept | None) -> None:
        """Let ``intercept`` look at the frames from now on, if there are any to answer; None: at none."""
        self._endpoint.intercept = intercept if self._lines else None

    def answer(self, frame: Frame) -> tuple[int, str]:
        """Answer ``frame``; return what was done, LEFT_ALONE for nothing, and the finger."""
        known = self._lines.get(frame.arbitration_id)
        if known is None or not frame.fd:
            return LEFT_ALONE, ""
        finger, command = known
        telemetry, length = self._telemetry, len(frame.data)
        if self._channels is not None and not self._channels.knows(finger):
            self.node.leave_lines(finger)
            return LEFT_ALONE, finger
        self._bytes[:length] = frame.data
        done = self.node.on_frame(finger, self._array, length, frame.stamp, self._clock.now())
        if done == LEFT_ALONE:
            return done, finger
        self.frames += 1
        if done & COMMANDED:
            self._endpoint.send_frame(Frame(command, self.node.command_frame(finger).tobytes(), True))
            self._statistics.answered(finger, frame.stamp, self._clock.now())
        else:
            self._statistics.state(finger, frame.stamp)
        if self._senders.has_turn(finger):
            self._senders.note_values(finger, *self.node.felt(finger))
        if telemetry is not None:
            show(telemetry, self.node, finger, done)
        return done, finger

    def reports(self, fingers: Sequence[str], now: int) -> Iterator[Message | None]:
        """Send what is due to be told of ``fingers`` that is ready as bytes; yield the rest to be sent.

        None is yielded for what was sent here.
        """
        for finger in fingers:
            if not is_watched(self._telemetry, finger):
                frames = list(self.node.report_frames(finger, now))
                for identifier, data in frames:
                    self._endpoint.send_frame(Frame(identifier, data.tobytes(), True))
                if frames:
                    count_reports(self._telemetry, finger)
                    yield None
            if self.node.has_more_to_tell(finger, now):
                yield from self.node.reports(finger, now)


REPORTS: Final = (ContactEstimate, SlipMargin)
"""What travels as :meth:`AnswersFrames.report_frames`."""


def is_watched(telemetry: Telemetry | None, finger: str) -> bool:
    """Return whether the reports of ``finger`` are wanted as messages."""
    return telemetry is not None and any(telemetry.wants(kind, finger, Direction.OUT) for kind in REPORTS)


def count_reports(telemetry: Telemetry | None, finger: str) -> None:
    """Count reports of ``finger`` that travelled as bytes."""
    if telemetry is not None:
        for kind in REPORTS:
            telemetry.count(kind, finger, Direction.OUT)


def show(telemetry: Telemetry, node: AnswersFrames, finger: str, done: int) -> None:
    """Count what was ``done`` with a frame of ``finger``, and show it where it is watched."""
    if telemetry.count(FingertipState, finger, Direction.IN):
        telemetry.show(node.state(finger), Direction.IN)
    if done & COMMANDED and telemetry.count(ForceCommand, finger, Direction.OUT):
        telemetry.show(node.command(finger), Direction.OUT)
