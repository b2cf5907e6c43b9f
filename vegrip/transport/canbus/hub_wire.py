"""The bytes between the virtual CAN bus and its members: one packet, one frame.

A member that has asked for it gets several deliveries in one packet, one behind the other.
"""

import struct
from collections.abc import Sequence
from typing import NamedTuple

from vegrip.transport.canbus.bus_events import Transmission
from vegrip.transport.canbus.bus_records import ERROR, FD, GATHERED_BYTES, REMOTE, SWITCH
from vegrip.transport.canbus.frame_time import FD_SIZES, FRAME_KINDS, KIND_FLAGS, BusFrame

HUB_VERSION = 5
MAX_PACKET_BYTES = 512  # bytes of a packet with one frame; the greeting is the longest
MAX_GATHERED_BYTES = GATHERED_BYTES  # bytes of a packet with several deliveries or requests
MOST_REQUESTS = 16  # in one packet
_REQUEST = struct.Struct("<QIBB")  # time, identifier, flags, length code; then the data
_NUMBER = struct.Struct("<I")  # then the delivery, the same bytes for every member
_DELIVERY = struct.Struct("<QQHIBB")  # end, busy, node, identifier, flags, length code; then the data

_PLAIN = struct.Struct("<IQQHIBB")  # number and delivery at once
_CODES = {size: code for code, size in enumerate(FD_SIZES)}

REQUEST_AT = {"time": 0, "identifier": 8, "flags": 12, "code": 13, "data": _REQUEST.size}
"""Where what lies in a request, for those who go through its bytes without this module."""
DELIVERY_AT = {
    "number": 0,
    "end": 4,
    "busy": 12,
    "identifier": 22,
    "flags": 26,
    "code": 27,
    "data": _PLAIN.size,
}
"""Where what lies in a numbered delivery, likewise."""
NUMBER_AT, END_AT, BUSY_AT, IDENTIFIER_AT, FLAGS_AT, CODE_AT, _ = DELIVERY_AT.values()
PLAIN_PLACES = (NUMBER_AT, END_AT, BUSY_AT, IDENTIFIER_AT, FLAGS_AT, CODE_AT)
"""The same of its head, in that order."""
RATE_SWITCH = SWITCH
"""Flag of a frame with bit-rate switch."""
PLAIN_FLAGS = FD | SWITCH
"""Of a CAN FD data frame with 11 bits as a node sends it."""


class Delivery(NamedTuple):
    """A frame that went over the bus, as every member gets it."""

    end: int  # [ns] monotonic, when the frame was complete
    busy: int  # [ns] for how long the bus has carried frames by then, this one included
    number: int  # of the frame for this member, modulo 2^32; a gap shows frames lost for want of reading
    node: int  # who sent it
    frame: BusFrame
    is_error: bool = False  # an error frame: identifier and data as in vegrip.transport.canbus.error_report


def pack_request(time: int, frame: BusFrame) -> bytes:
    """Return the packet that asks for ``frame`` to be sent, queued at ``time`` [ns]."""
    return _REQUEST.pack(time, frame.identifier, _flags(frame), frame.code) + frame.data


def unpack_request(packet: bytes) -> tuple[int, BusFrame] | None:
    """Return time and frame; None when the packet is not a request."""
    if len(packet) < _REQUEST.size:
        return None
    time, identifier, flags, code = _REQUEST.unpack_from(packet)
    frame = _frame(identifier, flags, code, packet[_REQUEST.size :])
    return None if frame is None else (time, frame)


def split_requests(packet: bytes) -> list[tuple[int, BusFrame]]:
    """Return times and frames of a packet with several requests; none where it is not one throughout."""
    found, at = [], 0
    while at < len(packet):
        code = packet[at + _REQUEST.size - 1] if len(packet) - at >= _REQUEST.size else len(FD_SIZES)
        if code >= len(FD_SIZES):
            return []
        end = at + _REQUEST.size + FD_SIZES[code]
        asked = unpack_request(packet[at:end])
        if asked is None:
            return []
        found.append(asked)
        at = end
    return found


