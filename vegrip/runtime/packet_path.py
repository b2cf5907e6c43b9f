"""The short way through the loop for frames that come together: a packet of states in, commands out.

The virtual bus brings frames that end together in one packet. What of it the node leaves alone goes the way
of single frames, see :mod:`vegrip.runtime.hot_path`, as does everything on other buses.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol, runtime_checkable

from vegrip.messages import Message
from vegrip.runtime.hot_path import (
    COMMANDED,
    REPORT,
    AnswersFrames,
    GivesFrames,
    HotPath,
    count_reports,
    is_watched,
    show,
)
from vegrip.runtime.short_way import OfLoop
from vegrip.transport.canbus.virtual_can import LookAtPacket, Taken

FRAMES_EACH = 3
"""Frames of a finger's report: both of a contact, and that of a slip margin."""


class PacketAnswer(NamedTuple):
    """What was done with the first frames of a packet, each the state of another finger."""

    taken: Taken
    commands: int
    requests: memoryview  # that ask the bus to send them; valid until the next packet
    states: Sequence[tuple[str, int, int]]  # finger, what was done in bits, and arrival [ns]


@runtime_checkable
class GivesPackets(GivesFrames, Protocol):
    """An endpoint that lets others look at a packet first."""

    intercept_packet: LookAtPacket | None

    @property
    def takes_requests(self) -> bool:
        """Whether :meth:`send_requests` can be used."""

    def send_requests(self, requests: bytes | memoryview, count: int) -> None:
        """Send ``count`` frames that are packed as requests already."""


@runtime_checkable
class AnswersPackets(AnswersFrames, Protocol):
    """A node that answers the states of a packet at once."""

    @property
    def takes_packets(self) -> bool:
        """Whether :meth:`on_packet` answers."""

    def on_packet(self, packet: bytes, expected: int, now: int) -> PacketAnswer | None:
        """Answer the states at the beginning of a packet; None: it begins with none.

        ``expected`` is the number of its first frame if none was lost.
        """

    def report_packet(self, name: str, now: int) -> memoryview | None:
        """Return requests to send what is due to be told of a finger, None where :meth:`reports` has it."""


class PacketPath(HotPath):
    """Answers packets of states of one node, and frames where they come one by one."""

    def __init__(self, node: AnswersPackets, endpoint: GivesPackets, loop: OfLoop) -> None:
        super().__init__(node, endpoint, loop)
        self._packets, self._link = node, endpoint

    def look_at_packets(self, intercept: LookAtPacket | None) -> None:
        """Let ``intercept`` look at packets from now on, if there are any to answer; None: at none."""
        self._link.intercept_packet = intercept if self._packets.takes_packets else None

    def answer_packet(self, packet: bytes, expected: int) -> tuple[Taken, list[str]] | None:
        """Answer a packet; return what was taken of it and who has something to report, None: nothing was."""
        if not self.knows_all(self._packets.frame_fingers):
            return None
        answer = self._packets.on_packet(packet, expected, self._clock.now())
        if answer is None:
            return None
        taken, commands, requests, states = answer
        if commands:
            self._link.send_requests(requests, commands)
        self.frames += len(states)
        self._note(states)
        return taken, [finger for finger, done, _ in states if done & REPORT]

    def _note(self, states: Sequence[tuple[str, int, int]]) -> None:
        """Count what was done, and show it where it is watched."""
        statistics, telemetry, now = self._statistics, self._telemetry, self._clock.now()
        for finger, done, arrival in states:
            if done & COMMANDED:
                statistics.answered(finger, arrival, now)
            else:
                statistics.state(finger, arrival)
            if self._senders.has_turn(finger):
                self._senders.note_values(finger, *self.node.felt(finger))
            if telemetry is not None:
                show(telemetry, self.node, finger, done)

    def reports(self, fingers: Sequence[str], now: int) -> Iterator[Message | None]:
        """As :meth:`HotPath.reports`; where packets can be sent, those of a finger travel in one."""
        if not (self._packets.takes_packets and self._link.takes_requests):
            yield from super().reports(fingers, now)
            return
        for finger in fingers:
            requests = None
            if not is_watched(self._telemetry, finger):
                requests = self._packets.report_packet(finger, now)
            if requests is not None:
                self._link.send_requests(requests, FRAMES_EACH)
                count_reports(self._telemetry, finger)
                yield None
            if self.node.has_more_to_tell(finger, now):
                yield from self.node.reports(finger, now)
