"""One CAN frame as the transports hand it to the codec."""

from typing import NamedTuple


class Frame(NamedTuple):
    """A data frame with an 11-bit identifier; remote and error frames never come this far."""

    arbitration_id: int
    data: bytes
    fd: bool = False
    stamp: int = 0  # [ns] receive time; 0 on the way out
