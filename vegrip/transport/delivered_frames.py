"""What waits on the virtual bus, taken at once: for a program that looks at it seldom and keeps all."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.transport.canbus.bus_records import FD, SWITCH
from vegrip.transport.canbus.frame_time import FD_SIZES
from vegrip.transport.canbus.hub_wire import DELIVERY_AT
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.transport.codec.frame import FrameBlock

Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]


class Head(NamedTuple):
    """Where a delivery has what the bus says of its frame: bytes from its begin."""

    number: int  # 4 bytes
    end: int  # 8 bytes [ns]
    busy: int  # 8 bytes [ns]
    identifier: int  # 4 bytes
    flags: int
    code: int  # of the length
    mask: int  # of the flags that matter
    wanted: int  # what they are for a CAN FD data frame with 11 bits
    data: int  # where they begin


HEAD: Final = np.array(list(Head(**DELIVERY_AT, mask=~SWITCH & 0xFF, wanted=FD)))
SIZES: Final = np.array(FD_SIZES)


def take_block(bus: VegripBus) -> FrameBlock | None:
    """Return the frames that have come; None: something else than CAN FD frames is there, to be received."""
    data = bus.take_packets()
    if data is None:
        return None
    found, last = np.zeros((len(data) // DELIVERY_AT["data"], 4), np.int64), np.zeros(3, np.int64)
    count = find_frames(np.frombuffer(data, np.uint8), HEAD, SIZES, found, last)
    if count < 0:
        bus.put_back(data)
        return None
    if count:
        first, end, busy = last.tolist()
        bus.count_deliveries(first, count, end, busy)
    return FrameBlock(data, found[:count])


@njit
def _get(row: Bytes, at: int, size: int) -> int:
    number = 0
    for i in range(size):
        number |= int(row[at + i]) << 8 * i
    return number


@njit
def find_frames(data: Bytes, head: Integers, sizes: Integers, found: Integers, last: Integers) -> int:
    """Find CAN FD data frames with 11 bits among deliveries that stand one behind the other.

    Return how many these are; -1 where one is something else or does not follow the one before.

    Args:
        data: the deliveries.
        head: a :class:`Head`.
        sizes: of frames by their code [bytes].
        found: (m, 4) takes identifier, end [ns], begin of the data and its length.
        last: takes number of the first, end and busy [ns] of the last.

    """
    at, count, start = 0, 0, head[8]
    while at < len(data):
        if len(data) - at < start or count == len(found):
            return -1
        row = data[at:]
        number, identifier, code = _get(row, head[0], 4), _get(row, head[3], 4), row[head[5]]
        if count == 0:
            last[0] = number
        follows = number == (last[0] + count) & 0xFFFFFFFF
        if not follows or row[head[4]] & head[6] != head[7] or code >= len(sizes) or identifier >> 11:
            return -1
        last[1], last[2] = _get(row, head[1], 8), _get(row, head[2], 8)
        found[count, 0], found[count, 1] = identifier, last[1]
        found[count, 2], found[count, 3] = at + start, sizes[code]
        at += start + sizes[code]
        count += 1
    return count if at == len(data) else -1
