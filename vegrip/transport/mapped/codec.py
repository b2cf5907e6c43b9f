"""Messages of a foreign hand <-> states and commands of ours, as its map says. Pure: no bus, no clock."""

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from vegrip.clock import NOT_YET, NS
from vegrip.errors import ConfigError
from vegrip.messages import DeviceReport, FingertipState, ForceCommand, Message
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED
from vegrip.transport.codec.sequence import Sequence as Counted
from vegrip.transport.mapped import compiled
from vegrip.transport.mapped.bodies import bodies_of
from vegrip.transport.mapped.body_paths import parse_path
from vegrip.transport.mapped.canopen_nodes import CanopenNodes
from vegrip.transport.mapped.commands import Commands, FrameCommands, TopicCommands
from vegrip.transport.mapped.compiled import reading
from vegrip.transport.mapped.plan import ChannelPlan, FingerPlan, Plan, Slot
from vegrip.transport.maps.dialogue import Dialogue, Step
from vegrip.transport.maps.schema import REPORTED, MessageMap
from vegrip.transport.maps.signals import ForeignMessage

MAX_MESSAGE_BYTES: Final = 65_536  # [bytes] on a network
MODULUS: Final = 1 << 32
REPORT_PERIOD: Final = NS // 50  # [ns] as ControlSettings.report_period


class FingerStates:
    """The states of one finger: what completes one, what is too old, what is missing."""

    def __init__(
        self,
        finger: FingerPlan,
        slots: Sequence[Slot],
        groups: Sequence[int],  # which of them fills each slot
        values: compiled.Slots,
        received: Sequence[int],  # [ns] when each group came last
    ) -> None:
        self.name = finger.name
        self._values, self._received = values, received
        self.build = compiled.compile_builder(finger)
        self._count = -1  # the number of the last state, where no counter of theirs shows it
        self.last = math.nan  # [N] the last normal force, for commands that rest on it
        used = {number for plan in finger.channels.values() for number in plan.slots}
        self.triggers = frozenset(groups[number] for number in finger.trigger_slots)
        self._max_age = round(finger.max_age * NS)
        always_new = self.triggers if len(self.triggers) == 1 else frozenset()
        self._held = {  # group -> its slots
            group: tuple(number for number in used if groups[number] == group)
            for group in {groups[number] for number in used} - always_new
        }
        self._always_zero = {  # channel -> its slots, and their values at zero
            name: tuple((number, slots[number].offset) for number in plan.slots)
            for name, plan in finger.channels.items()
            if plan.gated and plan.slots and name != "normal_force"
        }

    def state(self, seq: int | None, stamp: int) -> FingertipState:
        """Return the state that is complete at ``stamp`` [ns]; changes slots that are missing to NaN."""
        if seq is None:
            seq = self._count = self._count + 1
        if self._held:
            for group, numbers in self._held.items():
                if stamp - self._received[group] > self._max_age:
                    for number in numbers:
                        self._values[number] = math.nan
        if self._always_zero:
            self._leave_out_zeros(self._values)
        state = self.build(self._values, stamp, self.name, seq)
        self.last = state.normal_force
        return state

    def _leave_out_zeros(self, s: compiled.Slots) -> None:
        for name, zeros in list(self._always_zero.items()):
            if any(s[number] != zero and not math.isnan(s[number]) for number, zero in zeros):
                del self._always_zero[name]
                continue
            for number, _ in zeros:
                s[number] = math.nan


Take = Callable[[Any, int], Sequence[FingertipState]]
"""Takes a message that came at a time [ns]; returns the states that it completes."""


