"""A ForceCommand into the frames of a foreign hand."""

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from vegrip.errors import ConfigError, suggestion
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.checksums import Protection, protection
from vegrip.transport.mapped.commands import Commands, Outgoing, Target, law_of
from vegrip.transport.mapped.database import ForeignMessage, Signal
from vegrip.transport.mapped.plan import find_signal
from vegrip.transport.mapped.schema import CommandMap

_FLOATS: Final = {16: "<e", 32: "<f", 64: "<d"}


BitField = tuple[int, int, bool]
"""Shift, mask, and whether the bits are counted from the end of the frame."""


@dataclass(slots=True, kw_only=True)
class _Target(Target):
    signal: Signal
    raw: bool
    shares: tuple[tuple[Signal, float], ...]  # other signals that get so much of the value


@dataclass(slots=True, kw_only=True)
class _Outgoing(Outgoing):
    message: ForeignMessage
    blank: dict[str, int]
    places: dict[str, BitField]  # of its signals
    counter: str = ""
    modulus: int = 1
    guard: Protection | None = None
    checksum: str = ""  # the signal with it


class CommandEncoder(Commands[Frame]):
    """All commands of a hand on a CAN bus, or in packets."""

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

    def _packed(self, outgoing: _Outgoing, values: list[tuple[_Target, float, int]]) -> Frame:
        raws = outgoing.blank.copy()
        for target, value, raw in values:
            raws[target.signal.name] = raw
            for signal, ratio in target.shares:
                raws[signal.name] = raw_of(signal, ratio * value, raw=target.raw)[0]
        if outgoing.counter:
            raws[outgoing.counter] = outgoing.count % outgoing.modulus
        message = outgoing.message
        data = packed(outgoing.places, message.length, raws)
        for place, byte in enumerate(message.template):
            data[place] |= byte
        if outgoing.guard is not None:
            outgoing.guard.protect(data)
        return Frame(message.identifier, bytes(data), message.fd)

    def _raw(self, target: _Target, value: float) -> tuple[int, bool]:
        return raw_of(target.signal, value, raw=target.raw)

    def _add(self, finger: str, command: CommandMap, where: str) -> tuple[_Outgoing, _Target]:
        message, signal = find_signal(self._plan.database, command.signal, where)
        law = law_of(command, command.unit or signal.unit, where)
        low, high = _bounds(command, signal)
        shares = tuple((message.signals[_own(message, n, where)], r) for n, r in command.shares.items())
        target = _Target(
            finger=finger, law=law, low=low, high=high, signal=signal, raw=command.raw, shares=shares
        )
        selectors = _selectors(message, signal)
        key = message.name, tuple(sorted(selectors.items()))
        outgoing: _Outgoing = self._outgoing.get(key) or self._open(message, selectors)
        if any(each.signal.name == signal.name for each in outgoing.targets):
            raise ConfigError(f"{where}: {command.signal} already takes the command of another finger")
        for name, value in command.set.items():
            own = _own(message, name, where)
            outgoing.blank[own] = raw_of(message.signals[own], value)[0]
        outgoing.targets.append(target)
        self._outgoing[key] = outgoing
        return outgoing, target

    def _open(self, message: ForeignMessage, selectors: dict[str, int]) -> _Outgoing:
        spec = self._plan.protection.get(message.name)
        if spec is None:
            return _Outgoing(targets=[], message=message, blank=dict(selectors), places=places_of(message))
        where = f"{self._plan.hand.path} [messages.{message.name}.checksum]"
        return _Outgoing(
            targets=[],
            message=message,
            blank=dict(selectors),
            places=places_of(message),
            counter=spec.counter,
            modulus=spec.modulus or (1 << message.signals[spec.counter].length if spec.counter else 1),
            guard=protection(spec.checksum, message, where),
            checksum=spec.checksum.signal,
        )


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
