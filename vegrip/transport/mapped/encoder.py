"""A ForceCommand into the messages of a foreign hand, as safely as into our own.

Their protocols mostly have neither a lifetime nor a fail-safe, so this side keeps them: a frame leaves at a
fixed rate as long as a command is in force; when commands stop, the last one is held, and nothing is ever
sent as zero because there was nothing to send.
"""

import math
import struct
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import ForceCommand
from vegrip.spelling import suggestion
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.checksums import Protection, protection
from vegrip.transport.mapped.database import ForeignMessage, Signal
from vegrip.transport.mapped.plan import Plan, find_signal
from vegrip.transport.mapped.schema import CommandMap, frames_in
from vegrip.transport.mapped.units import conversion, product, quantity

StateOf = Callable[[str], tuple[float, float]]
"""The last normal force [N] and the position in the unit of their signal, by finger."""

_FLOATS: Final = {16: "<e", 32: "<f", 64: "<d"}


@dataclass(frozen=True, slots=True)
class Law:
    """From a force to the value of their signal, in its unit: what does not depend on the protocol.

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
            before: the force of the last frame [N], NaN before the first.
            measured: the present force [N].
            position: the present position, in the unit of the signal.

        """
        if self.kind == "position":
            return position + self.sign * self.scale * (force - measured) * self.per_newton
        if self.kind == "increment":
            force -= measured if math.isnan(before) else before
        return self.sign * self.scale * force * self.per_newton + self.offset


def law_of(command: CommandMap, unit: str, where: str) -> Law:
    """Return the law of ``command``, whose signal is in ``unit``.

    Raises:
        ConfigError: a unit of another quantity.

    """
    if command.gain and command.kind != "position":
        number, per = quantity(command.gain, f"{where}: 'gain'")
        per_newton = number * (conversion(product("N", per), unit, f"{where}: 'gain'")[0] if unit else 1.0)
    elif command.kind == "position":
        number, per = quantity(command.stiffness, f"{where}: 'stiffness'")
        stiffness = (
            number * conversion(product(unit, per), "N", f"{where}: 'stiffness'")[0] if unit else number
        )
        if stiffness <= 0.0:
            raise ConfigError(
                f"{where}: 'stiffness' is {command.stiffness!r}; it must be positive; direction "
                "is set by 'sign'"
            )
        per_newton = 1.0 / stiffness
    else:
        per_newton = 1.0 / conversion(unit, "N", f"{where}: 'unit'")[0]
    return Law(command.kind, per_newton, command.sign, command.scale, command.offset)


@dataclass(slots=True)
class _Target:
    """One finger in one message."""

    finger: str
    signal: Signal
    law: Law
    raw: bool
    low: float
    high: float
    command: ForceCommand | None = None
    sent: float = math.nan  # [N] the force of the last frame
    is_fresh: bool = False
    shares: tuple[tuple[Signal, float], ...] = ()  # other signals that get so much of the value


BitField = tuple[int, int, bool]
"""Shift, mask, and whether the bits are counted from the end of the frame."""


@dataclass(slots=True)
class _Outgoing:
    """One message of theirs, with all fingers in it."""

    message: ForeignMessage
    targets: list[_Target]
    blank: dict[str, int]
    counter: str
    modulus: int
    guard: Protection | None
    checksum: str = ""  # the signal with it
    places: dict[str, BitField] = field(default_factory=dict)  # of its signals
    count: int = 0
    last: int = -(1 << 62)  # [ns] when it was last sent


