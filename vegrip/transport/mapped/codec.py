"""Frames of a foreign hand <-> states and commands of ours, as its map says. Pure: no bus, no clock."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from vegrip.clock import NS
from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.transport.codec import Frame
from vegrip.transport.codec.sequence import Sequence as Counted
from vegrip.transport.mapped.canopen_nodes import CanopenNodes
from vegrip.transport.mapped.checksums import Protection, protection
from vegrip.transport.mapped.compiled import Group, Read, compile_raw, compile_reader, groups_of
from vegrip.transport.mapped.database import ForeignMessage
from vegrip.transport.mapped.dialogue import Dialogue
from vegrip.transport.mapped.encoder import CommandEncoder
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.mapped.states import FingerStates, ForeignHand


@dataclass(slots=True)
class _Incoming:
    """One of their messages that is read."""

    message: ForeignMessage
    read: Read
    guard: Protection | None
    counter: Callable[[bytes], int] | None
    sequence: Counted | None
    fingers: tuple[FingerStates, ...]  # that it may complete
    owners: tuple[str, ...]  # fingers with anything in it


class MappedCodec(ForeignHand):
    """A foreign hand on a CAN bus, decoded and encoded as its map says.

    No frame of the bus raises: :meth:`decode_all` returns no state and counts in ``rejected``
    under ``length`` (shorter than the message), ``checksum`` or ``counter`` (a repeat, or older);
    the nodes of a CANopen hand as in :class:`~vegrip.transport.mapped.canopen_nodes.CanopenNodes`.
    ``foreign`` counts frames that the map does not read. ``lost`` are gaps in their counters; ``clipped``,
    by finger, commands beyond the range of their signal.
    """

    def __init__(self, plan: Plan) -> None:
        groups = [0] * len(plan.slots)
        found: dict[str, tuple[int, list[Group]]] = {}  # message -> its first group, its groups
        count = 0
        for name in plan.messages:
            own = groups_of(plan.database.messages[name], [s for s in plan.slots if s.message == name])
            for number, group in enumerate(own, count):
                for slot in group.slots:
                    groups[slot.number] = number
            found[name] = count, own
            count += len(own)
        super().__init__(plan, groups)
        self.fingers = tuple(self._states)
        self.foreign = 0
        made = [self._incoming_of(plan.database.messages[name], *found[name]) for name in found]
        self._incoming = {one.message.identifier: one for one in made}
        self.encoder = CommandEncoder(plan, self._state_of, self.clipped)
        self._nodes = _nodes(plan, self.rejected)
        self.opening = [Frame(*frame) for frame in plan.database.opening]
        self.dialogue = (
            None
            if plan.database.packets
            else Dialogue(
                plan.hand.device, 0, plan.hand.sending.period, self.rejected, str(plan.hand.path), on_can=True
            )
        )

    def decode(self, frame: Frame) -> Message | None:
        """Return the first state that ``frame`` completes; :meth:`decode_all` returns all of them."""
        states = self.decode_all(frame)
        return states[0] if states else None

    def decode_all(self, frame: Frame) -> Sequence[FingertipState]:
        """Return the states that ``frame`` completes."""
        incoming = self._incoming.get(frame.arbitration_id)
        known = self._nodes is not None and self._nodes.receive(frame)
        if incoming is None:
            self.foreign += not known
            return ()
        if self.dialogue is not None:
            self.dialogue.came(incoming.message.name)
        data, stamp, seq = frame.data, frame.stamp, None
        length = incoming.message.length
        if len(data) != length:  # CAN FD fills up to its sizes
            if len(data) < length:
                return self._refuse("length", incoming.owners)
            data = data[:length]
        if incoming.guard is not None and not incoming.guard.check(data):
            return self._refuse("checksum", incoming.owners)
        if incoming.counter is not None and incoming.sequence is not None:
            seq = incoming.sequence.advance(incoming.counter(data), stamp)
            if seq is None:
                return self._refuse("counter")
        slots = self._slots
        heard = incoming.read(data, slots)
        if not heard and incoming.message.has_validity:
            return self._refuse("invalid", incoming.owners)
        for group in heard:
            self._heard[group] = stamp
        states = []
        for finger in incoming.fingers:
            if not finger.triggers or not finger.triggers.isdisjoint(heard):
                states.append(finger.state(slots, self._heard, seq, stamp))  # noqa: PERF401 (no call of a comprehension)
        return states

    def due(self, now: int) -> list[Frame]:
        """Return the frames to send at ``now`` [ns]: commands to repeat, requests, starts of nodes."""
        said = self.dialogue.due(now) if self.dialogue is not None else ()
        return [
            *self.encoder.due(now),
            *(Frame(step.identifier, step.data, len(step.data) > 8) for step in said),
            *(self._nodes.due(now) if self._nodes is not None else ()),
        ]

    @property
    def identifiers(self) -> set[int]:
        """Identifiers of the frames that are read."""
        return set(self._incoming) | (self._nodes.identifiers if self._nodes is not None else set())

    def encode(self, message: Message) -> list[Frame]:
        """Return the frames that carry a command; other messages are not for a foreign hand."""
        return self.encoder.encode(message) if isinstance(message, ForceCommand) else []

    def _incoming_of(self, message: ForeignMessage, first: int, groups: list[Group]) -> _Incoming:
        spec = self.plan.protection.get(message.name)
        guard = counter = sequence = None
        if spec is not None:
            where = f"{self.plan.hand.path} [messages.{message.name}.checksum]"
            guard = None if message.checked else protection(spec.checksum, message, where)
            if spec.counter:
                signal = message.signals[spec.counter]
                counter = compile_raw(message, signal)
                sequence = self._sequence(spec.modulus or 1 << signal.length)
        read = compile_reader(message, groups, first)
        fingers, owners = self._completed_by(message.name), self._owners(message.name)
        return _Incoming(message, read, guard, counter, sequence, fingers, owners)


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
