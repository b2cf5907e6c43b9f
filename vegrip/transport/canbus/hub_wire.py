"""The bytes between the virtual CAN bus and its members: greeting, filters, requests, deliveries, errors.

One packet brings the greeting of a newcomer, the filters of a member, or frames: requests, to the bus, or
numbered deliveries, from it, one behind the other. A member that has not asked for several at once gets them
one by one.

A filter is a pair of identifier and mask, with the bits of ``struct can_filter`` of Linux: a frame passes
when it equals the identifier in all bits of the mask. Bit 31 stands for 29-bit identifiers.
"""

import json
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final, NamedTuple

from vegrip.config import build, parameter
from vegrip.errors import ConfigError
from vegrip.transport.canbus import bus_records as wire
from vegrip.transport.canbus.bus_events import ErrorState, NodeFaults
from vegrip.transport.canbus.frame_time import FD_SIZES, FRAME_KINDS, BitTiming, BusFrame, has_form

HUB_VERSION = 5
MAX_PACKET_BYTES = 512  # bytes of a packet with one frame; the greeting is the longest
MAX_GATHERED_BYTES = wire.GATHERED_BYTES  # bytes of a packet with several deliveries or requests
MOST_REQUESTS = 16  # in one packet
MAX_REASON_CHARS: Final = 200  # characters; the answer must fit into a packet


# --- greeting: checked by one rule where it is sent and received


@dataclass(frozen=True)
class Greeting:
    """What a newcomer says; ``build`` refuses everything that has another type or is out of bounds."""

    version: int = parameter(HUB_VERSION)
    timing: BitTiming = parameter(BitTiming())
    must_match_rates: bool = parameter(False, doc="the bit rates must be these")
    wants_own_frames: bool = parameter(False, doc="it wants to receive its own frames")
    listen_only: bool = parameter(False)
    patience: float = parameter(
        -1.0, unit="s", low=-1.0, high=0.1, doc="frames may wait so long to share a packet; negative: none do"
    )
    faults: NodeFaults = parameter(NodeFaults())


def make_greeting(table: Mapping[str, Any]) -> bytes:
    """Return the packet that says ``table``, without what is None."""
    given = {name: value for name, value in table.items() if value is not None}
    return json.dumps(asdict(build(Greeting, given, "virtual CAN bus"))).encode()


def read_greeting(packet: bytes) -> Greeting:
    try:
        said = json.loads(packet)
    except (ValueError, RecursionError):
        said = None
    if not isinstance(said, dict):
        raise ConfigError("it does not speak the language of this bus")
    try:
        if said.get("version") != HUB_VERSION:
            raise ConfigError(
                f"its version is {said.get('version')}, that of the bus {HUB_VERSION}; "
                "stop the older programs"
            )
        return build(Greeting, said, "greeting")
    except (ConfigError, TypeError) as error:
        plain = "".join(c if c.isascii() and c.isprintable() else "?" for c in str(error))
        raise ConfigError(plain[:MAX_REASON_CHARS]) from None


# --- filters

EXTENDED_FLAG: Final = 1 << 31
_MARK: Final = 64  # among the flags of a request
_PAIR = struct.Struct("<II")
Pair = tuple[int, int]
_EVERYTHING: Final[Pair] = (0, 0)


def pairs_of(filters: Iterable[Mapping[str, Any]]) -> list[Pair]:
    """Return python-can's ``filters`` as identifiers and masks; without ``extended`` both kinds pass."""
    pairs: list[Pair] = []
    for given in filters:
        identifier, mask = int(given["can_id"]), int(given["can_mask"])
        if not (0 <= identifier < 1 << 32 and 0 <= mask < 1 << 32):
            raise ValueError(f"a filter has 32 bits: can_id {identifier:#x}, can_mask {mask:#x}")
        identifier, mask = identifier & ~EXTENDED_FLAG, mask & ~EXTENDED_FLAG
        if "extended" in given:
            identifier |= EXTENDED_FLAG if given["extended"] else 0
            mask |= EXTENDED_FLAG
        pairs.append((identifier, mask))
    if len(pairs) > wire.MOST_FILTERS:
        raise ValueError(f"there are {len(pairs)} filters; a node may have {wire.MOST_FILTERS}")
    return pairs


