"""States that come as frames of our own layout: answered as bytes, with no message in between.

A node that ``answers_frames`` is asked before a frame is decoded: of one frame (:class:`FramePath`), of all
frames that the virtual bus brings in one packet (:class:`PacketPath`), of all rows of a batch
(:class:`BatchPath`). What it leaves alone, and everything while it is not active, goes the way of messages.
Who watches the telemetry gets the messages all the same: they are made of what the node keeps.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import compress
from typing import Any, Final, NamedTuple, Protocol

import numpy as np

from vegrip.clock import Clock
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, SlipMargin
from vegrip.runtime.channel_watch import ChannelWatch
from vegrip.runtime.sender_watch import SenderWatch
from vegrip.runtime.statistics import LoopStatistics
from vegrip.runtime.telemetry import Direction, Telemetry
from vegrip.transport.canbus.virtual_can import Taken
from vegrip.transport.codec import Frame
from vegrip.transport.codec.batch_codec import FIRST_ROW, ROW_ID
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.endpoint import BATCHES, FRAMES, PACKETS

LONGEST_FRAME: Final = 64  # [bytes]
LEFT_ALONE: Final = 0
COMMANDED: Final = 2
REPORT: Final = 4
"""What a node says it did with a frame, in bits."""
REPORTS: Final = (ContactEstimate, SlipMargin)
"""What is told of a finger as frames."""
ROWS_EACH: Final = (2, 1)
"""Frames of a finger in them."""
REPORTING: Final = bytes(1 if outcome & REPORT else 0 for outcome in range(256))
"""Of what was done with a row: 1 where something is due to be told."""

Answered = tuple[Any, Sequence[str]]
"""What the endpoint is told, and the fingers of which something is due to be told."""
Guard = Callable[[Callable[..., Answered | None]], Callable[..., Any]]
"""Makes of what answers the function that an endpoint calls, which never raises; it returns None for None."""


class PacketAnswer(NamedTuple):
    """What was done with the first frames of a packet, each the state of another finger."""

    taken: Taken
    commands: int
    requests: memoryview  # that ask the bus to send them; valid until the next packet
    states: Sequence[tuple[str, int, int]]  # finger, what was done in bits, and arrival [ns]


class FrameNode(Protocol):
    """What is asked of a node that ``answers_frames``."""

    @property
    def frame_fingers(self) -> tuple[str, ...]:
        """The fingers whose frames it may answer."""

    @property
    def path_taken(self) -> str:
        """Which way states go, and why, in a sentence."""

    def run_compiled(self, lines: Mapping[str, Line]) -> None:
        """Prepare to answer the frames of ``lines``, as far as that is possible."""

    def number_commands_from(self, numbers: Mapping[str, int]) -> None:
        """Give every next command a number above these."""

    def leave_lines(self, name: str = "") -> None:
        """Let the codec go on with the counters of the finger ``name`` or of all."""

    def read_counters(self) -> None:
        """Bring up to date what was counted of frames, and nothing else."""

    def on_frame(self, name: str, frame: Any, length: int, arrival: int, now: int) -> int:
        """Answer a frame of the finger ``name``; return in bits what was done, LEFT_ALONE for nothing."""

    def command_frame(self, name: str) -> Any:
        """Return the frame of the last command."""

    @property
    def takes_packets(self) -> bool:
        """Whether :meth:`on_packet` answers."""

    def on_packet(self, packet: bytes, expected: int, now: int) -> PacketAnswer | None:
        """Answer the states at the beginning of a packet; None: it begins with none.

        ``expected`` is the number of its first frame if none was lost.
        """

    def on_batch(self, payload: bytes, rows: int, arrival: int, now: int) -> tuple[bytearray, int] | None:
        """Answer the rows; return what was done with each in bits, and the number of commands."""

    @property
    def batch_commands(self) -> bytearray:
        """The rows of the last commands, below a head that is still empty."""

    def names_in(self, payload: bytes, rows: int) -> Sequence[str]:
        """Return whose states the rows are, "" for another one's."""

    def felt(self, name: str) -> tuple[float, float]:
        """Return normal force [N] and displacement [m] of the last frame that was answered."""

    def state(self, name: str) -> FingertipState:
        """Return the state of the last frame that was answered."""

    def command(self, name: str) -> ForceCommand:
        """Return the command of the last frame that was answered with one."""

    def report_frames(self, name: str, now: int) -> Iterable[tuple[int, Any]]:
        """Return identifiers and frames of what is due to be told and ready as bytes."""

    def report_batch(self, names: Sequence[str], now: int) -> Sequence[str]:
        """Pack what is due to be told of fingers; return whose it is."""

    @property
    def batch_reports(self) -> tuple[bytearray, bytearray]:
        """Contacts and slip margins that were packed last, below heads that are still empty."""

    def has_more_to_tell(self, name: str, now: int) -> bool:
        """Return whether :meth:`reports` has something to tell besides."""

    def reports(self, name: str, now: int) -> Iterator[Message]:
        """Return what is due to be told besides."""


