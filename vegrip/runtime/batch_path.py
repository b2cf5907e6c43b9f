"""The short way through the loop for a batch: states of all fingers in, their commands out, one call.

As :mod:`vegrip.runtime.hot_path` for the frames of single fingers; what is left alone goes the way of
messages.
"""

from collections.abc import Collection, Iterator, Sequence
from itertools import compress
from typing import Protocol, runtime_checkable

from vegrip.messages import ForceCommand, Message
from vegrip.runtime.hot_path import REPORT, REPORTS, AnswersFrames, count_reports, is_watched, show
from vegrip.runtime.short_way import OfLoop, ShortWay
from vegrip.transport.batch_endpoint import BatchIntercept
from vegrip.transport.codec.batch_codec import FIRST_ROW, ROW_ID, BatchCodec
from vegrip.transport.codec.line import Line


@runtime_checkable
class GivesBatches(Protocol):
    """An endpoint that lets others look at a batch of states first."""

    intercept_batch: BatchIntercept | None
    batches: BatchCodec

    def line(self, finger: str) -> Line | None:
        """Return how states and commands of ``finger`` travel within a batch."""

    def send_batch(self, kind: type[Message], payload: bytes | bytearray) -> None:
        """Send a batch as it is."""

    def put_off_batch(self, kind: type[Message], payload: bytes | bytearray) -> None:
        """Send a batch behind the next one."""


@runtime_checkable
class AnswersBatches(AnswersFrames, Protocol):
    """A node that answers the states of all fingers at once."""

    def on_batch(self, payload: bytes, rows: int, arrival: int, now: int) -> tuple[bytearray, int] | None:
        """Answer the rows; return what was done with each in bits, and the number of commands."""

    @property
    def batch_commands(self) -> bytearray:
        """The rows of the last commands, below a head that is still empty."""

    def report_batch(self, names: Sequence[str], now: int) -> Sequence[str]:
        """Pack what is due to be told of fingers; return whose it is."""

    @property
    def batch_reports(self) -> tuple[bytearray, bytearray]:
        """Contacts and slip margins that were packed last, below heads that are still empty."""

    def names_in(self, payload: bytes, rows: int) -> Sequence[str]:
        """Return whose states the rows are, "" for another one's."""


REPORTING = bytes(1 if outcome & REPORT else 0 for outcome in range(256))
"""Of what was done with a row: 1 where something is due to be told."""
ROWS_EACH = (2, 1)
"""Rows of a finger in the batches of :data:`~vegrip.runtime.hot_path.REPORTS`."""


class BatchPath(ShortWay[AnswersBatches, GivesBatches]):
    """Answers the batches of states of one node."""

    def __init__(self, node: AnswersBatches, endpoint: GivesBatches, loop: OfLoop) -> None:
        super().__init__(node, endpoint, loop)
        self._fingers: tuple[str, ...] = ()

    def prepare(self) -> None:
        """Compile what will run; the node has been configured."""
        lines = {f: line for f in self.node.frame_fingers if (line := self._endpoint.line(f)) is not None}
        self.node.run_compiled(lines)
        self._fingers, self._knows_all = tuple(lines), False

    def look(self, intercept: BatchIntercept | None) -> None:
        """Let ``intercept`` look at the batches from now on, if there are any to answer; None: at none."""
        self._endpoint.intercept_batch = intercept if self._fingers else None

    def answer(self, payload: bytes, rows: int, arrival: int) -> tuple[Sequence[int], Collection[str]] | None:
        """Answer a batch; return what was done with each row and who has something to report, or None."""
        telemetry = self._telemetry
        if not self.knows_all(self._fingers):
            self.node.leave_lines()
            return None
        answered = self.node.on_batch(payload, rows, arrival, self._clock.now())
        if answered is None:
            return None
        done, commands = answered
        if commands:
            self._send(commands)
        taken = rows - done.count(0, 0, rows)
        self.frames += taken
        self._statistics.batch(taken, commands, arrival, self._clock.now())
        if taken:
            self._senders.note_values(self._fingers[0], *self.node.felt(self._fingers[0]))
        names = self.node.names_in(payload, rows)
        if telemetry is not None and taken:
            for name, outcome in zip(names, done, strict=False):
                if outcome:
                    show(telemetry, self.node, name, outcome)
        return done, list(compress(names, done.translate(REPORTING)))

    def reports(self, fingers: Sequence[str], now: int) -> Iterator[Message | None]:
        """As :meth:`vegrip.runtime.hot_path.HotPath.reports`; what is ready as bytes goes out in batches."""
        telemetry = self._telemetry
        packed = fingers if telemetry is None else [f for f in fingers if not is_watched(telemetry, f)]
        told = self.node.report_batch(packed, now)
        if told:
            for kind, rows, data in zip(REPORTS, ROWS_EACH, self.node.batch_reports, strict=True):
                self._put_off(kind, len(told) * rows, data)
            for finger in told:
                count_reports(telemetry, finger)
            yield None  # the next states may have come
        for finger in fingers:
            if self.node.has_more_to_tell(finger, now):
                yield from self.node.reports(finger, now)

    def _send(self, commands: int) -> None:
        data, end = self.node.batch_commands, self._end_of(ForceCommand, commands)
        whole = data if len(data) == end else data[:end]
        self._endpoint.batches.seal(whole, ForceCommand, commands)
        self._endpoint.send_batch(ForceCommand, whole)

    def _put_off(self, kind: type[Message], rows: int, data: bytearray) -> None:
        whole = data[: self._end_of(kind, rows)]  # a copy, for the next reports come into ``data``
        self._endpoint.batches.seal(whole, kind, rows)
        self._endpoint.put_off_batch(kind, whole)

    def _end_of(self, kind: type[Message], rows: int) -> int:
        """Return the length of a batch of so many ``rows``."""
        return FIRST_ROW + rows * (ROW_ID.size + self._endpoint.batches.lengths[kind])
