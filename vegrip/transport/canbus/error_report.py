"""What a controller tells its program of errors on the bus, in the form of SocketCAN (linux/can/error.h).

An error frame of SocketCAN is a frame with classes of errors as its identifier and eight bytes of detail:
[1] state of the controller, [2] kind and [3] place of a protocol error, [6] and [7] the error counters.
"""

from typing import Final

from vegrip.transport.canbus.bus_events import ErrorState

CONTROLLER: Final = 0x004
PROTOCOL: Final = 0x008
ACKNOWLEDGEMENT: Final = 0x020
BUS_OFF: Final = 0x040
BUS_ERROR: Final = 0x080
RESTARTED: Final = 0x100
HAS_COUNTERS: Final = 0x200

RECEIVE_PASSIVE: Final = 0x10
TRANSMIT_PASSIVE: Final = 0x20
PASSIVE: Final = RECEIVE_PASSIVE | TRANSMIT_PASSIVE
ERROR_ACTIVE: Final = 0x40

OF_BIT, OF_STUFFING, SENDING = 0x01, 0x04, 0x80
ACK_SLOT, IN_DATA = 0x19, 0x0A


def reported_state(classes: int, detail: bytes) -> ErrorState | None:
    """Return the state of the controller that an error frame tells, None if it tells none."""
    if classes & BUS_OFF:
        return ErrorState.OFF
    if classes & RESTARTED:
        return ErrorState.ACTIVE
    if classes & CONTROLLER and len(detail) > 1:
        if detail[1] & PASSIVE:
            return ErrorState.PASSIVE
        if detail[1] & ERROR_ACTIVE:
            return ErrorState.ACTIVE
    return None
