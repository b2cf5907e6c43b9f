"""What a controller tells its program of errors on the bus, in the form of SocketCAN (linux/can/error.h).

An error frame of SocketCAN is a frame with classes of errors as its identifier and eight bytes of detail:
[1] state of the controller, [2] kind and [3] place of a protocol error, [6] and [7] the error counters.
"""

from typing import Final

from vegrip.transport.canbus.bus_events import BusError, Counters, ErrorKind, StateChange
from vegrip.transport.canbus.fault_confinement import ErrorState

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

_BIT, _STUFF, _SENDING = 0x01, 0x04, 0x80
_ACK_SLOT, _DATA = 0x19, 0x0A

Report = tuple[int, bytes]
"""Identifier (classes) and the eight bytes."""


def error_report(error: BusError, node: int) -> Report:
    """Return what the controller of ``node`` says of ``error``."""
    sending = _SENDING if error.node == node else 0
    if error.kind is ErrorKind.ACK:
        classes, kind, place = ACKNOWLEDGEMENT, sending, _ACK_SLOT
    elif error.kind is ErrorKind.BIT and sending:
        classes, kind, place = PROTOCOL, _BIT | sending, _DATA
    else:
        classes, kind, place = PROTOCOL, _STUFF | sending, _DATA
    return classes | BUS_ERROR | HAS_COUNTERS, _detail(0, kind, place, error.counters[node])


def state_report(change: StateChange) -> Report:
    """Return what a controller says of its own new state."""
    counters = change.counters
    if change.state is ErrorState.OFF:
        return BUS_OFF | HAS_COUNTERS, _detail(0, 0, 0, counters)
    if change.state is ErrorState.ACTIVE:
        restarted = RESTARTED if counters == (0, 0) else 0
        return CONTROLLER | restarted | HAS_COUNTERS, _detail(ERROR_ACTIVE, 0, 0, counters)
    transmit, receive = counters
    which = TRANSMIT_PASSIVE if transmit >= receive else RECEIVE_PASSIVE
    return CONTROLLER | HAS_COUNTERS, _detail(which, 0, 0, counters)


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


def _detail(state: int, kind: int, place: int, counters: Counters) -> bytes:
    transmit, receive = (min(count, 255) for count in counters)
    return bytes([0, state, kind, place, 0, 0, transmit, receive])