class CommandEncoder:
    """All commands of a hand.

    Args:
        plan: of the hand.
        state_of: what is measured, for increments and positions.
        clipped: where values beyond a signal, and commands that cannot be sent, are counted by finger.

    """

    def __init__(self, plan: Plan, state_of: StateOf, clipped: Counter[str]) -> None:
        sending = plan.hand.sending
        where = f"{plan.hand.path} [command]"
        self.opening = (*plan.database.opening, *frames_in(sending.opening, f"{where} opening"))
        self._request = [Frame(*frame) for frame in frames_in(sending.request, f"{where} request")]
        self._requested = -(1 << 62)  # [ns] when last
        self.held = 0  # frames that repeated a command whose time had run out
        self._state_of = state_of
        self._clipped = clipped
        self._period = round(plan.hand.sending.period * NS)
        self._stops = plan.hand.sending.silence == "holds"
        self._outgoing: dict[tuple[str, tuple[tuple[str, int], ...]], _Outgoing] = {}
        self._of: dict[str, tuple[_Outgoing, _Target]] = {}
        for finger in plan.fingers:
            command = plan.hand.fingers[finger.name].command
            if command is not None:
                self._add(plan, finger.name, command)

    @property
    def unset(self) -> dict[str, list[str]]:
        """The signals of each message that are sent as raw zero because the map says nothing of them."""
        return {
            one.message.name: [
                name
                for name, signal in one.message.signals.items()
                if _is_sent(one, signal) and name not in _filled(one)
            ]
            for one in self._outgoing.values()
        }

    def take(self, command: ForceCommand) -> list[Frame]:
        """Return the frame that carries ``command``, now or when the other fingers in it have theirs."""
        found = self._of.get(command.finger)
        if found is None:
            return []
        outgoing, target = found
        if not (math.isfinite(command.normal_force) and command.normal_force >= 0.0):
            self._clipped[command.finger] += 1
            return []
        target.command, target.is_fresh = command, True
        if len(outgoing.targets) > 1 and not all(each.is_fresh for each in outgoing.targets):
            return []
        return self._frame(outgoing, command.stamp)

    def due(self, now: int) -> list[Frame]:
        """Return the frames whose last one is a period ago at ``now`` [ns].

        Requests keep their own period whatever is commanded: a hand may answer them alone.
        """
        frames = []
        for outgoing in self._outgoing.values():
            if now - outgoing.last < self._period:
                continue
            expired = all(
                each.command is not None and each.command.expires <= now for each in outgoing.targets
            )
            if expired and self._stops:
                continue
            self.held += expired
            frames += self._frame(outgoing, now)
        if self._request and now - self._requested >= self._period:
            self._requested = now
            frames += self._request
        return frames

    def _frame(self, outgoing: _Outgoing, now: int) -> list[Frame]:
        values, forces = outgoing.blank.copy(), []
        for target in outgoing.targets:
            measured, position = self._state_of(target.finger)
            force = measured if target.command is None else target.command.normal_force
            forces.append(force)
            value = target.law.value(force, target.sent, measured, position)
            if not math.isfinite(value):  # nothing is commanded, nothing is known: the hand holds by itself
                return []
            bounded = min(max(value, target.low), target.high)
            values[target.signal.name], is_beyond = raw_of(target.signal, bounded, raw=target.raw)
            if bounded != value or is_beyond:
                self._clipped[target.finger] += 1
            for signal, ratio in target.shares:
                values[signal.name] = raw_of(signal, ratio * bounded, raw=target.raw)[0]
        if outgoing.counter:
            values[outgoing.counter] = outgoing.count % outgoing.modulus
        for target, force in zip(outgoing.targets, forces, strict=True):
            target.is_fresh, target.sent = False, force
        outgoing.count += 1
        outgoing.last = now
        message = outgoing.message
        data = packed(outgoing.places, message.length, values)
        if outgoing.guard is not None:
            outgoing.guard.protect(data)
        return [Frame(message.identifier, bytes(data), message.fd)]

    def _add(self, plan: Plan, finger: str, command: CommandMap) -> None:
        where = f"{plan.hand.path} [fingers.{finger}.command]"
        message, signal = find_signal(plan.database, command.signal, where)
        selectors = _selectors(message, signal)
        key = message.name, tuple(sorted(selectors.items()))
        unit = command.unit or signal.unit
        law = law_of(command, unit, where)
        low, high = _bounds(command, signal)
        shares = tuple((message.signals[_own(message, n, where)], r) for n, r in command.shares.items())
        target = _Target(finger, signal, law, command.raw, low, high, shares=shares)
        outgoing = self._outgoing.get(key) or self._open(plan, message, selectors)
        if any(each.signal.name == signal.name for each in outgoing.targets):
            raise ConfigError(f"{where}: {command.signal} already takes the command of another finger")
        for name, value in command.set.items():
            outgoing.blank[_own(message, name, where)] = raw_of(
                message.signals[_own(message, name, where)], value
            )[0]
        outgoing.targets.append(target)
        self._outgoing[key] = outgoing
        self._of[finger] = outgoing, target

    def _open(self, plan: Plan, message: ForeignMessage, selectors: dict[str, int]) -> _Outgoing:
        spec = plan.protection.get(message.name)
        if spec is None:
            return _Outgoing(message, [], dict(selectors), "", 1, None, places=places_of(message))
        where = f"{plan.hand.path} [messages.{message.name}.checksum]"
        modulus = spec.modulus or (1 << message.signals[spec.counter].length if spec.counter else 1)
        guard = protection(spec.checksum, message, where)
        checksum, places = spec.checksum.signal, places_of(message)
        return _Outgoing(message, [], dict(selectors), spec.counter, modulus, guard, checksum, places=places)


