"""Messages of one kind of all fingers of a hand in one: rows of CAN FD frames.

::

    0   header of E2E profile 4: length, counter, Data ID (CRC-32 of the topic), CRC-32
    12  version of the message set   uint8
    13  number of rows               uint8
    14  bytes of a row               uint16, least significant byte first, like all that follows
    16  rows: Data ID of the frame (uint16), then the frame of ``proto/fingertip.dbc`` as on CAN FD

So a row carries its own checksum, counter, version and time, whatever carried the batch, and a program that
reads frames reads rows. The Data ID of a row is the identifier of finger 0 on CAN plus ``ROW_STRIDE`` times
the number of the finger from 1: no frame of a bus passes for a row.
"""

import struct
from collections.abc import Sequence
from typing import Any, Final

from vegrip.errors import ConfigError
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, SlipMargin
from vegrip.transport.codec.database import layouts
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.frame_codec import FrameCodec
from vegrip.transport.codec.protection import P04, P04_HEADER, P04_LIMIT
from vegrip.transport.codec.schema import Topics, data_id_of, message_set

ROW_STRIDE: Final = 0x800
MAX_BATCH_ROWS: Final = 30  # the Data ID of a row has 16 bits
BATCH_HEAD: Final = struct.Struct("<BBH")  # version, rows, bytes of a row
ROW_ID: Final = struct.Struct("<H")
FIRST_ROW: Final = P04_HEADER + BATCH_HEAD.size
COUNTER: Final = struct.Struct(">H")  # of profile 4
COUNTER_AT: Final = 2
BATCHED_MESSAGES: Final = (FingertipState, ForceCommand, ContactEstimate, SlipMargin)
Batched = FingertipState | ForceCommand | ContactEstimate | SlipMargin


class BatchCodec(FrameCodec):
    """The batches of one hand.

    Nothing that comes from outside raises: what is refused is counted in ``rejected``, a batch as ``size``,
    ``checksum``, ``version`` or ``rows``, a row as by :class:`~vegrip.transport.codec.can_codec.CanCodec`.
    """

    def __init__(self, fingers: Sequence[str], namespace: str = "", *, use_sender_time: bool = True) -> None:
        if len(fingers) > MAX_BATCH_ROWS or len(set(fingers)) != len(fingers):
            raise ConfigError(
                f"fingers {list(fingers)} must be at most {MAX_BATCH_ROWS} different names "
                "to travel as a batch"
            )
        super().__init__(fingers)
        self._counter = 0
        schemas = message_set().messages
        prefix = Topics(namespace, fingers).prefix
        self.topics: dict[type[Any], str] = {kind: prefix + schemas[kind].batch for kind in BATCHED_MESSAGES}
        self._data_ids = {kind: data_id_of(topic) for kind, topic in self.topics.items()}
        self.bases: dict[type[Any], int] = {}
        self.lengths: dict[type[Any], int] = {}
        for layout in (one for one in layouts().layouts if one.fd and one.schema.cls in BATCHED_MESSAGES):
            self.bases[layout.schema.cls] = layout.parts[0].base
            self.lengths[layout.schema.cls] = layout.parts[0].length  # parts are of one length
            for number, finger in enumerate(fingers, start=1):
                self.add_stream(layout, finger, ROW_STRIDE * number, use_sender_time)

    def encode(self, message: Batched) -> list[Frame]:
        """Return the frames of the rows; none for a message that cannot be sent (counted in ``clipped``)."""
        return self.encode_as(message, message.finger)

    def pack(self, kind: type[Message], frames: Sequence[Frame]) -> bytearray:
        """Return the batch of the frames of one kind."""
        data = bytearray(FIRST_ROW)
        for frame in frames:
            data += ROW_ID.pack(frame.arbitration_id) + frame.data
        self.seal(data, kind, len(frames))
        return data

    def seal(self, data: bytearray, kind: type[Message], rows: int) -> None:
        """Write version, number and size of the rows that stand in ``data``, and protect it."""
        BATCH_HEAD.pack_into(data, P04_HEADER, self._version, rows, ROW_ID.size + self.lengths[kind])
        self._counter = (self._counter + 1) & 0xFFFF
        COUNTER.pack_into(data, COUNTER_AT, self._counter)
        P04.protect(data, self._data_ids[kind])

    def rows_in(self, payload: bytes, kind: type[Message]) -> int:
        """Return how many rows a batch has; -1 when it is refused, and counted."""
        why = self._objection(payload, kind)
        if why:
            self.rejected[why] += 1
            return -1
        return payload[P04_HEADER + 1]

    def frame(self, payload: bytes, kind: type[Message], row: int, stamp: int) -> Frame:
        """Return the frame of a row of a batch that was received at ``stamp`` [ns]."""
        at = FIRST_ROW + row * (ROW_ID.size + self.lengths[kind])
        (identifier,) = ROW_ID.unpack_from(payload, at)
        start = at + ROW_ID.size
        return Frame(identifier, payload[start : start + self.lengths[kind]], True, stamp)

    def decode(self, frame: Frame) -> Message | None:
        return self.decode_as(frame.arbitration_id, frame, "finger")

    def _objection(self, payload: bytes, kind: type[Message]) -> str:
        if not FIRST_ROW <= len(payload) <= P04_LIMIT:
            return "size"
        if not P04.check(payload, self._data_ids[kind]):
            return "checksum"
        version, rows, size = BATCH_HEAD.unpack_from(payload, P04_HEADER)
        if version != self._version:
            return "version"
        fits = size == ROW_ID.size + self.lengths[kind] and len(payload) == FIRST_ROW + rows * size
        return "" if fits else "rows"
