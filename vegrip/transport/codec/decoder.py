"""One identifier -> the messages of its kind and finger."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final

from vegrip.messages import Message, make_row
from vegrip.transport.codec.assembly import Assembly, Whole
from vegrip.transport.codec.encoder import MICROSECOND, TIME_MODULUS
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.layout import Layout, Part
from vegrip.transport.codec.members import Cells

HALF: Final = TIME_MODULUS // 2

HandClock = Callable[[int, int], int]
"""From the hand's stamp and the receive time to the time on our clock, all in ns."""


class Decoder:
    """Checks and reads the frames of one part of one kind of message of one finger (or node).

    Args:
        layout: the kind of message.
        part: the part of it that comes with this identifier.
        assembly: shared by the parts.
        identifier: also the Data ID of the E2E protection.
        owner: name of the finger or node.
        version: of the message set.
        use_sender_time: stamp with the sender's time where the frame has it.
        clock: maps the sender's time to ours, where the frame has it.

    """

    def __init__(
        self,
        layout: Layout,
        part: Part,
        assembly: Assembly,
        identifier: int,
        owner: str,
        version: int,
        use_sender_time: bool,
        clock: HandClock | None = None,
    ) -> None:
        self.assembly = assembly
        self.kind: type[Any] = layout.schema.cls
        self.owner = owner
        self.part = part
        self.version = version % part.version_modulus
        self._layout = layout
        self._identifier = identifier
        self._clock = clock if part.time is not None else None
        self._use_sender_time = (use_sender_time or clock is not None) and part.time is not None
        kind = self.kind
        self._make: Any = partial(make_row, kind) if issubclass(kind, tuple) else lambda row: kind(*row)
        self._check = part.profile.check
        self._unpack = part.packer.unpack
        self._fd, self._length, self._number = part.fd, part.length, part.number
        self._places = *part.version.bits, *part.counter.bits
        self._last = None if part.last is None else part.last.bits
        self._time: Any = part.time.get if part.time is not None else None

    @property
    def identifier(self) -> int:
        """Of the frames."""
        return self._identifier

    @property
    def uses_sender_time(self) -> bool:
        """Whether messages are stamped with the sender's time."""
        return self._use_sender_time

    def decode(self, frame: Frame) -> Message | str | None:
        """Return the completed message, None while parts are missing, or the name of the fault."""
        _, data, fd, stamp = frame
        if fd != self._fd:
            return "layout"
        if len(data) != self._length:
            return "length"
        if not self._check(data, self._identifier):
            return "checksum"
        cells = self._unpack(data)
        version, shift, mask, at, counter_shift, counter_mask = self._places
        if cells[version] >> shift & mask != self.version:
            return "version"
        counter = cells[at] >> counter_shift & counter_mask
        time = self._time(cells) if self._use_sender_time else 0
        if self._last is None:  # the only part: nothing to put together
            seq = self.assembly.sequence.advance(counter, stamp)
            return "counter" if seq is None else self._message(cells, seq, stamp, time)
        at, shift, mask = self._last
        last = cells[at] >> shift & mask == 1
        whole = self.assembly.put(self._number, counter, last, cells, stamp, time)
        return self._message(*whole) if isinstance(whole, Whole) else whole

    def _message(self, cells: Cells, seq: int, received: int, time: int) -> Message | str:
        values = self._layout.read(cells)
        if values is None:
            return "value"
        stamp = self.stamp(received, time) if self._use_sender_time else received
        if self._layout.relative:
            values = _absolute(values, self._layout.relative, stamp)
        message: Message = self._make((stamp, self.owner, seq, *values))
        return message

    def stamp(self, received: int, time: int) -> int:
        """Return the stamp of a message received at ``received`` [ns] with the sender's ``time`` [us]."""
        stamp = _sender_stamp(received, time) if self._use_sender_time else received
        return stamp if self._clock is None else self._clock(stamp, received)


def _absolute(values: Sequence[Any], relative: tuple[int, ...], stamp: int) -> list[Any]:
    return [stamp + value if index in relative else value for index, value in enumerate(values)]


def _sender_stamp(received: int, time: int) -> int:
    """Return the instant nearest to ``received`` [ns] whose microseconds end in the bits ``time``."""
    now = received // MICROSECOND
    return (now + (time - now + HALF) % TIME_MODULUS - HALF) * MICROSECOND
