"""Messages of another shape on a network: JSON, msgpack or protobuf, by paths. Pure: no socket, no clock."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from vegrip.errors import ConfigError
from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.transport.codec.sequence import Sequence as Counted
from vegrip.transport.mapped.bodies import Bodies, Step, bodies_of, parse_path
from vegrip.transport.mapped.commands import Commands, Outgoing, StateOf, Target, law_of
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.mapped.schema import CommandMap
from vegrip.transport.mapped.states import FingerStates, ForeignHand

MAX_MESSAGE_BYTES: Final = 65_536  # [bytes]
MODULUS: Final = 1 << 32


@dataclass(slots=True)
class _Topic:
    """One topic that is read."""

    group: int
    reads: list[tuple[int, Callable[[Any], Any], float, float]]  # slot, path, scale, offset
    fingers: tuple[FingerStates, ...]
    owners: tuple[str, ...]
    counter: Callable[[Any], Any] | None = None
    sequence: Counted | None = None


@dataclass(slots=True, kw_only=True)
class _Target(Target):
    steps: tuple[Step, ...]


@dataclass(slots=True, kw_only=True)
class _Outgoing(Outgoing):
    topic: str
    constants: list[tuple[tuple[Step, ...], float]] = field(default_factory=list)
    counter: tuple[Step, ...] = ()


class TopicEncoder(Commands[tuple[str, bytes]]):
    """All commands of a hand on a network, as topic and payload."""

    def __init__(self, plan: Plan, bodies: Bodies, state_of: StateOf, clipped: Counter[str]) -> None:
        self._bodies = bodies
        super().__init__(plan, state_of, clipped)

    def _packed(self, outgoing: _Outgoing, values: list[tuple[_Target, float, float]]) -> tuple[str, bytes]:
        entries = [(target.steps, value) for target, value, _ in values]
        entries += outgoing.constants
        if outgoing.counter:
            entries.append((outgoing.counter, outgoing.count))
        body: Any = None
        for steps, value in entries:
            body = self._bodies.put(outgoing.topic, body, steps, value)
        return outgoing.topic, self._bodies.dump(body)

    def _add(self, finger: str, command: CommandMap, where: str) -> tuple[_Outgoing, _Target]:
        topic, colon, path = command.signal.partition(":")
        if not colon:
            raise ConfigError(
                f"{where}: {command.signal!r} must be TOPIC:PATH, as in 'hand/command:fingers[0].force'"
            )
        topic = topic.strip()
        outgoing: _Outgoing = self._outgoing.setdefault(topic, _Outgoing(targets=[], topic=topic))
        low = -math.inf if math.isnan(command.low) else command.low
        high = math.inf if math.isnan(command.high) else command.high
        steps = parse_path(path.strip(), where)
        if any(each.steps == steps for each in outgoing.targets):
            raise ConfigError(f"{where}: {command.signal} already takes the command of another finger")
        law = law_of(command, command.unit, where)
        target = _Target(finger=finger, law=law, low=low, high=high, steps=steps)
        outgoing.targets.append(target)
        outgoing.constants += [(parse_path(name, where), value) for name, value in command.set.items()]
        spec = self._plan.protection.get(topic)
        if spec is not None and spec.counter:
            outgoing.counter = parse_path(spec.counter, where)
        for each in (steps, *(constant for constant, _ in outgoing.constants), outgoing.counter):
            if each:
                self._bodies.check(topic, each, where)
        return outgoing, target


class TopicCodec(ForeignHand):
    """A foreign hand on a network, read and written by paths.

    No message raises: a bad one is counted in ``rejected`` under ``unknown_topic``, ``size``, ``schema``
    (not a message of the format), ``value`` (a text or the like where a number belongs) or ``counter``.
    """

    crowded = 0

    def __init__(self, plan: Plan) -> None:
        names = list(plan.messages)
        super().__init__(plan, [names.index(slot.message) for slot in plan.slots])
        self._bodies = bodies_of(plan)
        self._topics = {name: self._topic(name, number) for number, name in enumerate(names)}
        self.encoder = TopicEncoder(plan, self._bodies, self._state_of, self.clipped)

    def decode_all(self, topic: str, payload: bytes, stamp: int) -> list[FingertipState]:
        """Return the states that a message received at ``stamp`` [ns] completes."""
        incoming = self._topics.get(topic)
        if incoming is None:
            return self._refuse("unknown_topic")
        if len(payload) > MAX_MESSAGE_BYTES:
            return self._refuse("size", incoming.owners)
        try:
            body = self._bodies.load(topic, payload)
        except ValueError:
            return self._refuse("schema", incoming.owners)
        seq = None
        if incoming.counter is not None and incoming.sequence is not None:
            counter = incoming.counter(body)
            known = isinstance(counter, int) and not isinstance(counter, bool)
            seq = incoming.sequence.advance(counter % incoming.sequence.modulus, stamp) if known else None
            if seq is None:
                return self._refuse("counter")
        for slot, get, scale, offset in incoming.reads:
            self._slots[slot] = self._number(get(body)) * scale + offset
        self._heard[incoming.group] = stamp
        return [finger.state(self._slots, self._heard, seq, stamp) for finger in incoming.fingers]

    def decode(self, topic: str, payload: bytes, stamp: int) -> Message | None:
        """Return the first state that a message completes."""
        return next(iter(self.decode_all(topic, payload, stamp)), None)

    def encode(self, message: Message) -> tuple[str, bytes] | None:
        """Return topic and payload of a command, once all fingers in its message have theirs."""
        return next(iter(self.encoder.encode(message)), None) if isinstance(message, ForceCommand) else None

    def due(self, now: int) -> list[tuple[str, bytes]]:
        """Return the commands to repeat at ``now`` [ns]."""
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

    def _topic(self, name: str, number: int) -> _Topic:
        where = f"{self.plan.hand.path} {name}"
        get = self._bodies.getter
        reads = [
            (slot.number, get(name, parse_path(slot.signal, where), where), slot.scale, slot.offset)
            for slot in self.plan.slots
            if slot.message == name
        ]
        topic = _Topic(number, reads, self._completed_by(name), self._owners(name))
        spec = self.plan.protection.get(name)
        if spec is not None and spec.counter:
            topic.counter = get(name, parse_path(spec.counter, where), where)
            topic.sequence = self._sequence(spec.modulus or MODULUS)
        return topic