class ForeignHand(ABC):
    """The last values of a foreign hand, its commands, and counts of what was refused.

    ``groups`` says which group of signals fills each slot; signals of a group come together.
    ``lost`` are gaps in their counters; ``clipped``, by finger, commands beyond the range of their signal;
    ``broken``, by finger, messages that could not be understood.
    """

    encoder: Commands

    def __init__(self, plan: Plan, groups: Sequence[int]) -> None:
        self.plan = plan
        self.rejected: Counter[str] = Counter()
        self.broken: Counter[str] = Counter()
        self.clipped: Counter[str] = Counter()
        self._slots: list[float] = [math.nan] * len(plan.slots)
        self._received = [NOT_YET] * len(plan.slots)  # there are no more groups than slots
        self._states = {
            finger.name: FingerStates(finger, plan.slots, groups, self._slots, self._received)
            for finger in plan.fingers
        }
        self._sequences: list[Counted] = []
        self._reporting = {
            finger.name: [finger.channels.get(name) for name in REPORTED]
            for finger in plan.fingers
            if not finger.channels.keys().isdisjoint(REPORTED)
        }
        self._report_due = NOT_YET
        self._report_count = 0

    def add_reports(self, messages: list[Message], arrivals: list[int], now: int) -> None:
        """Put what the device says of its contacts behind its states, as often as our own is published."""
        if not (messages and self._reporting and now >= self._report_due):
            return
        self._report_due = now + REPORT_PERIOD
        for finger, channels in self._reporting.items():
            values = [math.nan if one is None else self._value(one) for one in channels]
            if not all(map(math.isnan, values)):
                messages.append(DeviceReport(now, finger, self._report_count, *values))
                arrivals.append(now)
        self._report_count += 1

    def _value(self, channel: ChannelPlan) -> float:
        return channel.constant + sum(self._slots[number] for number in channel.slots)

    @abstractmethod
    def _counting(self, name: str, scope: dict[str, Any]) -> tuple[list[str], int]:
        """Return lines that set ``raw`` to the counter of the message ``name``, and what it counts to."""

    @property
    def lost(self) -> int:
        return sum(sequence.lost for sequence in self._sequences)

    def state_of(self, finger: str) -> tuple[float, float]:
        """Return the last normal force of ``finger`` [N] and its position in the unit of their signal."""
        slot = self.plan.feedback.get(finger)
        return self._states[finger].last, math.nan if slot is None else self._slots[slot]

    def _taking(
        self,
        name: str,
        head: Sequence[str],  # looks whether ``data`` can be read
        reading: Sequence[str],  # fills the slots, and sets ``found`` to the groups of signals in it
        scope: dict[str, Any],  # what both know
        has_validity: bool,  # a message without any group is one without validity
    ) -> Take:
        """Return what takes the message ``name``: one function, since each call costs a tenth of it."""
        scope |= {"refuse": self._refuse, "owners": self._owners(name)}
        scope |= {"s": self._slots, "received": self._received}
        lines = ["def take(data, stamp):", *head, " seq = None"]
        spec = self.plan.hand.messages.get(name)
        if spec is not None and spec.counter:
            counting, modulus = self._counting(name, scope)
            self._sequences.append(Counted(modulus))
            scope["advance"] = self._sequences[-1].advance
            lines += [*counting, " seq = None if raw is None else advance(raw, stamp)"]
            lines += [" if seq is None:", "  return refuse('counter')"]
        lines += reading
        lines += [" if not found:", "  return refuse('invalid', owners)"] if has_validity else []
        lines += [" for group in found:", "  received[group] = stamp"]
        fingers = [self._states[finger.name] for finger in self.plan.fingers if finger.trigger == name]
        states = []
        for number, finger in enumerate(fingers):
            scope |= {f"state{number}": finger.state, f"misses{number}": finger.triggers.isdisjoint}
            state = f"state{number}(seq, stamp)"
            states.append(f"*(() if misses{number}(found) else ({state},))" if finger.triggers else state)
        take: Take = compiled.made([*lines, f" return [{', '.join(states)}]"], "take", scope)
        return take

    def _owners(self, name: str) -> list[str]:
        own = {slot.number for slot in self.plan.slots if slot.message == name}
        return [
            finger.name
            for finger in self.plan.fingers
            if any(own.intersection(channel.slots) for channel in finger.channels.values())
        ]

    def _refuse(self, name: str, owners: Sequence[str] = ()) -> list[FingertipState]:
        self.rejected[name] += 1
        for owner in owners:
            self.broken[owner] += 1
        return []


