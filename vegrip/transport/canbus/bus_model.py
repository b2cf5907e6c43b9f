"""A CAN bus in Python's terms, with nodes by number; the bus itself is :mod:`vegrip.transport.canbus.bus`."""

from collections.abc import Sequence
from ctypes import addressof, byref, memset
from random import Random
from types import ModuleType
from typing import Any

from vegrip.errors import ConfigError
from vegrip.transport.canbus import bus as text
from vegrip.transport.canbus import bus_records as wire
from vegrip.transport.canbus.bus_events import NO_FAULTS, NodeFaults
from vegrip.transport.canbus.compiled_bus import CompiledBus
from vegrip.transport.canbus.frame_time import BitTiming

SHARES = ("loss", "corruption", "misreading", "flips", "delay", "jitter", "babble")


class BusModel:
    """The bus and its nodes, which are numbers given by the caller."""

    def __init__(self, timing: BitTiming, functions: ModuleType | CompiledBus) -> None:
        self.timing = timing
        self.record = wire.new_bus(timing.bitrate, timing.data_bitrate)
        self._slots: dict[int, int] = {}
        self.use(functions)

    def use(self, functions: ModuleType | CompiledBus) -> None:
        self._functions: Any = functions
        self._bus = self.record if isinstance(functions, ModuleType) else addressof(self.record)

    def attach(
        self, node: int, *, listen_only: bool = False, faults: NodeFaults = NO_FAULTS, time: int = 0
    ) -> None:
        """Connect ``node`` at ``time`` [ns]; from the next frame on it takes part."""
        bus = self.record
        if bus.attached == wire.SLOTS:
            raise ConfigError(f"it has {wire.SLOTS} nodes, and no room for more")
        slot = self._slots[node] = bus.order[bus.attached]
        bus.attached += 1
        new = bus.nodes[slot]
        memset(byref(new), 0, wire.Node.faults.offset)
        new.number, new.listens_only = node, listen_only
        new.suspended, new.descriptor, new.patience, new.due = wire.LONG_AGO, -1, -1, wire.NO_EVENT
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

    def accept(self, node: int, pairs: Sequence[tuple[int, int]]) -> None:
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

    def node(self, node: int) -> wire.Node:
        return self.record.nodes[self._slots[node]]

    @property
    def busy(self) -> int:
        """For how long the bus has carried frames, good or bad [ns]."""
        return int(self.record.busy)

    @property
    def queued(self) -> int:
        return int(self.record.queued)

    def is_received(self, node: int) -> bool:
        return text.is_received(self.record, self.node(node))

    def _forget(self) -> None:
        bus = self.record
        if bus.attached < len(self._slots):
            self._slots = {bus.nodes[slot].number: slot for slot in bus.order[: bus.attached]}
