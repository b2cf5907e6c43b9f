"""Commands to a foreign hand as safely as to our own, whatever its wire.

Their protocols mostly have neither a lifetime nor a fail-safe, so this side keeps them: a message leaves at a
fixed rate as long as a command is in force; when commands stop, the last one is held, and no value is ever
sent as zero for want of a command.
"""

import math
import struct
import sys
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from vegrip.clock import NOT_YET, NS
from vegrip.errors import ConfigError, suggestion
from vegrip.messages import ForceCommand, make_row
from vegrip.transport.canbus.frame_time import fd_size
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.bodies import Bodies
from vegrip.transport.mapped.body_paths import parse_path
from vegrip.transport.mapped.compiled import made, packing
from vegrip.transport.mapped.plan import Plan, find_signal
from vegrip.transport.maps.checksums import Protection
from vegrip.transport.maps.schema import CommandMap
from vegrip.transport.maps.signals import ForeignMessage, Signal
from vegrip.transport.maps.units import conversion, product, quantity, worth

StateOf = Callable[[str], tuple[float, float]]
"""The last normal force [N] and the position in the unit of their signal, by finger."""

Write = Callable[[float], tuple[Any, bool]]
"""From a value in its unit to that on the wire, and whether the signal cannot hold it."""

FLOATS: Final = {16: "<e", 32: "<f", 64: "<d"}
LARGEST: Final = {16: 65504.0, 32: (2.0 - 2.0**-23) * 2.0**127, 64: sys.float_info.max}
"""That such a float holds."""
ROUNDED: Final = 1e-5  # of a gain and an offset that are written in a map, times the largest value
ON_STATE: Final = frozenset({"position", "increment"})
"""Kinds of commands that rest on what is measured."""


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

    def text(self, force: str, before: str) -> str:
        """Return the text of the value to send, NaN when it cannot be known.

        ``force`` is the name of the wanted one [N], ``before`` of that of the last message, NaN before the
        first; the present one is ``felt``.
        """
        gain = repr(self.sign * self.scale)
        if self.kind == "position":  # the present one is in the unit of the signal
            return f"position + {gain} * ({force} - felt) * {self.per_newton!r}"
        if self.kind == "increment":
            force = f"({force} - (felt if {before} != {before} else {before}))"
        return f"{gain} * {force} * {self.per_newton!r} + {self.offset!r}"

    def force(self, value: float, before: float, measured: float, position: float) -> float:
        """Return the force [N] that a device makes of ``value``; the other arguments as of :meth:`text`."""
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
    raw: bool = False
    write: Write = lambda value: (value, False)
    usual: tuple[str, str] | None = "True", "value"
    """The texts of what most values are, and of what goes on the wire for them; None: ``write`` is called."""
    shares: tuple[tuple[Signal, Write, float], ...] = ()  # other signals that get so much of the value
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
    waits: bool = False  # its device answers it: it is made when it is its turn on the line
    is_wanted: bool = False  # of one that waits
    opens: bool = False  # a force of zero opens, by a motion or by a message of its own
    motion: CommandMap | None = None  # whose position goes with each new force
    turn: int = 0  # of the positions that are asked for
    moved: Any = None  # the raw force that was sent last
    message: Callable[[int], list[Any]] = lambda _: []
    """Made of what the targets are to get now, at a time [ns]; none while a value is not known."""

    def position(self, force: float, raw: int) -> int:
        """Return the raw position to ask for with a force [N] that is sent as ``raw``."""
        motion = self.motion
        assert motion is not None  # noqa: S101 (asked for only where there is one)
        if force <= 0.0:
            return motion.opened
        if raw != self.moved:
            self.moved, self.turn = raw, (self.turn + 1) % len(motion.closed)
        return motion.closed[self.turn]


