"""One kind of message of one finger -> its frames."""

import math
from collections import Counter
from collections.abc import Callable
from typing import Any, Final

from vegrip.messages import make_row
from vegrip.transport.codec.cells import Place, Raw
from vegrip.transport.codec.convert import compiled
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
        self._only = self._parts[0] if layout.parts[0].last is None else None

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
        if self._only is not None:
            row = self._only.row(message)
            return [] if row is None else [self._only.frame(row)]
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
        self.identifier = part.base + offset
        self._clipped = clipped
        self._pack, self._protect, self._fd = part.packer.pack, part.profile.protect, part.fd
        self.row: Callable[[Any], list[Raw] | None] = self._compiled(version % part.version_modulus)
        """Returns the cells of this part, None when the message must not be sent."""

    def raw(self, name: str, value: Any) -> Raw | None:
        """Return the raw value of a signal; None when it cannot carry ``value``."""
        slot = next(slot for slot in self._part.slots if slot.name == name)
        return slot.convert.write(value)

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
        data = bytearray(self._pack(*row))
        self._protect(data, self.identifier)
        frame: Frame = make_row(Frame, (self.identifier, bytes(data), self._fd, 0))
        return frame

    def _compiled(self, version: int) -> Any:
        part = self._part
        cells: dict[int, list[str]] = {}

        def put(place: Place, text: str) -> None:
            cells.setdefault(place.cell, []).append(f"({text}) << {place.shift}" if place.mask else text)

        put(part.version, str(version))
        put(part.counter, f"m.seq % {part.modulus}")
        if part.time is not None:
            put(part.time, f"m.stamp // {MICROSECOND} % {TIME_MODULUS}")
        lines: list[str] = ["def made(m):"]
        scope: dict[str, Any] = {"clip": self._clip}
        for i, slot in enumerate(part.slots):
            scope |= {f"g{i}": slot.get, f"w{i}": slot.convert.write}
            lines.append(f" v{i} = {slot.attribute or f'g{i}(m)'}")
            lines.append(f" r{i} = {slot.convert.writing(f'v{i}', f'w{i}')}")
            put(slot.place, f"r{i}")
        raws = "".join(f"r{i}, " for i in range(len(part.slots)))
        lines += [f" if None in ({raws}):", f"  found = clip(m, ({raws}))", "  if None in found:"]
        lines += ["   return None", f"  {raws}= found"]
        row = ", ".join(" | ".join(cells.get(cell, ["0"])) for cell in range(part.cells))
        return compiled([*lines, f" return [{row}]"], scope)

    def _clip(self, message: Any, raws: tuple[Any, ...]) -> list[Any]:
        slots = self._part.slots
        self._clipped.update(slot.name for slot, raw in zip(slots, raws, strict=True) if raw is None)
        return [
            slot.convert.clip(slot.get(message)) if raw is None else raw
            for slot, raw in zip(slots, raws, strict=True)
        ]


def _are_same(raw: Raw, absent: Raw) -> bool:
    return raw == absent or (math.isnan(raw) and math.isnan(absent))
