"""A CAN bus in Python's terms: nodes by number, frames, and what happens as a list.

The bus itself is :mod:`vegrip.transport.canbus.bus`; it runs on the wall clock
(:mod:`vegrip.transport.canbus.hub`), and on a simulated one where faults are put in (``validation``).
"""

from collections.abc import Sequence
from ctypes import addressof, byref, memset
from random import Random
from types import ModuleType
from typing import Any

from vegrip.errors import ConfigError
from vegrip.transport.canbus import bus as text
from vegrip.transport.canbus import carry as python
from vegrip.transport.canbus.bus_events import (
    NO_FAULTS,
    BusError,
    Counters,
    ErrorKind,
    ErrorState,
    Event,
    NodeFaults,
    StateChange,
    Transmission,
)
from vegrip.transport.canbus.bus_records import (
    ACK_ERROR,
    BIT_ERROR,
    CHANGED,
    LONG_AGO,
    NO_EVENT,
    SENT,
    SLOTS,
    STUFF_ERROR,
    Node,
    new_bus,
)  # fmt: skip
from vegrip.transport.canbus.compiled_bus import CompiledBus, compiled
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame, read_record, write_record

ERROR_KINDS = {BIT_ERROR: ErrorKind.BIT, STUFF_ERROR: ErrorKind.STUFF, ACK_ERROR: ErrorKind.ACK}
SHARES = ("loss", "corruption", "misreading", "flips", "delay", "jitter", "babble")


class BusModel:
    """The bus and its nodes, which are numbers given by the caller."""

    def __init__(self, timing: BitTiming, functions: ModuleType | CompiledBus | None = None) -> None:
        self.timing = timing
        self.record = new_bus(timing.bitrate, timing.data_bitrate)
        self._slots: dict[int, int] = {}
        self.use(functions or compiled() or python)

    def use(self, functions: ModuleType | CompiledBus) -> None:
        self._functions: Any = functions
        self._bus = self.record if isinstance(functions, ModuleType) else addressof(self.record)

    def attach(
        self, node: int, *, listen_only: bool = False, faults: NodeFaults = NO_FAULTS, time: int = 0
    ) -> None:
        """Connect ``node`` at ``time`` [ns]; from the next frame on it takes part."""
        bus = self.record
        if bus.attached == SLOTS:
            raise ConfigError(f"it has {SLOTS} nodes, and no room for more")
        slot = self._slots[node] = bus.order[bus.attached]
        bus.attached += 1
        new = bus.nodes[slot]
        memset(byref(new), 0, Node.faults.offset)
        new.number, new.listens_only = node, listen_only
        new.suspended, new.descriptor, new.patience, new.due = LONG_AGO, -1, -1, NO_EVENT
        self.endure(node, faults, time)

    def endure(self, node: int, faults: NodeFaults, time: int = 0) -> None:
        """Let ``node`` suffer ``faults`` from ``time`` [ns] on, in place of those it had."""
        bus, asked = self.record, self.record.nodes[self._slots[node]]
        asked.has_faults = faults != NO_FAULTS
        if asked.has_faults:
            for name in SHARES:
                setattr(asked.faults, name, getattr(faults, name))
            *words, drawn = Random(faults.seed).getstate()[1]  # noqa: S311 (no secret)
            asked.faults.words[:], asked.faults.drawn = words, drawn
        bus.is_hopeless = False
        text.count_nodes(bus)
        text.babble(bus, asked, time)

    def detach(self, node: int) -> None:
        """Disconnect ``node``; what it has queued is still sent, if a node is there to acknowledge it."""
        text.detach(self.record, self._slots[node])
        self._forget()

    def request(self, time: int, node: int, frame: BusFrame) -> bool:
        """Queue ``frame`` of ``node`` at ``time`` [ns]; refused from a node that is off or only listens."""
        write_record(frame, self.record.asked)
        return text.queue_frame(self.record, self._slots[node], time, self.record.asked)

    def accept(self, node: int, pairs: Sequence[tuple[int, int]]) -> None:
        """Bring ``node`` what passes one of the filters ``pairs``."""
        wanted = self.node(node)
        wanted.filters = len(pairs)
        for number, pair in enumerate(pairs):
            wanted.pairs[2 * number], wanted.pairs[2 * number + 1] = pair

    def carry(self, until: int) -> int:
        """Carry frames between members on the wall clock, see :func:`vegrip.transport.canbus.carry.carry`."""
        return self._functions.carry(self._bus, until)

    def catch_up(self) -> None:
        self._functions.catch_up(self._bus)

    def waiting(self, node: int) -> int:
        return int(self.node(node).waiting)

    def node(self, node: int) -> Node:
        return self.record.nodes[self._slots[node]]

    @property
    def busy(self) -> int:
        """For how long the bus has carried frames, good or bad [ns]."""
        return int(self.record.busy)

    @property
    def queued(self) -> int:
        return int(self.record.queued)

    def is_heard(self, node: int) -> bool:
        return text.is_heard(self.record, self.node(node))

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
        return None if event == NO_EVENT else event

    def _happened(self) -> list[Event]:
        bus, done = self.record, self.record.done
        events: list[Event] = []
        for event in bus.events[: bus.happened]:
            if event.kind == CHANGED:
                counters, state = (event.transmit, event.receive), ErrorState(event.state)
                events.append(StateChange(event.time, event.number, state, counters, event.dropped))
                continue
            about = done.start, done.end, done.number, read_record(done.frame)
            if event.kind == SENT:
                events.append(Transmission(*about, done.is_lost, done.missed_by))
            else:
                counts = {number: self.counters(number) for number in self._slots}
                events.append(BusError(*about, ERROR_KINDS[done.error], done.found_by, counts))
        self._forget()
        return events

    def _forget(self) -> None:
        bus = self.record
        if bus.attached < len(self._slots):
            self._slots = {bus.nodes[slot].number: slot for slot in bus.order[: bus.attached]}