class Commands(ABC):
    """All commands of a hand."""

    def __init__(self, plan: Plan, state_of: StateOf, clipped: Counter[str]) -> None:
        self.held = 0  # messages that repeated a command whose time had run out
        self._plan = plan
        self._state_of = state_of
        self._clipped = clipped
        self._period = round(plan.hand.command.period * NS)
        self._holds_itself = plan.hand.command.silence == "holds"
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
        for each in self._outgoing.values():
            each.message = self._compiled(each)

    @property
    def targets(self) -> Mapping[str, tuple[Outgoing, Target]]:
        return self._of

    @abstractmethod
    def _add(self, finger: str, command: CommandMap, where: str) -> tuple[Outgoing, Target]:
        """Return the outgoing message and the target of ``command``."""

    @abstractmethod
    def _packing(self, outgoing: Outgoing, raws: list[str], scope: dict[str, Any]) -> str:
        """Return the text that packs the raw values of the targets, each followed by those of its shares."""

    def encode(self, command: ForceCommand) -> list[Any]:
        """Return the message with ``command``, once all fingers in it have theirs."""
        known = self._of.get(command.finger)
        if known is None:
            return []
        outgoing, target = known
        if not 0.0 <= command.normal_force < math.inf:
            self._clipped[command.finger] += 1
            return []
        target.command, target.is_fresh = command, True
        if len(outgoing.targets) > 1 and not all(each.is_fresh for each in outgoing.targets):
            return []
        outgoing.is_wanted = outgoing.waits
        return [] if outgoing.waits else outgoing.message(command.stamp)

    def due(self, now: int) -> list[Any]:
        """Return the messages whose last one is a period ago at ``now`` [ns]: the last command is held."""
        found: list[Any] = []
        for outgoing in self._outgoing.values():
            if now - outgoing.last < self._period:
                continue
            expired = all(
                each.command is not None and each.command.expires <= now for each in outgoing.targets
            )
            if expired and self._holds_itself:
                continue
            if outgoing.waits:
                outgoing.is_wanted = True
                self.held += expired and outgoing.last != NOT_YET
                continue
            messages = outgoing.message(now)
            self.held += expired and len(messages)
            found += messages
        return found

    def wanted(self) -> list[Outgoing]:
        """Return the messages to make as soon as the line is theirs."""
        return [each for each in self._outgoing.values() if each.is_wanted]

    def _compiled(self, outgoing: Outgoing) -> Callable[[int], list[Any]]:
        """Return the message as a function; called target by target it takes twice as long."""
        scope = {"outgoing": outgoing, "state_of": self._state_of, "nothing": (math.nan, math.nan)}
        lines, sent, raws = ["def message(now):"], [], list[str]()
        for number, target in enumerate(outgoing.targets):
            own, force, raw = f"t{number}", f"f{number}", f"r{number}"
            scope |= {own: target, f"n{number}": target.finger, f"w{number}": self._clipping(target)}
            otherwise = "" if target.law.kind in ON_STATE else " if command is None else nothing"
            # what is felt is taken over once: again and again, a sensor that reads less lets go bit by bit
            taken = "felt" if otherwise == "" else f"felt if {own}.sent != {own}.sent else {own}.sent"
            lines += [
                f" command = {own}.command",
                f" felt, position = state_of(n{number}){otherwise}",
                f" {force} = ({taken}) if command is None else command.normal_force",
                f" value = {target.law.text(force, f'{own}.sent')}",
                " if value - value != 0.0:",  # no command and no measurement yet: the hand holds by itself
                "  return []",
            ]
            if outgoing.opens:
                lines.append(f" value = {target.low!r} if {force} <= 0.0 else value")
            is_usual, usual = target.usual or ("False", "0")
            is_inside = f"{target.low!r} <= value <= {target.high!r}"
            lines.append(f" {raw} = {usual} if {is_usual} and {is_inside} else w{number}(value)")
            sent.append(f" {own}.is_fresh, {own}.sent = False, {force}")
            raws.append(raw)
            for place, (_, write, ratio) in enumerate(target.shares):
                scope[f"w{number}_{place}"] = write
                bounded = f"min(max(value, {target.low!r}), {target.high!r})"
                lines.append(f" r{number}_{place} = w{number}_{place}({ratio!r} * {bounded})[0]")
                raws.append(f"r{number}_{place}")
        lines += [self._packing(outgoing, raws, scope), *sent]
        lines += [" outgoing.count += 1", " outgoing.last = now", " return [made]"]
        message: Callable[[int], list[Any]] = made(lines, "message", scope)
        return message

    def _clipping(self, target: Target) -> Callable[[float], Any]:
        def write(value: float) -> Any:
            bounded = min(max(value, target.low), target.high)
            raw, is_beyond = target.write(bounded)
            if is_beyond or not math.isclose(bounded, value, rel_tol=0.0, abs_tol=ROUNDED):
                self._clipped[target.finger] += 1
            return raw

        return write


