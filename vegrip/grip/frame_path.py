"""States that come as frames of our own layout: answered as bytes, with no message in between.

They come one by one (:class:`FramePath`), in a packet of the virtual bus (:class:`PacketPath`), or as rows of
a batch (:class:`BatchPath`). What is left alone, and everything while the node is not active, goes the way of
messages. Who watches the telemetry gets the messages all the same: they are made of what the fingers keep.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import compress
from typing import Any, Final, Protocol

import numpy as np

from vegrip.grip.compiled_rows import LONGEST_FRAME, CompiledBatch, CompiledPackets, PacketAnswer
from vegrip.grip.finger import GraspFinger
from vegrip.grip.wires import COMMANDED, LEFT_ALONE, REPORT
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, SlipMargin
from vegrip.runtime.node import Answered, OfLoop
from vegrip.runtime.telemetry import Direction
from vegrip.transport.codec import Frame
from vegrip.transport.codec.batch_codec import FIRST_ROW, ROW_ID
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.endpoint import BATCHES, FRAMES, PACKETS

REPORTS: Final = (ContactEstimate, SlipMargin)
"""The reports of a finger as frames."""
ROWS_EACH: Final = (2, 1)
"""Frames of a finger in them."""
REPORTING: Final = bytes(1 if outcome & REPORT else 0 for outcome in range(256))
"""Of what was done with a row: 1 where something is due to be reported."""

Guard = Callable[[Callable[..., Answered | None]], Callable[..., Any]]
"""Makes of what answers the function that an endpoint calls, which never raises; it returns None for None."""


class FrameNode(Protocol):
    """A node that answers frames: :class:`vegrip.grip.node.GraspForce`, which documents its methods."""

    batch: CompiledBatch | None
    packets: CompiledPackets | None

    @property
    def fingers(self) -> Mapping[str, GraspFinger]: ...
    def run_compiled(self, lines: Mapping[str, Line], mode: str = "") -> None: ...
    def leave_lines(self, name: str = "") -> None: ...
    def on_frame(self, name: str, frame: np.ndarray, length: int, arrival: int, now: int) -> int: ...
    def on_batch(self, payload: bytes, rows: int, arrival: int, now: int) -> tuple[bytearray, int] | None: ...
    def on_packet(self, packet: bytes, expected: int, now: int) -> PacketAnswer | None: ...
    def reports(self, name: str, now: int) -> Iterator[Message]: ...


class FramePath:
    """Answers the frames of states of one node, one by one."""

    def __init__(self, node: FrameNode, endpoint: Any, loop: OfLoop) -> None:
        self.frames = 0
        """States that went this way."""
        self._node, self._endpoint = node, endpoint
        self._clock, self._statistics, self._senders, self._telemetry, self._channels = loop
        self._fingers: tuple[str, ...] = ()
        self._knows_all = False
        self._bytes = bytearray(LONGEST_FRAME)
        self._array = np.frombuffer(self._bytes, dtype=np.uint8)
        self._lines: dict[int, tuple[str, int]] = {}  # state's identifier -> finger, command's identifier

    def prepare(self) -> None:
        """Compile what will run; the node has been configured."""
        line = self._endpoint.line
        lines = {finger: found for finger in self._node.fingers if (found := line(finger)) is not None}
        self._node.run_compiled(lines)
        self._lines = {one.state_id: (finger, one.command_id) for finger, one in lines.items()}
        self._fingers, self._knows_all = tuple(lines), False

    def look(self, guard: Guard | None) -> None:
        """Look at what comes from now on, if there is anything to answer; without a guard at nothing."""
        self._endpoint.intercept = guard(self.answer) if guard is not None and self._lines else None

    def renumber(self, sent: Mapping[str, int]) -> None:
        """Go on with the numbers of commands that were sent in the node's place."""
        for name, number in sent.items():
            if name in self._node.fingers:
                self._node.fingers[name].number_from(number)

    def read_counters(self) -> None:
        """Bring up to date what was counted of frames; the steps go on counting."""
        for finger in self._node.fingers.values():
            finger.numbers.read_counters()

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
            self._node.leave_lines(finger)
            return None
        length = len(frame.data)
        self._bytes[:length] = frame.data
        done = self._node.on_frame(finger, self._array, length, frame.stamp, self._clock.now())
        if done == LEFT_ALONE:
            return None
        if done & COMMANDED:
            self._endpoint.send_frame(
                Frame(command, self._node.fingers[finger].numbers.answer_frame.tobytes(), True)
            )
        self._note(finger, done, frame.stamp, self._clock.now())
        return True, (finger,) if done & REPORT else ()

    def reports(self, fingers: Sequence[str], now: int) -> Iterator[Message | None]:
        """Send what is due to be reported of ``fingers`` that is ready as bytes; yield the rest to be sent.

        None is yielded for what was sent here.
        """
        for name, finger in self._of(fingers).items():
            if (
                not self._is_watched(name)
                and finger.numbers.is_on_line
                and finger.numbers.report_as_frames(now)
            ):
                pairs = zip(finger.numbers.on_wire.report_ids, finger.numbers.report_frames, strict=True)
                self._endpoint.send_frames([Frame(one, data.tobytes(), True) for one, data in pairs])
                self._count_reports(name)
                yield None
            if finger.reports.are_due(now):
                yield from self._node.reports(name, now)

    def _of(self, names: Sequence[str]) -> dict[str, GraspFinger]:
        return {name: self._node.fingers[name] for name in names if name in self._node.fingers}

    def _note(self, finger: str, done: int, arrival: int, now: int) -> None:
        self.frames += 1
        if done & COMMANDED:
            self._statistics.answered(finger, arrival, now)
        else:
            self._statistics.state(finger, arrival)
        if self._senders.has_turn(finger):
            self._senders.note_values(finger, *self._node.fingers[finger].numbers.felt())
        self._show(finger, done)

    def _show(self, finger: str, done: int) -> None:
        telemetry = self._telemetry
        if telemetry is None:
            return
        if telemetry.count(FingertipState, finger, Direction.IN):
            telemetry.show(self._node.fingers[finger].numbers.state(), Direction.IN)
        if done & COMMANDED and telemetry.count(ForceCommand, finger, Direction.OUT):
            telemetry.show(self._node.fingers[finger].command(), Direction.OUT)

    def _is_watched(self, finger: str) -> bool:
        telemetry = self._telemetry
        return telemetry is not None and any(telemetry.wants(k, finger, Direction.OUT) for k in REPORTS)

    def _count_reports(self, finger: str) -> None:
        if self._telemetry is not None:
            for kind in REPORTS:
                self._telemetry.count(kind, finger, Direction.OUT)


