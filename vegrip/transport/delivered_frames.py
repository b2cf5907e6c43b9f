"""What waits on the virtual bus, taken at once: for a program that looks at it seldom and keeps all."""

from typing import Final

import numpy as np

from vegrip.transport.canbus.frame_time import FD_SIZES
from vegrip.transport.canbus.hub_wire import DELIVERY_AT, PLAIN_PLACES, plain_flags
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.transport.codec.command_reader import RowHead
from vegrip.transport.codec.frame import FrameBlock
from vegrip.transport.codec.row_kernels import find_frames

HEAD: Final = np.array(RowHead(*PLAIN_PLACES, *plain_flags(0), DELIVERY_AT["data"]))
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