class TopicCommands(Commands):
    """All commands of a hand on a network, as topic and payload."""

    def __init__(self, plan: Plan, state_of: StateOf, clipped: Counter[str], bodies: Bodies) -> None:
        self._bodies = bodies
        super().__init__(plan, state_of, clipped)

    def _packing(self, outgoing: Outgoing, raws: list[str], scope: dict[str, Any]) -> str:
        def packed(*values: float) -> tuple[str, bytes]:
            entries = [(target.place, value) for target, value in zip(outgoing.targets, values, strict=True)]
            entries += outgoing.constants.items()
            if outgoing.counter:
                entries.append((outgoing.counter, outgoing.count))
            body: Any = None
            for steps, value in entries:
                body = self._bodies.put(outgoing.name, body, steps, value)
            return outgoing.name, self._bodies.dump(body)

        scope["packed"] = packed
        return f" made = packed({', '.join(raws)})"

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
        spec = self._plan.hand.messages.get(topic)
        if spec is not None and spec.counter:
            outgoing.counter = parse_path(spec.counter, where)
        for each in (steps, *outgoing.constants, *filter(None, [outgoing.counter])):
            self._bodies.check(topic, each, where)
        return outgoing, Target(finger, law, steps, *_bounds(command, math.nan, math.nan))


class FrameCommands(Commands):
    """All commands of a hand on a CAN bus, or in packets."""

    @property
    def unset(self) -> dict[str, list[str]]:
        """The signals of each message that are sent as raw zero because the map says nothing of them."""
        found: dict[str, list[str]] = {}
        for one in self._outgoing.values():
            of_message = found.setdefault(one.name, [])
            of_message += [
                name
                for name, signal in self._plan.database.messages[one.name].signals.items()
                if (not signal.selected_by or one.constants.get(signal.selected_by) in signal.selectors)
                and name not in {*of_message, *_filled(one)}
            ]
        return found

    def _packing(self, outgoing: Outgoing, raws: list[str], scope: dict[str, Any]) -> str:
        carried = [(target.place, *(each[0] for each in target.shares)) for target in outgoing.targets]
        names = [signal.name for signals in carried for signal in signals]
        numbers = outgoing.constants | dict(zip(names, raws, strict=True))
        if outgoing.counter:
            numbers[outgoing.counter] = f"outgoing.count % {outgoing.modulus}"
        if outgoing.motion is not None:
            numbers[outgoing.motion.motion] = "outgoing.position(f0, r0)"
        message = self._plan.database.messages[outgoing.name]
        scope |= {"row": make_row, "Frame": Frame}
        text = packing(message, numbers)
        if outgoing.guard is not None:
            scope["protect"] = outgoing.guard.protect
            text = f"bytearray({text})\n protect(data)"
        head = f" data = {text}\n"
        whole = f"bytes(data).ljust({fd_size(message.length)}, b'\\0')" if message.fd else "bytes(data)"
        return f"{head} made = row(Frame, ({message.identifier}, {whole}, {message.fd}, 0))"

    def _add(self, finger: str, command: CommandMap, where: str) -> tuple[Outgoing, Target]:
        message, signal = find_signal(self._plan.database, command.signal, where)
        law = law_of(command, command.unit or signal.unit, where)
        is_declared = signal.low < signal.high and not command.raw
        low, high = _bounds(command, *((signal.low, signal.high) if is_declared else (math.nan, math.nan)))
        own = {name: message.signals[_own(message, name, where)] for name in command.shares}
        shares = tuple(
            (own[name], rounding(own[name], raw=command.raw), ratio) for name, ratio in command.shares.items()
        )
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
            constant = _own(message, name, where)
            outgoing.constants[constant] = rounding(message.signals[constant])(value)[0]
        if command.motion:
            if outgoing.targets:
                raise ConfigError(f"{where}: 'motion' is for a message with the command of one finger")
            outgoing.opens = True
            outgoing.motion = replace(command, motion=_own(message, command.motion, where))
        write = rounding(signal, raw=command.raw)
        usual = None if signal.is_float else _usual(signal, raw=command.raw)
        return outgoing, Target(finger, law, signal, low, high, command.raw, write, usual, shares)

    def _open(self, message: ForeignMessage, selectors: dict[str, int]) -> Outgoing:
        packet = self._plan.hand.packets.get(message.name)
        waits = packet is not None and bool(packet.answer)
        opens = packet is not None and bool(packet.opened)
        outgoing = Outgoing(message.name, constants=dict(selectors), waits=waits, opens=opens)
        spec = self._plan.hand.messages.get(message.name)
        if spec is not None:
            outgoing.guard = self._plan.guard_of(message.name)
            outgoing.checksum = spec.checksum.signal
            outgoing.counter, outgoing.modulus = spec.counter, self._plan.modulus_of(message.name)
        return outgoing


