"""Messages of another shape on a network: JSON, msgpack or protobuf, by paths. Pure: no socket, no clock."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.transport.codec.sequence import Sequence
from vegrip.transport.mapped.bodies import bodies_of
from vegrip.transport.mapped.encoder import Law, law_of
from vegrip.transport.mapped.paths import Step, parse_path
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.mapped.schema import CommandMap
from vegrip.transport.mapped.states import FingerStates

MAX_MESSAGE_BYTES: Final = 65_536  # [bytes]
MODULUS: Final = 1 << 32
NEVER: Final = -(1 << 62)  # [ns]


@dataclass(slots=True)
class _Topic:
    """One topic that is read."""

    group: int
    reads: list[tuple[int, Callable[[Any], Any], float, float]]  # slot, path, scale, offset
    fingers: list[FingerStates]
    owners: list[str]
    counter: Callable[[Any], Any] | None = None
    sequence: Sequence | None = None


@dataclass(slots=True)
class _Target:
    """One finger in one topic of commands."""

    finger: str
    steps: tuple[Step, ...]
    law: Law
    low: float
    high: float
    command: ForceCommand | None = None
    sent: float = math.nan
    is_fresh: bool = False


@dataclass(slots=True)
class _Outgoing:
    topic: str
    targets: list[_Target] = field(default_factory=list)
    constants: list[tuple[tuple[Step, ...], float]] = field(default_factory=list)
    counter: tuple[Step, ...] = ()
    count: int = 0
    last: int = NEVER


class TopicCodec:
    """A foreign hand on a network, read and written by paths.

    Nothing that comes raises: it is counted in ``rejected`` under ``unknown_topic``, ``size``, ``schema``
    (not a message of the format), ``value`` (something that is no number where one belongs) or
    ``counter``.
    """

    crowded = 0

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.rejected: Counter[str] = Counter()
        self.broken: Counter[str] = Counter()
        self.clipped: Counter[str] = Counter()
        self.held = 0
        self._slots: list[float] = [math.nan] * len(plan.slots)
        self._bodies = bodies_of(plan)
        names = list(plan.messages)
        groups = [names.index(slot.message) for slot in plan.slots]
        self._heard = [NEVER] * len(names)
        self._states = [FingerStates(finger, plan.slots, groups) for finger in plan.fingers]
        self._topics = {name: self._topic(name, number) for number, name in enumerate(names)}
        self._period = round(plan.hand.sending.period * NS)
        self._outgoing: dict[str, _Outgoing] = {}
        self._of: dict[str, tuple[_Outgoing, _Target]] = {}
        for finger in plan.fingers:
            command = plan.hand.fingers[finger.name].command
            if command is not None:
                self._add(finger.name, command)

    @property
    def lost(self) -> int:
        """Messages that never arrived, where they have a counter."""
        return sum(one.sequence.lost for one in self._topics.values() if one.sequence is not None)

    def decode_all(self, topic: str, payload: bytes, stamp: int) -> list[FingertipState]:
        """Return the states that a message received at ``stamp`` [ns] completes."""
        incoming = self._topics.get(topic)
        if incoming is None:
            self.rejected["unknown_topic"] += 1
            return []
        body, fault = self._body(topic, payload)
        if fault:
            return self._refuse(fault, incoming)
        seq = None
        if incoming.counter is not None and incoming.sequence is not None:
            counter = incoming.counter(body)
            known = isinstance(counter, int) and not isinstance(counter, bool)
            seq = incoming.sequence.advance(counter % incoming.sequence.modulus, stamp) if known else None
            if seq is None:
                return self._refuse("counter", None)
        for slot, get, scale, offset in incoming.reads:
            self._slots[slot] = self._number(get(body)) * scale + offset
        self._heard[incoming.group] = stamp
        states = []
        for finger in incoming.fingers:
            finger.count = finger.count + 1 if seq is None else seq
            states.append(finger.state(self._slots, self._heard, finger.count, stamp))
        return states

    def decode(self, topic: str, payload: bytes, stamp: int) -> Message | None:
        """Return the first state that a message completes."""
        return next(iter(self.decode_all(topic, payload, stamp)), None)

    def encode(self, message: Message) -> tuple[str, bytes] | None:
        """Return topic and payload of a command, once all fingers in its message have theirs."""
        found = self._of.get(message.finger) if isinstance(message, ForceCommand) else None
        if found is None or not isinstance(message, ForceCommand):
            return None
        outgoing, target = found
        if not (math.isfinite(message.normal_force) and message.normal_force >= 0.0):
            self.clipped[message.finger] += 1
            return None
        target.command, target.is_fresh = message, True
        return (
            self._packed(outgoing, message.stamp) if all(each.is_fresh for each in outgoing.targets) else None
        )

    def due(self, now: int) -> list[tuple[str, bytes]]:
        """Return the commands whose last message is a period ago at ``now`` [ns]: the last one is held."""
        packed = []
        for outgoing in self._outgoing.values():
            if now - outgoing.last < self._period:
                continue
            expired = all(
                each.command is not None and each.command.expires <= now for each in outgoing.targets
            )
            if expired and self.plan.hand.sending.silence == "holds":
                continue
            message = self._packed(outgoing, now)
            self.held += expired and message is not None
            packed += [message] if message is not None else []
        return packed

    def _body(self, topic: str, payload: bytes) -> tuple[Any, str]:
        if len(payload) > MAX_MESSAGE_BYTES:
            return None, "size"
        try:
            return self._bodies.load(topic, payload), ""
        except ValueError:
            return None, "schema"

    def _number(self, value: Any) -> float:
        if value is None:
            return math.nan
        if isinstance(value, (int, float)) and abs(value) < 1e300:
            return float(value)
        if isinstance(value, float):
            return value  # NaN, or infinite: the watchdog's range refuses it
        self.rejected["value"] += 1
        return math.nan

    def _refuse(self, name: str, incoming: _Topic | None) -> list[FingertipState]:
        self.rejected[name] += 1
        for owner in incoming.owners if incoming is not None else ():
            self.broken[owner] += 1
        return []

    def _topic(self, name: str, number: int) -> _Topic:
        plan = self.plan
        where = f"{plan.hand.path} {name}"
        mine = [slot for slot in plan.slots if slot.message == name]
        get = self._bodies.getter
        reads = [(s.number, get(name, parse_path(s.signal, where), where), s.scale, s.offset) for s in mine]
        numbers = {slot.number for slot in mine}
        owners = [
            f.name for f in plan.fingers if any(numbers.intersection(c.slots) for c in f.channels.values())
        ]
        fingers = [s for s, f in zip(self._states, plan.fingers, strict=True) if f.trigger == name]
        topic = _Topic(number, reads, fingers, owners)
        spec = plan.protection.get(name)
        if spec is not None and spec.counter:
            topic.counter = get(name, parse_path(spec.counter, where), where)
            topic.sequence = Sequence(spec.modulus or MODULUS)
        return topic

    def _add(self, finger: str, command: CommandMap) -> None:
        where = f"{self.plan.hand.path} [fingers.{finger}.command]"
        topic, colon, path = command.signal.partition(":")
        if not colon:
            raise ConfigError(
                f"{where}: {command.signal!r} must be TOPIC:PATH, as in 'hand/command:fingers[0].force'"
            )
        outgoing = self._outgoing.setdefault(topic.strip(), _Outgoing(topic.strip()))
        low = -math.inf if math.isnan(command.low) else command.low
        high = math.inf if math.isnan(command.high) else command.high
        steps = parse_path(path.strip(), where)
        if any(each.steps == steps for each in outgoing.targets):
            raise ConfigError(f"{where}: {command.signal} already takes the command of another finger")
        target = _Target(finger, steps, law_of(command, command.unit, where), low, high)
        outgoing.targets.append(target)
        outgoing.constants += [(parse_path(name, where), value) for name, value in command.set.items()]
        for each in (steps, *(constant for constant, _ in outgoing.constants)):
            self._bodies.check(outgoing.topic, each, where)
        spec = self.plan.protection.get(topic.strip())
        if spec is not None and spec.counter:
            outgoing.counter = parse_path(spec.counter, where)
            self._bodies.check(outgoing.topic, outgoing.counter, where)
        self._of[finger] = outgoing, target

    def _packed(self, outgoing: _Outgoing, now: int) -> tuple[str, bytes] | None:
        body: Any = None
        for target in outgoing.targets:
            value = self._value(target)
            if value is None:
                return None
            body = self._bodies.put(outgoing.topic, body, target.steps, value)
        for steps, constant in outgoing.constants:
            body = self._bodies.put(outgoing.topic, body, steps, constant)
        if outgoing.counter:
            body = self._bodies.put(outgoing.topic, body, outgoing.counter, outgoing.count)
        for target in outgoing.targets:
            target.is_fresh, target.sent = False, self._force(target)
        outgoing.count += 1
        outgoing.last = now
        return outgoing.topic, self._bodies.dump(body)

    def _force(self, target: _Target) -> float:
        if target.command is not None:
            return target.command.normal_force
        return next(states.last for states in self._states if states.name == target.finger)

    def _value(self, target: _Target) -> float | None:
        measured = next(states.last for states in self._states if states.name == target.finger)
        slot = self.plan.feedback.get(target.finger)
        position = math.nan if slot is None else self._slots[slot]
        value = target.law.value(self._force(target), target.sent, measured, position)
        if not math.isfinite(value):
            return None
        bounded = min(max(value, target.low), target.high)
        self.clipped[target.finger] += bounded != value
        return bounded
