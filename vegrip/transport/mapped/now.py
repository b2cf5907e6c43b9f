"""What a foreign hand sends just now: its signals in their units, or what a map makes of them in SI. Pure."""

import math
from typing import Protocol

from vegrip.messages import FingertipState
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.compiled import Read, compile_reader, groups_of
from vegrip.transport.mapped.database import Database, ForeignMessage
from vegrip.transport.mapped.guess import guesses
from vegrip.transport.mapped.plan import Plan, Slot
from vegrip.transport.mapped.units import SI

HIDDEN = ("counter", "checksum", "command")

Row = tuple[str, str, float, str]
"""Finger or message, channel or signal, value, unit."""


class Now(Protocol):
    """The last values."""

    def take(self, frame: Frame) -> None:
        """Look at a frame."""

    def rows(self) -> list[Row]:
        """Return all values, NaN where none came."""


class SignalsNow:
    """The signals of a database that may be of a fingertip, in its units."""

    def __init__(self, database: Database) -> None:
        wanted: dict[str, list[str]] = {}
        for one in guesses(database):
            if one.channel not in HIDDEN and not database.messages[one.message].asked:
                wanted.setdefault(one.message, []).append(one.signal)
        self._slots: list[Slot] = []
        self._values: list[float] = []
        self._reads: dict[int, tuple[ForeignMessage, Read]] = {}
        for name, signals in wanted.items():
            message = database.messages[name]
            own = [self._slot(message, signal) for signal in message.signals if signal in signals]
            self._reads[message.identifier] = message, compile_reader(message, groups_of(message, own), 0)

    def take(self, frame: Frame) -> None:
        """Look at a frame."""
        message, read = self._reads.get(frame.arbitration_id, (None, None))
        if message is not None and read is not None and len(frame.data) >= message.length:
            read(frame.data[: message.length], self._values)

    def rows(self) -> list[Row]:
        """Return all values."""
        return [
            (slot.message, slot.signal, value, slot.place.unit if slot.place is not None else "")
            for slot, value in zip(self._slots, self._values, strict=True)
        ]

    def _slot(self, message: ForeignMessage, name: str) -> Slot:
        signal = message.signals[name]
        slot = Slot(len(self._slots), message.name, name, signal, signal.scale, signal.offset)
        self._slots.append(slot)
        self._values.append(math.nan)
        return slot


class MappedNow:
    """The channels of a map, in SI; a hand on a network has none here."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._codec = None if plan.hand.format else MappedCodec(plan)
        self._last: dict[str, FingertipState] = {}

    def take(self, frame: Frame) -> None:
        """Look at a frame."""
        if self._codec is not None:
            self._last |= {state.finger: state for state in self._codec.decode_all(frame)}

    def rows(self) -> list[Row]:
        """Return all values."""
        return [
            (finger.name, name, getattr(self._last.get(finger.name), name, math.nan), SI[name])
            for finger in self._plan.fingers
            for name in sorted(finger.measured)
        ]
