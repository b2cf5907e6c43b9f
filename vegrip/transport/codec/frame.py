"""One CAN frame as the transports hand it to the codec."""

from typing import Final, NamedTuple

EXTENDED: Final = 1 << 31
"""Set in the identifier of a frame whose identifier has 29 bits, as SocketCAN does."""


class Frame(NamedTuple):
    """A data frame; remote and error frames never come this far."""

    arbitration_id: int
    data: bytes
    fd: bool = False
    stamp: int = 0  # [ns] receive time; 0 on the way out