class OfLoop(NamedTuple):
    """What the loop has beside node and link."""

    clock: Clock
    statistics: LoopStatistics
    senders: SenderWatch
    """Sees every state."""
    telemetry: Telemetry | None
    """Counts, and says what is to be shown."""
    channels: ChannelWatch | None
    """Sees the first states of every finger."""


class FramePath:
    """Answers the frames of states of one node, one by one.

    Args:
        node: that answers.
        endpoint: that brings frames.
        loop: both are of.

    """

    def __init__(self, node: FrameNode, endpoint: Any, loop: OfLoop) -> None:
        self.frames = 0
        """States that went this way."""
        self.node, self._endpoint = node, endpoint
        self._clock, self._statistics, self._senders, self._telemetry, self._channels = loop
        self._fingers: tuple[str, ...] = ()
        self._knows_all = False
        self._bytes = bytearray(LONGEST_FRAME)
        self._array = np.frombuffer(self._bytes, dtype=np.uint8)
        self._lines: dict[int, tuple[str, int]] = {}  # state's identifier -> finger, command's identifier

    def prepare(self) -> None:
        """Compile what will run; the node has been configured."""
        fingers, line = self.node.frame_fingers, self._endpoint.line
        lines = {finger: found for finger in fingers if (found := line(finger)) is not None}
        self.node.run_compiled(lines)
        self._lines = {one.state_id: (finger, one.command_id) for finger, one in lines.items()}
        self._fingers, self._knows_all = tuple(lines), False

    def look(self, guard: Guard | None) -> None:
        """Look at what comes from now on, if there is anything to answer; without a guard at nothing."""
        self._endpoint.intercept = guard(self.answer) if guard is not None and self._lines else None

    def renumber(self, sent: Mapping[str, int]) -> None:
        """Go on with the numbers of commands that were sent in the node's place."""
        self.node.number_commands_from(sent)

    def knows_all(self) -> bool:
        """Return whether the channels of all fingers are known, as they are from then on."""
        if not self._knows_all:
            channels = self._channels
            self._knows_all = channels is None or all(map(channels.knows, self._fingers))
        return self._knows_all

    def answer(self, frame: Frame) -> Answered | None:
        """Answer ``frame``; None: it is left alone."""
        known = self._lines.get(frame.arbitration_id)
        if known is None or not frame.fd:
            return None
        finger, command = known
        if self._channels is not None and not self._channels.knows(finger):
            self.node.leave_lines(finger)
            return None
        length = len(frame.data)
        self._bytes[:length] = frame.data
        done = self.node.on_frame(finger, self._array, length, frame.stamp, self._clock.now())
        if done == LEFT_ALONE:
            return None
        if done & COMMANDED:
            self._endpoint.send_frame(Frame(command, self.node.command_frame(finger).tobytes(), True))
        self._note(finger, done, frame.stamp, self._clock.now())
        return True, (finger,) if done & REPORT else ()

    def reports(self, fingers: Sequence[str], now: int) -> Iterator[Message | None]:
        """Send what is due to be told of ``fingers`` that is ready as bytes; yield the rest to be sent.

        None is yielded for what was sent here.
        """
        for finger in fingers:
            if not self._is_watched(finger) and self._tell(finger, now):
                self._count_reports(finger)
                yield None
            if self.node.has_more_to_tell(finger, now):
                yield from self.node.reports(finger, now)

    def _tell(self, finger: str, now: int) -> bool:
        """Send what is due to be told of ``finger`` that is ready as bytes; return whether there was any."""
        frames = [Frame(one, data.tobytes(), True) for one, data in self.node.report_frames(finger, now)]
        self._endpoint.send_frames(frames)
        return bool(frames)

    def _note(self, finger: str, done: int, arrival: int, now: int) -> None:
        """Count what was done with a state, and show it where it is watched."""
        self.frames += 1
        if done & COMMANDED:
            self._statistics.answered(finger, arrival, now)
        else:
            self._statistics.state(finger, arrival)
        if self._senders.has_turn(finger):
            self._senders.note_values(finger, *self.node.felt(finger))
        self._show(finger, done)

    def _show(self, finger: str, done: int) -> None:
        telemetry = self._telemetry
        if telemetry is None:
            return
        if telemetry.count(FingertipState, finger, Direction.IN):
            telemetry.show(self.node.state(finger), Direction.IN)
        if done & COMMANDED and telemetry.count(ForceCommand, finger, Direction.OUT):
            telemetry.show(self.node.command(finger), Direction.OUT)

    def _is_watched(self, finger: str) -> bool:
        """Return whether the reports of ``finger`` are wanted as messages."""
        telemetry = self._telemetry
        return telemetry is not None and any(telemetry.wants(k, finger, Direction.OUT) for k in REPORTS)

    def _count_reports(self, finger: str) -> None:
        """Count reports of ``finger`` that travelled as bytes."""
        if self._telemetry is not None:
            for kind in REPORTS:
                self._telemetry.count(kind, finger, Direction.OUT)