def rounding(signal: Signal, *, raw: bool = False) -> Write:
    """Return what gives the raw value of ``signal`` that carries a physical value, or with ``raw`` a raw one.

    It is the end of the range where the signal cannot hold the value; it never wraps.
    """
    offset, scale = (0.0, 1.0) if raw else (signal.offset, signal.scale)
    low, high = signal.raw_range

    def whole(value: float) -> tuple[int, bool]:
        found = round((value - offset) / scale)
        return (found, False) if low <= found <= high else (min(max(found, low), high), True)

    def real(value: float) -> tuple[int, bool]:
        steps, end = (value - offset) / scale, LARGEST[signal.length]
        packed = struct.pack(FLOATS[signal.length], min(max(steps, -end), end))
        return int.from_bytes(packed, "little"), abs(steps) > end

    return real if signal.is_float else whole


def _usual(signal: Signal, *, raw: bool) -> tuple[str, str]:
    """Return the texts of :func:`rounding` for an integer that the signal can hold."""
    steps = "value" if raw else f"(value - {signal.offset!r}) / {signal.scale!r}"
    low, high = signal.raw_range
    return f"{low} <= (steps := {steps}) <= {high}", "round(steps)"


def _filled(outgoing: Outgoing) -> set[str]:
    shared = {signal.name for target in outgoing.targets for signal, _, _ in target.shares}
    own = {target.place.name for target in outgoing.targets}
    moved = {outgoing.motion.motion} if outgoing.motion is not None else set()
    return own | shared | moved | outgoing.constants.keys() | {outgoing.counter, outgoing.checksum}


def _bounds(command: CommandMap, low: float, high: float) -> tuple[float, float]:
    """Return the least and largest value in the unit: of the map, else those declared, NaN where none are."""
    least, most = command.range_or(low, high)
    return -math.inf if math.isnan(least) else least, math.inf if math.isnan(most) else most


def _own(message: ForeignMessage, name: str, where: str) -> str:
    plain = name.removeprefix(f"{message.name}.")
    if plain not in message.signals:
        raise ConfigError(
            f"{where}: 'set' names {name!r}; {suggestion(plain, message.signals, f'{message.name} has')}"
        )
    return plain
