"""The bus of :mod:`vegrip.transport.canbus` on a simulated clock: time comes in, events come out."""

from collections.abc import Mapping
from contextlib import suppress
from enum import Enum
from functools import cache
from types import ModuleType
from typing import NamedTuple

from vegrip.c99.host import CompilerError
from vegrip.host import compiled_folder
from vegrip.host.compiled_folder import compiler
from vegrip.transport.canbus import bus as text
from vegrip.transport.canbus import bus_records as wire
from vegrip.transport.canbus import carry as python
from vegrip.transport.canbus.bus_events import ErrorState
from vegrip.transport.canbus.bus_model import BusModel
from vegrip.transport.canbus.compiled_bus import CompiledBus, compile_library, is_wanted, library_name, load
from vegrip.transport.canbus.frame_bits import data_bytes
from vegrip.transport.canbus.frame_time import FRAME_KINDS, BitTiming, BusFrame, write_record

Counters = tuple[int, int]
"""The transmit and the receive error counter of a node."""


class Transmission(NamedTuple):
    """A frame that was on the bus."""

    start: int  # [ns]
    end: int  # [ns] the bus is free again and every node has the frame
    node: int
    frame: BusFrame
    is_lost: bool = False  # no node receives it
    missed_by: int = wire.NOBODY  # an error-passive node that misread it, alone


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


@cache
def compiled() -> CompiledBus | None:
    """Return the functions of the library, compiled if need be; None: C is not wanted, or not possible."""
    if not is_wanted():
        return None
    path = compiled_folder.found_library(library_name())
    if path is None and compiler() is not None:
        with suppress(OSError, CompilerError):
            path = compile_library()
    return None if path is None else load(path)


def read_record(record: wire.Frame) -> BusFrame:
    kind, length = FRAME_KINDS[int(record.flags)], data_bytes(record)
    code = record.code if kind.is_remote else -1
    return BusFrame(record.identifier, bytes(record.data[:length]), *kind, code)


ERROR_KINDS = {
    wire.BIT_ERROR: ErrorKind.BIT,
    wire.STUFF_ERROR: ErrorKind.STUFF,
    wire.ACK_ERROR: ErrorKind.ACK,
}


class SimulatedBus(BusModel):
    """A bus and its nodes; without ``functions`` those in C carry frames where that is possible."""

    def __init__(self, timing: BitTiming, functions: ModuleType | CompiledBus | None = None) -> None:
        super().__init__(timing, functions or compiled() or python)

    def request(self, time: int, node: int, frame: BusFrame) -> bool:
        """Queue ``frame`` of ``node`` at ``time`` [ns]; refused from a node that is off or only listens."""
        write_record(frame, self.record.asked)
        return text.queue_frame(self.record, self._slots[node], time, self.record.asked)

    def state(self, node: int) -> ErrorState:
        return ErrorState(self.node(node).state)

    def counters(self, node: int) -> Counters:
        asked = self.node(node)
        return asked.transmit, asked.receive

    def advance(self, now: int) -> list[Event]:
        """Let time pass up to ``now`` [ns] and return what was finished, in order."""
        events: list[Event] = []
        while self._functions.advance(self._bus, now):
            events += self._happened()
        return events

    def conclude(self, now: int) -> list[Event]:
        """Finish the frame on the bus if it has ended by ``now`` [ns], but begin no other.

        For members that must know of it before the next arbitration.
        """
        return self._happened() if self._functions.conclude(self._bus, now) else []

    def next_event(self) -> int | None:
        """Return when :meth:`advance` will have something to do [ns]; None: not before the next request."""
        event = self._functions.next_event(self._bus)
        return None if event == wire.NO_EVENT else event

    def _happened(self) -> list[Event]:
        bus, done = self.record, self.record.done
        events: list[Event] = []
        for event in bus.events[: bus.happened]:
            if event.kind == wire.CHANGED:
                counters, state = (event.transmit, event.receive), ErrorState(event.state)
                events.append(StateChange(event.time, event.number, state, counters, event.dropped))
                continue
            about = done.start, done.end, done.number, read_record(done.frame)
            if event.kind == wire.SENT:
                events.append(Transmission(*about, done.is_lost, done.missed_by))
            else:
                counts = {number: self.counters(number) for number in self._slots}
                events.append(BusError(*about, ERROR_KINDS[done.error], done.found_by, counts))
        self._forget()
        return events
