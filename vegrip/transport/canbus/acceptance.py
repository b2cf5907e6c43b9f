"""Acceptance filters: which frames a member of the virtual bus is brought, as a real controller does.

A filter is a pair of identifier and mask, with the bits of ``struct can_filter`` of Linux: a frame passes
when it equals the identifier in all bits of the mask. Bit 31 stands for 29-bit identifiers.
"""

import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from vegrip.transport.canbus.bus_records import MOST_FILTERS

EXTENDED_FLAG: Final = 1 << 31

_HEAD = struct.Struct("<QIBB")  # as of a request; what follows is no frame of this length
_MARK: Final = 64  # among the flags of a request
_PAIR = struct.Struct("<II")

Pair = tuple[int, int]
_EVERYTHING: Final[Pair] = (0, 0)


def pairs_of(filters: Iterable[Mapping[str, Any]]) -> list[Pair]:
    """Return python-can's ``filters`` as pairs of identifier and mask; without ``extended`` both kinds pass.

    Raises:
        ValueError: there are more than ``MOST_FILTERS``, or a number does not fit.

    """
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
    if len(pairs) > MOST_FILTERS:
        raise ValueError(f"there are {len(pairs)} filters; a node may have {MOST_FILTERS}")
    return pairs


def pack_filters(pairs: Sequence[Pair]) -> bytes:
    """Return the packet by which a member says what it wants to hear; without any it hears everything."""
    pairs = pairs or (_EVERYTHING,)
    return _HEAD.pack(0, len(pairs), _MARK, 0) + b"".join(_PAIR.pack(*pair) for pair in pairs)


def unpack_filters(packet: bytes) -> list[Pair] | None:
    """Return the filters of a packet; None when it is another one."""
    if len(packet) < _HEAD.size:
        return None
    _, count, flags, _ = _HEAD.unpack_from(packet)
    if flags != _MARK or not 1 <= count <= MOST_FILTERS or len(packet) != _HEAD.size + count * _PAIR.size:
        return None
    return list(_PAIR.iter_unpack(packet[_HEAD.size :]))
