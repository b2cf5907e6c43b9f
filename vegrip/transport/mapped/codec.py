"""Frames of a foreign hand <-> states and commands of ours, as its map says. Pure: no bus, no clock."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from vegrip.clock import NS
from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.transport.codec import Frame
from vegrip.transport.codec.sequence import Sequence
from vegrip.transport.mapped.canopen_nodes import CanopenNodes
from vegrip.transport.mapped.checksums import Protection, protection
from vegrip.transport.mapped.compiled import Read, compile_raw, compile_reader, groups_of
from vegrip.transport.mapped.database import ForeignMessage
from vegrip.transport.mapped.encoder import CommandEncoder
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.mapped.states import FingerStates

NEVER = -(1 << 62)  # [ns] when a group was heard that never was


@dataclass(slots=True)
class _Incoming:
    """One of their messages that is read."""

    message: ForeignMessage
    read: Read
    guard: Protection | None
    counter: Callable[[bytes], int] | None
    sequence: Sequence | None
    fingers: tuple[FingerStates, ...]  # that it may complete
    owners: tuple[str, ...]  # fingers with anything in it


class MappedCodec:
    """A foreign hand on a CAN bus, decoded and encoded as its map says.

    Nothing that comes from the bus raises: :meth:`decode_all` returns nothing and counts in ``rejected``
    under ``length`` (shorter than the message), ``checksum`` or ``counter`` (a repeat, or older);
    the nodes of a CANopen hand as in :class:`~vegrip.transport.mapped.canopen_nodes.CanopenNodes`.
    ``foreign`` counts frames that the map does not read. ``lost`` are gaps in their counters; ``clipped``,
    by finger, commands beyond the range of their signal.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.fingers = tuple(finger.name for finger in plan.fingers)
        self.rejected: Counter[str] = Counter()
        self.broken: Counter[str] = Counter()
        self.clipped: Counter[str] = Counter()
        self.foreign = 0
        self._slots: list[float] = [math.nan] * len(plan.slots)
        self._incoming: dict[int, _Incoming] = {}
        groups = [0] * len(plan.slots)
        readers: list[tuple[ForeignMessage, Read]] = []
        count = 0
        for name in plan.messages:
            message = plan.database.messages[name]
            found = groups_of(message, [slot for slot in plan.slots if slot.message == name])
            for number, group in enumerate(found, count):
                for slot in group.slots:
                    groups[slot.number] = number
            readers.append((message, compile_reader(message, found, count)))
            count += len(found)
        self._heard = [NEVER] * count
        self._states = tuple(FingerStates(finger, plan.slots, groups) for finger in plan.fingers)
        self._by_name = {states.name: states for states in self._states}
        for message, read in readers:
            self._incoming[message.identifier] = self._make(message, read)
        self.encoder = CommandEncoder(plan, self._state_of, self.clipped)
        self._nodes = _nodes(plan, self.rejected)

    @property
    def lost(self) -> int:
        """Messages that never arrived, where they have a counter."""
        return sum(one.sequence.lost for one in self._incoming.values() if one.sequence is not None)

    @property
    def always_zero(self) -> dict[str, set[str]]:
        """The channels that have been nothing but zero so far, and therefore missing, by finger."""
        return {states.name: states.always_zero for states in self._states}

    def decode(self, frame: Frame) -> Message | None:
        """Return the first state that ``frame`` completes; :meth:`decode_all` returns all of them."""
        states = self.decode_all(frame)
        return states[0] if states else None

    def decode_all(self, frame: Frame) -> tuple[FingertipState, ...] | list[FingertipState]:
        """Return the states that ``frame`` completes."""
        incoming = self._incoming.get(frame.arbitration_id)
        known = self._nodes is not None and self._nodes.take(frame)
        if incoming is None:
            self.foreign += not known
            return ()
        data, stamp, seq = frame.data, frame.stamp, None
        length = incoming.message.length
        if len(data) != length:  # CAN FD fills up to its sizes
            if len(data) < length:
                return self._refuse("length", incoming)
            data = data[:length]
        if incoming.guard is not None and not incoming.guard.check(data):
            return self._refuse("checksum", incoming)
        slots = self._slots
        if incoming.counter is not None and incoming.sequence is not None:
            seq = incoming.sequence.advance(incoming.counter(data), stamp)
            if seq is None:
                self.rejected["counter"] += 1
                return ()
        heard = incoming.read(data, slots)
        for group in heard:
            self._heard[group] = stamp
        states = []
        for finger in incoming.fingers:
            if finger.triggers and finger.triggers.isdisjoint(heard):
                continue
            finger.count = finger.count + 1 if seq is None else seq
            states.append(finger.state(slots, self._heard, finger.count, stamp))
        return states

    def due(self, now: int) -> list[Frame]:
        """Return the frames to send at ``now`` [ns]: commands to repeat, requests, starts of nodes."""
        return [*self.encoder.due(now), *(self._nodes.due(now) if self._nodes is not None else ())]

    @property
    def identifiers(self) -> set[int]:
        """Those of all frames that are read."""
        return set(self._incoming) | (self._nodes.identifiers if self._nodes is not None else set())

    def reset(self) -> None:
        """Forget all counters: what comes next begins new streams (a replay that starts over)."""
        for incoming in self._incoming.values():
            if incoming.sequence is not None:
                incoming.sequence.last = -1

    def encode(self, message: Message) -> list[Frame]:
        """Return the frames that carry a command; other messages are not for a foreign hand."""
        return self.encoder.take(message) if isinstance(message, ForceCommand) else []

    def _refuse(self, name: str, incoming: _Incoming) -> tuple[FingertipState, ...]:
        self.rejected[name] += 1
        for owner in incoming.owners:
            self.broken[owner] += 1
        return ()

    def _state_of(self, finger: str) -> tuple[float, float]:
        """Return the last normal force of ``finger`` [N] and its position in the unit of their signal."""
        slot = self.plan.feedback.get(finger)
        return self._by_name[finger].last, math.nan if slot is None else self._slots[slot]

    def _make(self, message: ForeignMessage, read: Read) -> _Incoming:
        plan = self.plan
        spec = plan.protection.get(message.name)
        guard = counter = sequence = None
        if spec is not None:
            guard = protection(spec.checksum, message, f"{plan.hand.path} [messages.{message.name}.checksum]")
            if spec.counter:
                signal = message.signals[spec.counter]
                counter = compile_raw(message, signal)
                sequence = Sequence(spec.modulus or 1 << signal.length)
        mine = {slot.number for slot in plan.slots if slot.message == message.name}
        owners = [
            f.name for f in plan.fingers if any(mine.intersection(c.slots) for c in f.channels.values())
        ]
        fingers = [s for s, f in zip(self._states, plan.fingers, strict=True) if f.trigger == message.name]
        return _Incoming(message, read, guard, counter, sequence, tuple(fingers), tuple(owners))


def _nodes(plan: Plan, rejected: Counter[str]) -> CanopenNodes | None:
    """Return the nodes of a CANopen hand, with what is asked of them; None for other hands."""
    if not plan.hand.nodes:
        return None
    objects = [
        (plan.database.messages[slot.message].identifier & 0x7F, where >> 8 & 0xFFFF, where >> 24)
        for slot in plan.slots
        if plan.database.messages[slot.message].asked and slot.place is not None
        for where in slot.place.selectors[:1]
    ]
    return CanopenNodes(plan.hand.nodes.values(), objects, round(plan.hand.sending.poll * NS), rejected)
