"""Commands to a foreign hand as safely as to our own, whatever its wire.

Their protocols mostly have neither a lifetime nor a fail-safe, so this side keeps them: a message leaves at a
fixed rate as long as a command is in force; when commands stop, the last one is held, and no value is ever
sent as zero for want of a command.
"""

import math
import struct
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from vegrip.clock import NS
from vegrip.errors import ConfigError, suggestion
from vegrip.messages import ForceCommand
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.bodies import Bodies, parse_path
from vegrip.transport.mapped.checksums import Protection, protection
from vegrip.transport.mapped.database import ForeignMessage, Signal
from vegrip.transport.mapped.plan import NOT_YET, Plan, find_signal
from vegrip.transport.mapped.schema import CommandMap
from vegrip.transport.mapped.units import conversion, product, quantity, worth

StateOf = Callable[[str], tuple[float, float]]
"""The last normal force [N] and the position in the unit of their signal, by finger."""

FLOATS: Final = {16: "<e", 32: "<f", 64: "<d"}


@dataclass(frozen=True, slots=True)
class Law:
    """From a force to the value of their signal, in its unit.

    ``per_newton`` is what their signal gets for a newton, or the inverse of the stiffness.
    """

    kind: str
    per_newton: float
    sign: int
    scale: float
    offset: float

    def value(self, force: float, before: float, measured: float, position: float) -> float:
        """Return the value to send, NaN when it cannot be known.

        Args:
            force: wanted [N].
            before: the force of the last message [N], NaN before the first.
            measured: the present force [N].
            position: the present position, in the unit of the signal.

        """
        if self.kind == "position":
            return position + self.sign * self.scale * (force - measured) * self.per_newton
        if self.kind == "increment":
            force -= measured if math.isnan(before) else before
        return self.sign * self.scale * force * self.per_newton + self.offset

    def force(self, value: float, before: float, measured: float, position: float) -> float:
        """Return the force [N] that a device makes of ``value``; the other arguments as of :meth:`value`."""
        if self.kind == "position":
            return measured + (value - position) / (self.sign * self.scale * self.per_newton)
        force = (value - self.offset) / (self.sign * self.scale * self.per_newton)
        if self.kind == "increment":
            force += measured if math.isnan(before) else before
        return force

    def at_rest(self, force: float) -> float:
        """Return the position of a spring as stiff as the map says that is pressed with ``force`` [N]."""
        return self.sign * self.scale * force * self.per_newton


def law_of(command: CommandMap, unit: str, where: str) -> Law:
    """Return the law of ``command``, whose signal is in ``unit``.

    Raises:
        ConfigError: a unit of another quantity.

    """
    if command.kind == "position":
        number, per = quantity(command.stiffness, f"{where}: 'stiffness'")
        scale = conversion(product(unit, per), "N", f"{where}: 'stiffness'")[0] if unit else 1.0
        if number * scale <= 0.0:
            raise ConfigError(
                f"{where}: 'stiffness' is {command.stiffness!r}; it must be positive; direction "
                "is set by 'sign'"
            )
        per_newton = 1.0 / (number * scale)
    elif command.gain:
        per_newton = worth("N", command.gain, unit, where)[0]
    else:
        per_newton = 1.0 / conversion(unit, "N", f"{where}: 'unit'")[0]
    return Law(command.kind, per_newton, command.sign, command.scale, command.offset)


@dataclass(slots=True)
class Target:
    """One finger in one of their messages."""

    finger: str
    law: Law
    place: Any  # the signal, or the path
    low: float
    high: float
    raw: bool
    shares: tuple[tuple[Signal, float], ...] = ()  # other signals that get so much of the value
    command: ForceCommand | None = None
    sent: float = math.nan  # [N] the force of the last message
    is_fresh: bool = False


@dataclass(slots=True)
class Outgoing:
    """One of their messages, with all fingers in it."""

    name: str  # of the message, or the topic
    counter: Any = None  # where its count goes
    constants: dict[Any, Any] = field(default_factory=dict)  # what else stands in it, by its place
    targets: list[Target] = field(default_factory=list)
    count: int = 0
    last: int = NOT_YET  # [ns] when it was last sent
    # of a frame
    modulus: int = 1
    guard: Protection | None = None
    checksum: str = ""  # the signal with it