class PacketPath(FramePath):
    """Answers packets of states, and frames where they come one by one."""

    def look(self, guard: Guard | None) -> None:
        """As :meth:`FramePath.look`."""
        super().look(guard)
        looks = guard is not None and self.node.takes_packets
        self._endpoint.intercept_packet = guard(self.answer_packet) if guard is not None and looks else None

    def answer_packet(self, packet: bytes, expected: int) -> Answered | None:
        """Answer a packet; return what was taken of it, None: nothing was."""
        if not self.knows_all():
            return None
        answer = self.node.on_packet(packet, expected, self._clock.now())
        if answer is None:
            return None
        taken, commands, requests, states = answer
        if commands:
            self._endpoint.send_requests(requests, commands)
        now = self._clock.now()
        for state in states:
            self._note(*state, now)
        return taken, [finger for finger, done, _ in states if done & REPORT]


class BatchPath(FramePath):
    """Answers the rows of batches of states."""

    def look(self, guard: Guard | None) -> None:
        """As :meth:`FramePath.look`."""
        self._endpoint.intercept_batch = (
            guard(self.answer_batch) if guard is not None and self._fingers else None
        )

    def answer_batch(self, payload: bytes, rows: int, arrival: int) -> Answered | None:
        """Answer a batch; return what was done with each row."""
        if not self.knows_all():
            self.node.leave_lines()
            return None
        answered = self.node.on_batch(payload, rows, arrival, self._clock.now())
        if answered is None:
            return None
        done, commands = answered
        if commands:
            whole = self._sealed(ForceCommand, commands, self.node.batch_commands)
            self._endpoint.send_batch(ForceCommand, whole)
        taken = rows - done.count(0, 0, rows)
        self.frames += taken
        self._statistics.batch(taken, commands, arrival, self._clock.now())
        if taken:
            self._senders.note_values(self._fingers[0], *self.node.felt(self._fingers[0]))
        names = self.node.names_in(payload, rows)
        if self._telemetry is not None and taken:
            for name, outcome in zip(names, done, strict=False):
                if outcome:
                    self._show(name, outcome)
        return done, list(compress(names, done.translate(REPORTING)))

    def reports(self, fingers: Sequence[str], now: int) -> Iterator[Message | None]:
        """As :meth:`FramePath.reports`; what is ready as bytes goes out in batches."""
        told = self.node.report_batch([f for f in fingers if not self._is_watched(f)], now)
        if told:
            for kind, each, data in zip(REPORTS, ROWS_EACH, self.node.batch_reports, strict=True):
                self._endpoint.put_off_batch(kind, self._sealed(kind, len(told) * each, data[:]))
            for finger in told:
                self._count_reports(finger)
            yield None  # the next states may have come
        for finger in fingers:
            if self.node.has_more_to_tell(finger, now):
                yield from self.node.reports(finger, now)

    def _sealed(self, kind: type[Message], rows: int, data: bytearray) -> bytearray:
        """Return the batch of the first rows of ``data``, with its head."""
        end = FIRST_ROW + rows * (ROW_ID.size + self._endpoint.batches.lengths[kind])
        whole = data if len(data) == end else data[:end]
        self._endpoint.batches.seal(whole, kind, rows)
        return whole


PATHS: Final[Mapping[str, type[FramePath]]] = {FRAMES: FramePath, PACKETS: PacketPath, BATCHES: BatchPath}
"""By what an endpoint brings."""