def places_of(message: ForeignMessage) -> dict[str, BitField]:
    """Return where the bits of each signal go."""
    return {
        name: (signal.shift(message.length), (1 << signal.length) - 1, signal.is_big_endian)
        for name, signal in message.signals.items()
    }


def packed(places: Mapping[str, BitField], length: int, values: Mapping[str, int]) -> bytearray:
    """Return a frame of ``length`` bytes with the raw ``values``, all other bits zero."""
    little = big = 0
    for name, raw in values.items():
        shift, mask, is_big_endian = places[name]
        if is_big_endian:
            big |= (raw & mask) << shift
        else:
            little |= (raw & mask) << shift
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
            return int.from_bytes(struct.pack(_FLOATS[signal.length], steps), "little"), False
        except OverflowError:
            return 0, True
    low, high = signal.raw_range
    whole = round(steps)
    return min(max(whole, low), high), not low <= whole <= high


def _filled(outgoing: _Outgoing) -> set[str]:
    named = {outgoing.counter, outgoing.checksum}
    shared = {signal.name for target in outgoing.targets for signal, _ in target.shares}
    return {target.signal.name for target in outgoing.targets} | shared | outgoing.blank.keys() | named


def _is_sent(outgoing: _Outgoing, signal: Signal) -> bool:
    """Whether ``signal`` is on the page that is sent."""
    return not signal.selected_by or outgoing.blank.get(signal.selected_by) in signal.selectors


def _selectors(message: ForeignMessage, signal: Signal) -> dict[str, int]:
    """Return the raw values of the multiplexers that select ``signal``."""
    found: dict[str, int] = {}
    inner: Signal | None = signal
    while inner is not None and inner.selected_by:
        found[inner.selected_by] = inner.selectors[0]
        inner = message.signals.get(inner.selected_by)
    return found


def _bounds(command: CommandMap, signal: Signal) -> tuple[float, float]:
    """Return the least and largest value in the unit: of the map, else of the database."""
    declared = signal.low < signal.high and not command.raw
    low = command.low if not math.isnan(command.low) else signal.low if declared else -math.inf
    high = command.high if not math.isnan(command.high) else signal.high if declared else math.inf
    return low, high


def _own(message: ForeignMessage, name: str, where: str) -> str:
    plain = name.removeprefix(f"{message.name}.")
    if plain not in message.signals:
        raise ConfigError(
            f"{where}: 'set' names {name!r}; {suggestion(plain, message.signals, f'{message.name} has')}"
        )
    return plain