class Commands(ABC):
    """All commands of a hand.

    Args:
        plan: of the hand.
        state_of: what is measured, for increments and positions.
        clipped: where values beyond a signal, and commands that cannot be sent, are counted by finger.

    """

    def __init__(self, plan: Plan, state_of: StateOf, clipped: Counter[str]) -> None:
        self.held = 0  # messages that repeated a command whose time had run out
        self._plan = plan
        self._state_of = state_of
        self._clipped = clipped
        self._period = round(plan.hand.sending.period * NS)
        self._stops = plan.hand.sending.silence == "holds"
        self._outgoing: dict[Any, Outgoing] = {}
        self._of: dict[str, tuple[Outgoing, Target]] = {}  # by finger
        for finger in plan.fingers:
            command = plan.hand.fingers[finger.name].command
            if command is None:
                continue
            where = f"{plan.hand.path} [fingers.{finger.name}.command]"
            outgoing, target = self._add(finger.name, command, where)
            if any(each.place == target.place for each in outgoing.targets):
                raise ConfigError(f"{where}: {command.signal} already takes the command of another finger")
            outgoing.targets.append(target)
            self._of[finger.name] = outgoing, target

    @property
    def targets(self) -> Mapping[str, tuple[Outgoing, Target]]:
        """Where the command of each finger goes."""
        return self._of

    @abstractmethod
    def _add(self, finger: str, command: CommandMap, where: str) -> tuple[Outgoing, Target]:
        """Return the outgoing message and the target of ``command``."""

    @abstractmethod
    def _packed(self, outgoing: Outgoing, values: list[tuple[Target, float, Any]]) -> Any:
        """Return the message with ``values``: target, value in its unit, value on the wire."""

    def _raw(self, target: Target, value: float) -> tuple[Any, bool]:  # noqa: ARG002
        """Return ``value`` on the wire, and whether the signal cannot hold it."""
        return value, False

    def encode(self, command: ForceCommand) -> list[Any]:
        """Return the message with ``command``, once all fingers in it have theirs."""
        if command.finger not in self._of:
            return []
        outgoing, target = self._of[command.finger]
        if not (math.isfinite(command.normal_force) and command.normal_force >= 0.0):
            self._clipped[command.finger] += 1
            return []
        target.command, target.is_fresh = command, True
        if len(outgoing.targets) > 1 and not all(each.is_fresh for each in outgoing.targets):
            return []
        return self._message(outgoing, command.stamp)

    def due(self, now: int) -> list[Any]:
        """Return the messages whose last one is a period ago at ``now`` [ns]: the last command is held."""
        found: list[Any] = []
        for outgoing in self._outgoing.values():
            if now - outgoing.last < self._period:
                continue
            expired = all(
                each.command is not None and each.command.expires <= now for each in outgoing.targets
            )
            if expired and self._stops:
                continue
            messages = self._message(outgoing, now)
            self.held += expired and len(messages)
            found += messages
        return found

    def _message(self, outgoing: Outgoing, now: int) -> list[Any]:
        values: list[tuple[Target, float, Any]] = []
        forces: list[float] = []
        for target in outgoing.targets:
            measured, position = self._state_of(target.finger)
            force = measured if target.command is None else target.command.normal_force
            value = target.law.value(force, target.sent, measured, position)
            if not math.isfinite(value):  # no command and no measurement yet: the hand holds by itself
                return []
            bounded = min(max(value, target.low), target.high)
            raw, is_beyond = self._raw(target, bounded)
            if bounded != value or is_beyond:
                self._clipped[target.finger] += 1
            values.append((target, bounded, raw))
            forces.append(force)
        packed = self._packed(outgoing, values)
        for target, force in zip(outgoing.targets, forces, strict=True):
            target.is_fresh, target.sent = False, force
        outgoing.count += 1
        outgoing.last = now
        return [packed]


class TopicCommands(Commands):
    """All commands of a hand on a network, as topic and payload."""

    def __init__(self, plan: Plan, state_of: StateOf, clipped: Counter[str], bodies: Bodies) -> None:
        self._bodies = bodies
        super().__init__(plan, state_of, clipped)

    def _packed(self, outgoing: Outgoing, values: list[tuple[Target, float, Any]]) -> tuple[str, bytes]:
        entries = [(target.place, value) for target, value, _ in values]
        entries += outgoing.constants.items()
        if outgoing.counter:
            entries.append((outgoing.counter, outgoing.count))
        body: Any = None
        for steps, value in entries:
            body = self._bodies.put(outgoing.name, body, steps, value)
        return outgoing.name, self._bodies.dump(body)

    def _add(self, finger: str, command: CommandMap, where: str) -> tuple[Outgoing, Target]:
        name, colon, path = command.signal.partition(":")
        if not colon:
            raise ConfigError(
                f"{where}: {command.signal!r} must be TOPIC:PATH, as in 'hand/command:fingers[0].force'"
            )
        topic = name.strip()
        outgoing = self._outgoing.setdefault(topic, Outgoing(topic))
        steps, law = parse_path(path.strip(), where), law_of(command, command.unit, where)
        outgoing.constants |= {parse_path(name, where): value for name, value in command.set.items()}
        spec = self._plan.protection.get(topic)
        if spec is not None and spec.counter:
            outgoing.counter = parse_path(spec.counter, where)
        for each in (steps, *outgoing.constants, *filter(None, [outgoing.counter])):
            self._bodies.check(topic, each, where)
        return outgoing, Target(finger, law, steps, *_bounds(command, math.nan, math.nan), command.raw)