class PacketPath(FramePath):
    """Answers packets of states, and frames where they come one by one."""

    def look(self, guard: Guard | None) -> None:
        super().look(guard)
        looks = guard is not None and self._node.packets is not None
        self._endpoint.intercept_packet = guard(self.answer_packet) if guard is not None and looks else None

    def answer_packet(self, packet: bytes, expected: int) -> Answered | None:
        """Answer a packet; return what was taken of it, None: nothing was."""
        if not self.knows_all():
            return None
        answer = self._node.on_packet(packet, expected, self._clock.now())
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
        self._endpoint.intercept_batch = (
            guard(self.answer_batch) if guard is not None and self._fingers else None
        )

    def answer_batch(self, payload: bytes, rows: int, arrival: int) -> Answered | None:
        """Answer a batch; return what was done with each row."""
        if not self.knows_all():
            self._node.leave_lines()
            return None
        answered, batch = self._node.on_batch(payload, rows, arrival, self._clock.now()), self._node.batch
        if answered is None or batch is None:
            return None
        done, commands = answered
        if commands:
            whole = self._sealed(ForceCommand, commands, batch.commands)
            self._endpoint.send_batch(ForceCommand, whole)
        taken = rows - done.count(0, 0, rows)
        self.frames += taken
        self._statistics.batch(taken, commands, arrival, self._clock.now())
        if taken:
            self._senders.note_values(self._fingers[0], *self._node.fingers[self._fingers[0]].numbers.felt())
        names = batch.names_in(payload, rows)
        if self._telemetry is not None and taken:
            for name, outcome in zip(names, done, strict=False):
                if outcome:
                    self._show(name, outcome)
        return done, list(compress(names, done.translate(REPORTING)))

    def reports(self, fingers: Sequence[str], now: int) -> Iterator[Message | None]:
        """As :meth:`FramePath.reports`; what is ready as bytes goes out in batches."""
        batch, of = self._node.batch, self._of(fingers)
        packed = (
            [] if batch is None else batch.report([name for name in of if not self._is_watched(name)], now)
        )
        if batch is not None and packed:
            for kind, each, data in zip(REPORTS, ROWS_EACH, (batch.contacts, batch.margins), strict=True):
                self._endpoint.put_off_batch(kind, self._sealed(kind, len(packed) * each, data[:]))
            for name in packed:
                self._count_reports(name)
            yield None  # the next states may have come
        for name, finger in of.items():
            if finger.reports.are_due(now):
                yield from self._node.reports(name, now)

    def _sealed(self, kind: type[Message], rows: int, data: bytearray) -> bytearray:
        end = FIRST_ROW + rows * (ROW_ID.size + self._endpoint.batches.lengths[kind])
        whole = data if len(data) == end else data[:end]
        self._endpoint.batches.seal(whole, kind, rows)
        return whole


PATHS: Final[Mapping[str, type[FramePath]]] = {FRAMES: FramePath, PACKETS: PacketPath, BATCHES: BatchPath}
"""By what an endpoint brings."""
