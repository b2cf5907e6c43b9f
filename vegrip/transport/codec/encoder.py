"""One kind of message of one finger -> its frames."""

import math
from collections import Counter
from collections.abc import Callable
from operator import attrgetter
from typing import Any, Final

from vegrip.transport.codec.cells import Place, Raw
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.layout import Layout, Part

MICROSECOND: Final = 1000  # [ns]
TIME_MODULUS: Final = 1 << 32  # [us]


class Encoder:
    """Builds the frames of the messages of one kind for one finger (or node).

    Args:
        layout: the kind of message.
        offset: added to the base identifiers.
        version: of the message set.
        clipped: where values that the layout cannot carry are counted, by field.

    """

    def __init__(self, layout: Layout, offset: int, version: int, clipped: Counter[str]) -> None:
        self._parts = [_PartEncoder(part, offset, version, clipped) for part in layout.parts]

    @property
    def identifier(self) -> int:
        """Of the first frame."""
        return self._parts[0].identifier

    @property
    def identifiers(self) -> tuple[int, ...]:
        """Of all frames, in order."""
        return tuple(part.identifier for part in self._parts)

    def raw(self, name: str, value: Any) -> Raw | None:
        """Return the raw value of a signal of the first frame; None when it cannot carry ``value``."""
        return self._parts[0].raw(name, value)

    def encode(self, message: Any) -> list[Frame]:
        """Return the frames of ``message`` in order; empty parts at the end are left out."""
        rows = []
        for part in self._parts:
            row = part.row(message)
            if row is None:
                return []
            rows.append(row)
        while len(rows) > 1 and self._parts[len(rows) - 1].is_empty(rows[-1]):
            rows.pop()
        self._parts[len(rows) - 1].mark_last(rows[-1])
        return [part.frame(row) for part, row in zip(self._parts, rows, strict=False)]


class _PartEncoder:
    def __init__(self, part: Part, offset: int, version: int, clipped: Counter[str]) -> None:
        self._part = part
        self.identifier = self._identifier = part.base + offset
        self._clipped = clipped
        self._blank: list[Raw] = [0] * part.cells
        part.version.put(self._blank, version % part.version_modulus)
        self._values = _values_of(part)
        self._writers = [slot.convert.write for slot in part.slots]
        self._payload = _first_cell(part)

    def raw(self, name: str, value: Any) -> Raw | None:
        """Return the raw value of a signal; None when it cannot carry ``value``."""
        slot = next(slot for slot in self._part.slots if slot.name == name)
        return slot.convert.write(value)

    def row(self, message: Any) -> list[Raw] | None:
        """Return the cells of this part, None when the message must not be sent."""
        raws: list[Any] = [w(value) for w, value in zip(self._writers, self._values(message), strict=True)]
        if None in raws:
            raws = self._clip(raws, message)
            if None in raws:
                return None
        row = self._header(message)
        if self._payload:
            row[self._payload :] = raws
        else:
            for slot, raw in zip(self._part.slots, raws, strict=True):
                slot.place.put(row, raw)
        return row

    def is_empty(self, row: list[Raw]) -> bool:
        """Whether the part says nothing that its absence does not say."""
        cells = tuple(row)
        return all(_are_same(slot.place.get(cells), slot.convert.absent) for slot in self._part.slots)

    def mark_last(self, row: list[Raw]) -> None:
        """Say that no further part comes."""
        if self._part.last is not None:
            self._part.last.put(row, 1)

    def frame(self, row: list[Raw]) -> Frame:
        """Pack and protect."""
        data = bytearray(self._part.packer.pack(*row))
        self._part.profile.protect(data, self._identifier)
        return Frame(self._identifier, bytes(data), self._part.fd)

    def _header(self, message: Any) -> list[Raw]:
        part = self._part
        row = self._blank.copy()
        part.counter.put(row, message.seq % part.modulus)
        if part.time is not None:
            part.time.put(row, message.stamp // MICROSECOND % TIME_MODULUS)
        return row

    def _clip(self, raws: list[Any], message: Any) -> list[Any]:
        slots = self._part.slots
        self._clipped.update(slot.name for slot, raw in zip(slots, raws, strict=True) if raw is None)
        return [
            slot.convert.clip(value) if raw is None else raw
            for slot, raw, value in zip(slots, raws, self._values(message), strict=True)
        ]


def _values_of(part: Part) -> Callable[[Any], tuple[Any, ...]]:
    """Return the function that takes the values of all signals from a message, in C where it can."""
    attributes = [slot.attribute for slot in part.slots]
    if all(attributes) and len(attributes) > 1:
        return attrgetter(*attributes)
    getters = [slot.get for slot in part.slots]
    return lambda message: tuple(get(message) for get in getters)


def _first_cell(part: Part) -> int:
    """Return the first cell of the payload when its signals fill all cells from there on, else 0."""
    first = part.slots[0].place.cell
    whole = [Place(first + number) for number in range(len(part.slots))]
    return first if [slot.place for slot in part.slots] == whole and whole[-1].cell == part.cells - 1 else 0


def _are_same(raw: Raw, absent: Raw) -> bool:
    return raw == absent or (math.isnan(raw) and math.isnan(absent))