class MappedCodec(ForeignHand):
    """A foreign hand on a CAN bus or in packets, decoded and encoded as its map says.

    No frame raises: :meth:`decode_all` returns no state and counts in ``rejected`` under ``length`` (shorter
    than the message), ``checksum``, ``invalid`` (it says so) or ``counter`` (a repeat, or older); nodes of
    a CANopen hand as in :class:`~vegrip.transport.mapped.canopen_nodes.CanopenNodes`. ``foreign`` counts
    frames that the map does not read.
    """

    encoder: FrameCommands

    def __init__(self, plan: Plan) -> None:
        groups = [0] * len(plan.slots)
        found: dict[str, tuple[int, list[compiled.Group]]] = {}  # message -> its first group, its groups
        count = 0
        for name in plan.messages:
            own = compiled.groups_of(
                plan.database.messages[name], [s for s in plan.slots if s.message == name]
            )
            for number, group in enumerate(own, count):
                for slot in group.slots:
                    groups[slot.number] = number
            found[name] = count, own
            count += len(own)
        super().__init__(plan, groups)
        self.foreign = 0
        self._takes: dict[int, Take] = {}
        for name, each in found.items():
            message = plan.database.messages[name]
            if message.identifier in self._takes:
                raise ConfigError(
                    f"{plan.database.name}: {name} has the identifier of another message of the map, "
                    f"0x{message.identifier & ~EXTENDED:X}; take the signals of one of the two"
                )
            self._takes[message.identifier] = self._of_frame(message, *each)
        self._names = {plan.database.messages[name].identifier: name for name in found}
        self.encoder = FrameCommands(plan, self.state_of, self.clipped)
        self._nodes = _nodes(plan, self.rejected)
        self.opening = [Frame(*frame) for frame in plan.database.opening]
        hand = plan.hand
        self.dialogue = (
            None
            if plan.database.packets
            else Dialogue(hand.device, 0, hand.command.period, self.rejected, str(hand.path), on_can=True)
        )
        talks = self.dialogue is not None and bool(self.dialogue.poll or self.dialogue.opening)
        self._talk = self.dialogue if talks else None  # that has to know what comes

    def decode(self, frame: Frame) -> Message | None:
        """Return the first state that ``frame`` completes; :meth:`decode_all` returns all of them."""
        return next(iter(self.decode_all(frame)), None)

    def decode_all(self, frame: Frame) -> Sequence[FingertipState]:
        identifier, data, _, stamp = frame
        take = self._takes.get(identifier)
        known = self._nodes is not None and self._nodes.receive(frame)
        if take is None:
            self.foreign += not known
            return ()
        if self._talk is not None:
            self._talk.came(self._names[identifier], stamp)
        return take(data, stamp)

    def due(self, now: int) -> list[Frame]:
        said: Sequence[Step] = ()
        if self.dialogue is not None:
            if self.dialogue.opening:
                self.dialogue.is_silent(now)
            said = self.dialogue.due(now)
        nodes = self._nodes.due(now) if self._nodes is not None else ()
        return [*self.encoder.due(now), *(step.frame for step in said), *nodes]

    def begin(self) -> list[Frame]:
        """Return the frames to send to a bus that has just been opened."""
        if self._nodes is not None:
            self._nodes.begin()
        return self.opening

    @property
    def identifiers(self) -> set[int]:
        return set(self._takes) | (self._nodes.identifiers if self._nodes is not None else set())

    def encode(self, message: Message) -> list[Frame]:
        return self.encoder.encode(message) if isinstance(message, ForceCommand) else []

    def _counting(self, name: str, scope: dict[str, Any]) -> tuple[list[str], int]:  # noqa: ARG002
        message = self.plan.database.messages[name]
        signal = message.signals[self.plan.hand.messages[name].counter]
        return compiled.raw_reading(message, signal), self.plan.modulus_of(name)

    def _of_frame(self, message: ForeignMessage, first: int, groups: list[compiled.Group]) -> Take:
        length = message.length
        ends = {
            number: [(slot.number, slot.place.end) for slot in group.slots if slot.place is not None]
            for number, group in enumerate(groups, first)
        }
        scope: dict[str, Any] = {"trim": self._trimming(ends)}
        spec = self.plan.hand.messages.get(message.name)
        guard = None if message.checked else self.plan.guard_of(message.name)
        if guard is not None:
            scope["check"] = guard.check
        needed = _least_bytes(message, ends, spec, groups) if guard is None else length
        head = [" size = len(data)", f" if size != {length}:", f"  if size < {needed}:"]
        head += ["   return refuse('length', owners)"]
        head += [f"  data = data[:{length}] + bytes({length} - min(size, {length}))"]  # CAN FD fills up
        if guard is not None:
            head += [" if not check(data):", "  return refuse('checksum', owners)"]
        lines = [*reading(message, groups, first), f" if size < {length}:", "  trim(size, found)"]
        return self._taking(message.name, head, lines, scope, message.has_validity)

    def _trimming(self, ends: Mapping[int, list[tuple[int, int]]]) -> Callable[[int, Sequence[int]], None]:
        """Return what makes the slots missing that a short frame does not hold, and counts it."""

        def trim(size: int, found: Sequence[int]) -> None:
            lost = [number for group in found for number, end in ends[group] if end > size]
            for number in lost:
                self._slots[number] = math.nan
            if lost:
                self.rejected["length"] += 1

        return trim