def pack_plain_request(time: int, identifier: int, data: bytes) -> bytes | None:
    """Return what :func:`pack_request` returns for a CAN FD data frame; None: there is no such length."""
    code = _CODES.get(len(data))
    return None if code is None else _REQUEST.pack(time, identifier, FD | SWITCH, code) + data


def plain_requests(identifiers: Sequence[int], length: int) -> bytearray:
    """Return a packet that asks for CAN FD data frames of ``length`` bytes, all zero, queued at time zero.

    Each request begins with its time, and its data are at ``REQUEST_AT["data"]``.

    Raises:
        ValueError: no frame has that length, or there are too many for one packet.

    """
    packed = [pack_plain_request(0, identifier, bytes(length)) for identifier in identifiers]
    if None in packed or len(packed) > MOST_REQUESTS:
        raise ValueError(f"{len(packed)} frames of {length} bytes do not fit into a packet")
    return bytearray(b"".join(one for one in packed if one is not None))


def unpack_plain(packet: bytes) -> tuple[int, int, int, int, bytes] | None:
    """Return number, end, busy, identifier and data of a CAN FD data frame with 11 bits.

    None for any other packet, which :func:`unpack_delivery` looks into.
    """
    if len(packet) < _PLAIN.size:
        return None
    number, end, busy, _, identifier, flags, code = _PLAIN.unpack_from(packet)
    data = packet[_PLAIN.size :]
    if flags & ~SWITCH != FD or code > 15 or identifier >> 11 or len(data) != FD_SIZES[code]:
        return None
    return number, end, busy, identifier, data


def plain_flags(length: int) -> tuple[int, int, int]:
    """Return what makes a delivery that of a CAN FD data frame of ``length`` bytes with 11 bits.

    The flags that matter, what they are then, and the code of the length.
    """
    return ~SWITCH & 0xFF, FD, _CODES[length]


def pack_delivery(sent: Transmission, busy: int) -> bytes:
    """Return the packet that brings a finished frame to the members, still without its number."""
    frame = sent.frame
    head = _DELIVERY.pack(sent.end, busy, sent.node, frame.identifier, _flags(frame), frame.code)
    return head + frame.data


def numbered(number: int, delivery: bytes) -> bytes:
    """Return ``delivery`` with the number that it has for one member."""
    return _NUMBER.pack(number & 0xFFFFFFFF) + delivery


def split_deliveries(packet: bytes) -> list[bytes]:
    """Return the numbered deliveries of a packet; one that is cut off at the end is left as it is."""
    found, at = [], 0
    while len(packet) - at >= _PLAIN.size:
        flags, code = packet[at + _PLAIN.size - 2], packet[at + _PLAIN.size - 1]
        length = 0 if flags & REMOTE or code >= len(FD_SIZES) else FD_SIZES[code]
        end = at + _PLAIN.size + length
        found.append(packet[at:end])
        at = end
    return [*found, packet[at:]] if at < len(packet) or not found else found


def unpack_delivery(packet: bytes) -> Delivery | None:
    """Return the delivery of a numbered packet; None when it is not one."""
    start = _NUMBER.size + _DELIVERY.size
    if len(packet) < start:
        return None
    (number,) = _NUMBER.unpack_from(packet)
    end, busy, node, identifier, flags, code = _DELIVERY.unpack_from(packet, _NUMBER.size)
    frame = _frame(identifier, flags, code, packet[start:])
    return None if frame is None else Delivery(end, busy, number, node, frame, bool(flags & ERROR))


def _flags(frame: BusFrame) -> int:
    return KIND_FLAGS[frame[2:7]]


def _frame(identifier: int, flags: int, code: int, data: bytes) -> BusFrame | None:
    kind = FRAME_KINDS[flags % ERROR]
    if code > (15 if kind.fd else 8) or identifier >> (29 if kind.extended else 11):
        return None
    if len(data) != (0 if kind.is_remote else FD_SIZES[code]):
        return None
    return BusFrame(identifier, data, *kind, code)