def pack_filters(pairs: Sequence[Pair]) -> bytes:
    """Return the packet by which a member says what it wants to receive; without any, everything."""
    pairs = pairs or (_EVERYTHING,)
    return REQUEST.pack(0, len(pairs), _MARK, 0) + b"".join(_PAIR.pack(*pair) for pair in pairs)


def unpack_filters(packet: bytes) -> list[Pair] | None:
    """Return the filters of a packet; None when it is another one."""
    if len(packet) < REQUEST.size:
        return None
    _, count, flags, _ = REQUEST.unpack_from(packet)
    if (
        flags != _MARK
        or not 1 <= count <= wire.MOST_FILTERS
        or len(packet) != REQUEST.size + count * _PAIR.size
    ):
        return None
    return list(_PAIR.iter_unpack(packet[REQUEST.size :]))


# --- requests

REQUEST = struct.Struct("<QIBB")  # time, identifier, flags, length code; then the data
_CODES = {size: code for code, size in enumerate(FD_SIZES)}
REQUEST_AT = {"time": 0, "identifier": 8, "flags": 12, "code": 13, "data": REQUEST.size}
"""Where what lies in a request, for those who go through its bytes without this module."""
RATE_SWITCH = wire.SWITCH
"""Flag of a frame with bit-rate switch."""
PLAIN_FLAGS = wire.FD | wire.SWITCH
"""Of a CAN FD data frame with 11 bits as a node sends it."""


def pack_request(time: int, identifier: int, data: bytes, flags: int, code: int = -1) -> bytes:
    """Return the packet that asks for a frame, queued at ``time`` [ns]; KeyError: none has such a length."""
    return REQUEST.pack(time, identifier, flags, _CODES[len(data)] if code < 0 else code) + data


# --- deliveries

DELIVERY = struct.Struct("<IQQHIBB")  # number, end, busy, node, identifier, flags, length code; then the data
DELIVERY_AT = {
    "number": 0,
    "end": 4,
    "busy": 12,
    "identifier": 22,
    "flags": 26,
    "code": 27,
    "data": DELIVERY.size,
}
"""Where what lies in a delivery, likewise."""


class Delivery(NamedTuple):
    """A frame that went over the bus, as every member gets it."""

    number: int  # of the frame for this member, modulo 2^32; a gap shows frames lost for want of reading
    end: int  # [ns] monotonic, when the frame was complete
    busy: int  # [ns] for how long the bus has carried frames by then, this one included
    node: int  # who sent it
    identifier: int
    flags: int
    code: int
    data: bytes

    @property
    def is_error(self) -> bool:
        """Whether it is an error frame: identifier and data are those of SocketCAN (linux/can/error.h)."""
        return bool(self.flags & wire.ERROR)

    @property
    def frame(self) -> BusFrame:
        return BusFrame(self.identifier, self.data, *FRAME_KINDS[self.flags % wire.ERROR], self.code)


def split_deliveries(packet: bytes) -> list[bytes]:
    """Return the deliveries of a packet; one that is cut off at the end is left as it is."""
    found, at = [], 0
    while len(packet) - at >= DELIVERY.size:
        flags, code = packet[at + DELIVERY_AT["flags"]], packet[at + DELIVERY_AT["code"]]
        length = 0 if flags & wire.REMOTE or code >= len(FD_SIZES) else FD_SIZES[code]
        end = at + DELIVERY.size + length
        found.append(packet[at:end])
        at = end
    return [*found, packet[at:]] if at < len(packet) or not found else found


def unpack_delivery(packet: bytes) -> Delivery | None:
    """Return the delivery of a packet; None when it is not one."""
    if len(packet) < DELIVERY.size:
        return None
    found = Delivery._make((*DELIVERY.unpack_from(packet), packet[DELIVERY.size :]))
    return found if has_form(found.identifier, found.flags, found.code, len(found.data)) else None


def reported_state(classes: int, detail: bytes) -> ErrorState | None:
    """Return the state of the controller that an error frame reports, None if it reports none."""
    if classes & wire.BUS_OFF:
        return ErrorState.OFF
    if classes & wire.RESTARTED:
        return ErrorState.ACTIVE
    if classes & wire.CONTROLLER and len(detail) > 1:
        if detail[1] & (wire.RECEIVE_PASSIVE | wire.TRANSMIT_PASSIVE):
            return ErrorState.PASSIVE
        if detail[1] & wire.ERROR_ACTIVE:
            return ErrorState.ACTIVE
    return None
