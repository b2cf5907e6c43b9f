"""One identifier -> the messages of its kind and finger."""

from typing import Any, Final

from vegrip.codec.assembly import Assembly, Whole
from vegrip.codec.encoder import MICROSECOND, TIME_MODULUS
from vegrip.codec.frame import Frame
from vegrip.codec.layout import Layout, Part
from vegrip.messages import Message

HALF: Final = TIME_MODULUS // 2


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
    ) -> None:
        self.assembly = assembly
        self._layout = layout
        self._part = part
        self._identifier = identifier
        self._owner = owner
        self._version = version % part.version_modulus
        self._use_sender_time = use_sender_time and part.time is not None
        self._make: Any = layout.schema.cls

    def decode(self, frame: Frame) -> Message | str | None:
        """Return the completed message, None while parts are missing, or the name of the fault."""
        part = self._part
        if frame.fd != part.fd:
            return "layout"
        if len(frame.data) != part.length:
            return "length"
        if not part.profile.check(frame.data, self._identifier):
            return "checksum"
        cells = part.packer.unpack(frame.data)
        if part.version.get(cells) != self._version:
            return "version"
        last = part.last is None or part.last.get(cells) == 1
        time = 0 if part.time is None else int(part.time.get(cells))
        whole = self.assembly.put(part.number, int(part.counter.get(cells)), last, cells, frame.stamp, time)
        return self._message(whole) if isinstance(whole, Whole) else whole

    def _message(self, whole: Whole) -> Message | str:
        cells = whole.cells
        values = [read(cells) for read in self._layout.readers]
        if None in values:
            return "value"
        stamp = _sender_stamp(whole) if self._use_sender_time else whole.stamp
        for index in self._layout.relative:
            values[index] += stamp
        message: Message = self._make(stamp, self._owner, whole.seq, *values)
        return message


def _sender_stamp(whole: Whole) -> int:
    """Return the sender's time: the one nearest to the receive time that has the bits on the wire [ns]."""
    received = whole.stamp // MICROSECOND
    return (received + (whole.time - received + HALF) % TIME_MODULUS - HALF) * MICROSECOND