def _least_bytes(
    message: ForeignMessage,
    ends: Mapping[int, list[tuple[int, int]]],
    spec: MessageMap | None,
    groups: Sequence[compiled.Group],
) -> int:
    """Return how many bytes carry anything: multiplexers, the counter, and one signal."""
    switches = {name for group in groups for name, _ in group.condition}
    whole = [message.signals[name].end for name in switches]
    if spec is not None and spec.counter:
        whole.append(message.signals[spec.counter].end)
    least = min((end for own in ends.values() for _, end in own), default=message.length)
    return max([least, *whole])


def _nodes(plan: Plan, rejected: Counter[str]) -> CanopenNodes | None:
    if not plan.hand.nodes:
        return None
    objects = [
        (plan.database.messages[slot.message].identifier & 0x7F, where >> 8 & 0xFFFF, where >> 24)
        for slot in plan.slots
        if plan.database.messages[slot.message].asked and slot.place is not None
        for where in slot.place.selectors[:1]
    ]
    names = {node: finger for finger, node in plan.hand.nodes.items()}
    pdos = {
        plan.database.messages[name].identifier: plan.hand.nodes[finger]
        for name in plan.messages
        for finger in plan.hand.nodes
        if name.startswith(f"{finger}_TPDO")
    }
    return CanopenNodes(names, objects, round(plan.hand.command.poll * NS), rejected, names, pdos)


class TopicCodec(ForeignHand):
    """A foreign hand on a network: JSON, msgpack or protobuf, read and written by paths.

    No message raises: a bad one is counted in ``rejected`` under ``unknown_topic``, ``size``, ``schema``
    (not a message of the format), ``value`` (a text or the like where a number belongs) or ``counter``.
    """

    crowded = 0

    def __init__(self, plan: Plan) -> None:
        names = list(plan.messages)
        super().__init__(plan, [names.index(slot.message) for slot in plan.slots])
        self._bodies = bodies_of(plan)
        self._topics = {name: self._of_topic(name, number) for number, name in enumerate(names)}
        self.encoder = TopicCommands(plan, self.state_of, self.clipped, self._bodies)

    def decode_all(self, topic: str, payload: bytes, stamp: int) -> Sequence[FingertipState]:
        take = self._topics.get(topic)
        if take is None:
            return self._refuse("unknown_topic")
        if len(payload) > MAX_MESSAGE_BYTES:
            return self._refuse("size", self._owners(topic))
        try:
            body = self._bodies.load(topic, payload)
        except ValueError:
            return self._refuse("schema", self._owners(topic))
        return take(body, stamp)

    def encode(self, message: Message) -> tuple[str, bytes] | None:
        return next(iter(self.encoder.encode(message)), None) if isinstance(message, ForceCommand) else None

    def due(self, now: int) -> list[tuple[str, bytes]]:
        return self.encoder.due(now)

    def _number(self, value: Any) -> float:
        if value is None:
            return math.nan
        if isinstance(value, (int, float)) and abs(value) < 1e300:
            return float(value)
        if isinstance(value, float):
            return value  # NaN, or infinite: the watchdog's range refuses it
        self.rejected["value"] += 1
        return math.nan

    def _getter(self, name: str, path: str) -> Callable[[Any], Any]:
        where = f"{self.plan.hand.path} {name}"
        return self._bodies.getter(name, parse_path(path, where), where)

    def _of_topic(self, name: str, group: int) -> Take:
        own = [slot for slot in self.plan.slots if slot.message == name]
        gets = [(slot.number, self._getter(name, slot.signal), slot.scale, slot.offset) for slot in own]

        def read(body: Any) -> None:
            for slot, get, scale, offset in gets:
                self._slots[slot] = self._number(get(body)) * scale + offset

        return self._taking(name, (), (" read(data)", f" found = ({group},)"), {"read": read}, False)

    def _counting(self, name: str, scope: dict[str, Any]) -> tuple[list[str], int]:
        spec = self.plan.hand.messages[name]
        get, modulus = self._getter(name, spec.counter), spec.modulus or MODULUS

        def count(body: Any) -> int | None:
            value = get(body)
            is_whole = isinstance(value, int) and not isinstance(value, bool)
            return value % modulus if is_whole else None

        scope["count"] = count
        return [" raw = count(data)"], modulus
