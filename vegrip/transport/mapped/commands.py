"""Commands to a foreign hand as safely as to our own, whatever its wire.

Their protocols mostly have neither a lifetime nor a fail-safe, so this side keeps them: a message leaves at a
fixed rate as long as a command is in force; when commands stop, the last one is held, and no value is ever
sent as zero for want of a command.
"""

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import ForceCommand
from vegrip.transport.mapped.plan import NOT_YET, Plan
from vegrip.transport.mapped.schema import CommandMap
from vegrip.transport.mapped.units import conversion, product, quantity

StateOf = Callable[[str], tuple[float, float]]
"""The last normal force [N] and the position in the unit of their signal, by finger."""

Packed = TypeVar("Packed")


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


@dataclass(slots=True, kw_only=True)
class Target:
    """One finger in one of their messages."""

    finger: str
    law: Law
    low: float
    high: float
    command: ForceCommand | None = None
    sent: float = math.nan  # [N] the force of the last message
    is_fresh: bool = False


@dataclass(slots=True, kw_only=True)
class Outgoing:
    """One of their messages, with all fingers in it."""

    targets: list[Any]  # of Target
    count: int = 0
    last: int = NOT_YET  # [ns] when it was last sent


class Commands(ABC, Generic[Packed]):
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
        self._outgoing: dict[Any, Any] = {}  # of Outgoing
        self._of: dict[str, tuple[Any, Any]] = {}  # finger -> its Outgoing and its Target
        for finger in plan.fingers:
            command = plan.hand.fingers[finger.name].command
            if command is not None:
                where = f"{plan.hand.path} [fingers.{finger.name}.command]"
                self._of[finger.name] = self._add(finger.name, command, where)

    @abstractmethod
    def _add(self, finger: str, command: CommandMap, where: str) -> tuple[Any, Any]:
        """Return the outgoing message and the target of ``command``."""

    @abstractmethod
    def _packed(self, outgoing: Any, values: list[tuple[Any, float, Any]]) -> Packed:
        """Return the message with ``values``: target, value in its unit, value on the wire."""

    def _raw(self, target: Any, value: float) -> tuple[Any, bool]:  # noqa: ARG002
        """Return ``value`` on the wire, and whether the signal cannot hold it."""
        return value, False

    def encode(self, command: ForceCommand) -> list[Packed]:
        """Return the message with ``command``, once all fingers in it have theirs."""
        outgoing, target = self._of.get(command.finger, (None, None))
        if outgoing is None:
            return []
        if not (math.isfinite(command.normal_force) and command.normal_force >= 0.0):
            self._clipped[command.finger] += 1
            return []
        target.command, target.is_fresh = command, True
        if len(outgoing.targets) > 1 and not all(each.is_fresh for each in outgoing.targets):
            return []
        return self._message(outgoing, command.stamp)

    def due(self, now: int) -> list[Packed]:
        """Return the messages whose last one is a period ago at ``now`` [ns]: the last command is held."""
        found: list[Packed] = []
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

    def _message(self, outgoing: Any, now: int) -> list[Packed]:
        values: list[tuple[Any, float, Any]] = []
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
