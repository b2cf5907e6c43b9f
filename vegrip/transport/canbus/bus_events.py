"""What happens on a CAN bus, as :class:`~vegrip.transport.canbus.bus_model.BusModel` tells it."""

from collections.abc import Mapping
from enum import Enum, IntEnum
from typing import NamedTuple

from vegrip.transport.canbus.bus_records import ACTIVE, NOBODY, OFF, PASSIVE
from vegrip.transport.canbus.frame_time import BusFrame

Counters = tuple[int, int]
"""The transmit and the receive error counter of a node."""


class ErrorState(IntEnum):
    """What a node may still do."""

    ACTIVE = ACTIVE  # signals errors with dominant bits, which all others see
    PASSIVE = PASSIVE  # signals them with recessive bits, and waits 8 bits after each frame of its own
    OFF = OFF  # takes no part in the bus


class Transmission(NamedTuple):
    """A frame that was on the bus."""

    start: int  # [ns]
    end: int  # [ns] the bus is free again and every node has the frame
    node: int
    frame: BusFrame
    is_lost: bool = False  # no node receives it
    missed_by: int = NOBODY  # an error-passive node that misread it, alone


class ErrorKind(Enum):
    """What was found wrong with a frame."""

    BIT = "bit"  # the sender read back another bit than it sent
    STUFF = "stuff"  # one receiver misread a bit
    ACK = "acknowledgement"  # no node acknowledged


class BusError(NamedTuple):
    """An error frame."""

    start: int  # [ns] of the frame that went wrong
    end: int  # [ns] the bus is free again
    node: int  # that sent the frame
    frame: BusFrame
    kind: ErrorKind
    found_by: int  # node
    counters: Mapping[int, Counters]  # of every node, by now


class StateChange(NamedTuple):
    """A node that went to another error state."""

    time: int  # [ns]
    node: int
    state: ErrorState
    counters: Counters
    dropped: int = 0  # frames that waited in a node that is off now


Event = Transmission | BusError | StateChange