class FrameCommands(Commands):
    """All commands of a hand on a CAN bus, or in packets."""

    @property
    def unset(self) -> dict[str, list[str]]:
        """The signals of each message that are sent as raw zero because the map says nothing of them."""
        return {
            one.name: [
                name
                for name, signal in self._plan.database.messages[one.name].signals.items()
                if _is_sent(one, signal) and name not in _filled(one)
            ]
            for one in self._outgoing.values()
        }

    def _packed(self, outgoing: Outgoing, values: list[tuple[Target, float, Any]]) -> Frame:
        raws = outgoing.constants.copy()
        for target, value, raw in values:
            raws[target.place.name] = raw
            for signal, ratio in target.shares:
                raws[signal.name] = raw_of(signal, ratio * value, raw=target.raw)[0]
        if outgoing.counter:
            raws[outgoing.counter] = outgoing.count % outgoing.modulus
        message = self._plan.database.messages[outgoing.name]
        data = packed(message, raws)
        for place, byte in enumerate(message.template):
            data[place] |= byte
        if outgoing.guard is not None:
            outgoing.guard.protect(data)
        return Frame(message.identifier, bytes(data), message.fd)

    def _raw(self, target: Target, value: float) -> tuple[int, bool]:
        return raw_of(target.place, value, raw=target.raw)

    def _add(self, finger: str, command: CommandMap, where: str) -> tuple[Outgoing, Target]:
        message, signal = find_signal(self._plan.database, command.signal, where)
        law = law_of(command, command.unit or signal.unit, where)
        is_declared = signal.low < signal.high and not command.raw
        low, high = _bounds(command, *((signal.low, signal.high) if is_declared else (math.nan, math.nan)))
        shares = tuple((message.signals[_own(message, n, where)], r) for n, r in command.shares.items())
        selectors: dict[str, int] = {}
        inner: Signal | None = signal
        while inner is not None and inner.selected_by:
            selectors[inner.selected_by] = inner.selectors[0]
            inner = message.signals.get(inner.selected_by)
        key = message.name, tuple(sorted(selectors.items()))
        if key not in self._outgoing:
            self._outgoing[key] = self._open(message, selectors)
        outgoing = self._outgoing[key]
        for name, value in command.set.items():
            own = _own(message, name, where)
            outgoing.constants[own] = raw_of(message.signals[own], value)[0]
        return outgoing, Target(finger, law, signal, low, high, command.raw, shares)

    def _open(self, message: ForeignMessage, selectors: dict[str, int]) -> Outgoing:
        outgoing = Outgoing(message.name, constants=dict(selectors))
        spec = self._plan.protection.get(message.name)
        if spec is not None:
            where = f"{self._plan.hand.path} [messages.{message.name}.checksum]"
            outgoing.guard = protection(spec.checksum, message, where)
            outgoing.checksum = spec.checksum.signal
            outgoing.counter = spec.counter
            outgoing.modulus = spec.modulus or (
                1 << message.signals[spec.counter].length if spec.counter else 1
            )
        return outgoing


def packed(message: ForeignMessage, raws: Mapping[str, int]) -> bytearray:
    """Return a frame of ``message`` with the raw values ``raws`` by signal, all other bits zero."""
    length = message.length
    little = big = 0
    for name, raw in raws.items():
        signal = message.signals[name]
        bits = (raw & (1 << signal.length) - 1) << signal.shift(length)
        if signal.is_big_endian:
            big |= bits
        else:
            little |= bits
    if big:
        little |= int.from_bytes(big.to_bytes(length, "big"), "little")
    return bytearray(little.to_bytes(length, "little"))


def raw_of(signal: Signal, value: float, *, raw: bool = False) -> tuple[int, bool]:
    """Return the raw value that carries the physical ``value``, and whether the signal cannot hold it.

    It is the end of the range then; it never wraps.
    """
    steps = value if raw else (value - signal.offset) / signal.scale
    if signal.is_float:
        try:
            return int.from_bytes(struct.pack(FLOATS[signal.length], steps), "little"), False
        except OverflowError:
            return 0, True
    low, high = signal.raw_range
    whole = round(steps)
    return min(max(whole, low), high), not low <= whole <= high


def _filled(outgoing: Outgoing) -> set[str]:
    shared = {signal.name for target in outgoing.targets for signal, _ in target.shares}
    own = {target.place.name for target in outgoing.targets}
    return own | shared | outgoing.constants.keys() | {outgoing.counter, outgoing.checksum}


def _is_sent(outgoing: Outgoing, signal: Signal) -> bool:
    """Whether ``signal`` is on the page that is sent."""
    return not signal.selected_by or outgoing.constants.get(signal.selected_by) in signal.selectors


def _bounds(command: CommandMap, low: float, high: float) -> tuple[float, float]:
    """Return the least and largest value in the unit: of the map, else those declared, NaN where none are."""
    least, most = (
        declared if math.isnan(stated) else stated
        for stated, declared in ((command.low, low), (command.high, high))
    )
    return -math.inf if math.isnan(least) else least, math.inf if math.isnan(most) else most


def _own(message: ForeignMessage, name: str, where: str) -> str:
    plain = name.removeprefix(f"{message.name}.")
    if plain not in message.signals:
        raise ConfigError(
            f"{where}: 'set' names {name!r}; {suggestion(plain, message.signals, f'{message.name} has')}"
        )
    return plain
