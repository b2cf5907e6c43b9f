"""One kind of message of one finger -> its frames."""

import math
from collections import Counter
from typing import Any, Final

from vegrip.codec.cells import Raw
from vegrip.codec.frame import Frame
from vegrip.codec.layout import Layout, Part, Slot

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

    def encode(self, message: Any) -> list[Frame]:
        """Return the frames of ``message`` in order; empty parts at the end are left out."""
        rows = []
        for part in self._parts:
            row = part.row(message)
            if row is None:
                return []
            rows.append(row)
        while len(rows) > 1 and self._parts[len(rows) - 1].empty(rows[-1]):
            rows.pop()
        self._parts[len(rows) - 1].mark_last(rows[-1])
        return [part.frame(row) for part, row in zip(self._parts, rows, strict=False)]


class _PartEncoder:
    def __init__(self, part: Part, offset: int, version: int, clipped: Counter[str]) -> None:
        self._part = part
        self._identifier = part.base + offset
        self._clipped = clipped
        self._blank: list[Raw] = [0] * part.cells
        part.version.put(self._blank, version % part.version_modulus)
        self._writers = [(slot, slot.get, slot.convert.write, slot.place) for slot in part.slots]

    def row(self, message: Any) -> list[Raw] | None:
        """Return the cells of this part, None when the message must not be sent."""
        part = self._part
        row = self._blank.copy()
        part.counter.put(row, message.seq % part.modulus)
        if part.time is not None:
            part.time.put(row, message.stamp // MICROSECOND % TIME_MODULUS)
        for slot, get, write, place in self._writers:
            raw = write(get(message))
            if raw is None:
                raw = self._clip(slot, message)
                if raw is None:
                    return None
            if place.mask:
                place.put(row, raw)
            else:
                row[place.cell] = raw
        return row

    def empty(self, row: list[Raw]) -> bool:
        """Whether the part says nothing that its absence does not say."""
        cells = tuple(row)
        return all(_same(slot.place.get(cells), slot.convert.absent) for slot in self._part.slots)

    def mark_last(self, row: list[Raw]) -> None:
        """Say that no further part comes."""
        if self._part.last is not None:
            self._part.last.put(row, 1)

    def frame(self, row: list[Raw]) -> Frame:
        """Pack and protect."""
        data = bytearray(self._part.packer.pack(*row))
        self._part.profile.protect(data, self._identifier)
        return Frame(self._identifier, bytes(data), self._part.fd)

    def _clip(self, slot: Slot, message: Any) -> Raw | None:
        self._clipped[slot.name] += 1
        return slot.convert.clip(slot.get(message))


def _same(raw: Raw, absent: Raw) -> bool:
    return raw == absent or (math.isnan(raw) and math.isnan(absent))
