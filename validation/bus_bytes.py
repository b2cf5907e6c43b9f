"""The bytes of the virtual bus from its other side: requests taken apart, deliveries made."""

from validation.faults.simulated_bus import Transmission
from vegrip.transport.canbus.frame_time import FD_SIZES, FRAME_KINDS, KIND_FLAGS, BusFrame, has_form
from vegrip.transport.canbus.hub_wire import DELIVERY, REQUEST, pack_request


def request_of(time: int, frame: BusFrame) -> bytes:
    """Return the request for ``frame``, queued at ``time`` [ns]."""
    return pack_request(time, frame.identifier, frame.data, KIND_FLAGS[frame[2:7]], frame.code)


def unpack_request(packet: bytes) -> tuple[int, BusFrame] | None:
    """Return time and frame; None when the packet is not a request."""
    if len(packet) < REQUEST.size:
        return None
    time, identifier, flags, code = REQUEST.unpack_from(packet)
    data = packet[REQUEST.size :]
    if not has_form(identifier, flags, code, len(data)):
        return None
    return time, BusFrame(identifier, data, *FRAME_KINDS[int(flags) % len(FRAME_KINDS)], code)


def split_requests(packet: bytes) -> list[tuple[int, BusFrame]]:
    """Return times and frames of a packet with several requests; none where it is not one throughout."""
    found, at = [], 0
    while at < len(packet):
        code = packet[at + REQUEST.size - 1] if len(packet) - at >= REQUEST.size else len(FD_SIZES)
        if code >= len(FD_SIZES):
            return []
        end = at + REQUEST.size + FD_SIZES[code]
        asked = unpack_request(packet[at:end])
        if asked is None:
            return []
        found.append(asked)
        at = end
    return found


def delivery_of(number: int, sent: Transmission, busy: int) -> bytes:
    """Return the bytes that bring a finished frame, by its number for one member."""
    frame = sent.frame
    about = sent.node, frame.identifier, KIND_FLAGS[frame[2:7]], frame.code
    return DELIVERY.pack(number & 0xFFFFFFFF, sent.end, busy, *about) + frame.data
