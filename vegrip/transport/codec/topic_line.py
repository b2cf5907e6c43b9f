"""States and commands of one finger on topics, as numbers: for a program that needs no messages of them."""

import math
import struct
from typing import Any, Final

import msgpack

from vegrip.messages import FingertipState, ForceCommand
from vegrip.transport.codec.line import TOPIC
from vegrip.transport.codec.packing import INT64_MAX, INT64_MIN, MSGPACK_LIMITS, SEQUENCE_MODULUS
from vegrip.transport.codec.protection import P04, P04_COUNTER, P04_HEADER, P04_LIMIT
from vegrip.transport.codec.schema import message_set
from vegrip.transport.codec.sequence import Sequence
from vegrip.transport.codec.topics import Route
from vegrip.types import NamedNumbers

FARTHEST_NS: Final = 1 << 61
"""[ns] A stamp so far from its arrival, 73 years, is left to messages: their numbers have no end."""
NOTHING_CAME: Final = 1 << 62  # [ns] see vegrip.grip.kernels.watchdog
TIMES: Final = ("INPUT_STAMP", "INPUT_QUICKEST", "SAMPLE_STAMP", "SAMPLE_INFORMED")
NUMBER: Final = frozenset({float, int})  # whole ones come from other languages
NO_FRAME: Final = -1

_NAN = math.nan


class TopicLine:
    """Topics of a finger, and the counter of its states.

    Args:
        finger: its name.
        states: where its states come.
        commands: where its commands go.
        sequence: of its states.
        use_sender_time: whether states keep the sender's stamps.

    """

    wire: str = TOPIC
    state_id = command_id = NO_FRAME
    report_ids: tuple[int, ...] = ()

    def __init__(
        self, finger: str, states: Route, commands: Route, sequence: Sequence, *, use_sender_time: bool
    ) -> None:
        self.state_topic, self.command_topic = states.topic.encode(), commands.topic.encode()
        self._finger, self._sequence, self._use_sender_time = finger, sequence, use_sender_time
        self._state_id, self._command_id = states.data_id, commands.data_id
        self._version = message_set().version
        fields = message_set().messages[FingertipState].fields
        self._channels = tuple(field.name for field in fields if field.kind == "float")
        self._pack_values = struct.Struct(f"={len(self._channels)}d").pack_into
        self._packer = msgpack.Packer()
        self._command: dict[str, Any] = {"version": self._version}
        self._command |= {field.name: 0 for field in message_set().messages[ForceCommand].fields}
        self._command["finger"] = finger

    def carries(self, lifetime: float) -> bool:  # noqa: ARG002 (as other lines)
        """Return whether a command can say that it lives for ``lifetime`` [s]."""
        return True

    def can_hand_over(self, memory: NamedNumbers) -> bool:
        """Return whether the times in a ``memory`` are so near that their differences fit into 64 bits."""
        times = [int(memory[name]) for name in TIMES]
        return all(abs(time) < FARTHEST_NS or time == NOTHING_CAME for time in times)

    def write_to(self, memory: NamedNumbers, lifetime: float) -> None:  # noqa: ARG002 (as other lines)
        """Put the counter into a memory."""
        self._sequence.write_to(memory)

    def read_from(self, memory: NamedNumbers) -> None:
        """Take the counter back."""
        self._sequence.read_from(memory)

    def unpack(self, payload: bytes, arrival: int, values: bytearray) -> tuple[int, int] | None:
        """Put the values of the state in a ``payload``, which came at ``arrival`` [ns], into ``values``.

        Returns:
            Counter and stamp [ns]; None where the codec of messages refuses the payload, or has to look at
            its values more closely.

        """
        body = self._body(payload)
        if body is None:
            return None
        get = body.get
        measured = [get(name, _NAN) for name in self._channels]
        seq, stamp = get("seq"), get("stamp")
        if not NUMBER.issuperset(map(type, measured)) or type(seq) is not int or type(stamp) is not int:
            return None
        if not 0 <= seq < SEQUENCE_MODULUS or int.from_bytes(payload[P04_COUNTER], "big") != seq & 0xFFFF:
            return None
        if not (INT64_MIN <= stamp <= INT64_MAX and abs(stamp - arrival) < FARTHEST_NS):
            return None
        self._pack_values(values, 0, *measured)
        return seq, stamp if self._use_sender_time else arrival

    def pack(
        self, seq: int, stamp: int, force: float, adjustment: float, reason: int, expires: int
    ) -> bytearray:
        """Return the payload of a command; the numbers are finite."""
        body = self._command
        body["seq"], body["stamp"], body["expires"] = seq % SEQUENCE_MODULUS, stamp, expires
        body["normal_force"], body["adjustment"], body["reason"] = force, adjustment, reason
        data = bytearray(P04_HEADER)
        data += self._packer.pack(body)
        data[P04_COUNTER] = (seq & 0xFFFF).to_bytes(2, "big")
        P04.protect(data, self._command_id)
        return data

    def _body(self, payload: bytes) -> dict[str, Any] | None:
        if not P04_HEADER < len(payload) <= P04_LIMIT or not P04.check(payload, self._state_id):
            return None
        try:
            body = msgpack.unpackb(payload[P04_HEADER:], **MSGPACK_LIMITS)
        except (ValueError, msgpack.UnpackException):
            return None
        is_ours = type(body) is dict and body.get("version") == self._version
        return body if is_ours and body.get("finger") == self._finger else None
