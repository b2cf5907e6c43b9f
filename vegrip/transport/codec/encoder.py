"""One kind of message of one finger -> its frames."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, Final

from vegrip.messages import make_row
from vegrip.transport.codec.database import Layout, Part
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.signals import Place, Raw, compiled

MICROSECOND: Final = 1000  # [ns]
TIME_MODULUS: Final = 1 << 32  # [us]


class Encoder:
    """Builds the frames of the messages of one kind for one finger (or node)."""

    def __init__(self, layout: Layout, offset: int, version: int, clipped: Counter[str]) -> None:
        self._parts = [_PartEncoder(part, offset, version, clipped) for part in layout.parts]
        self.identifiers = tuple(part.identifier for part in self._parts)
        """Of all frames, in order."""
        self._only = self._parts[0].made if layout.parts[0].last is None else None

    def raw(self, name: str, value: Any) -> Raw | None:
        """Return the raw value of a signal of the first frame; None when it cannot carry ``value``."""
        slot = next(slot for slot in self._parts[0].part.slots if slot.name == name)
        return slot.convert.write(value)

    def encode(self, message: Any) -> list[Frame]:
        """Return the frames of ``message`` in order; empty parts at the end are left out."""
        if self._only is not None:
            frame = self._only(message)
            return [] if frame is None else [frame]
        rows = [part.made(message) for part in self._parts]
        if None in rows:
            return []
        while len(rows) > 1 and self._parts[len(rows) - 1].is_empty(rows[-1]):
            rows.pop()
        last = self._parts[len(rows) - 1].part.last
        assert last is not None  # noqa: S101 (so are those of more than one frame)
        last.put(rows[-1], 1)
        return [part.frame(row) for part, row in zip(self._parts, rows, strict=False)]


class _PartEncoder:
    def __init__(self, part: Part, offset: int, version: int, clipped: Counter[str]) -> None:
        self.part = part
        self.identifier = part.base + offset
        self._clipped = clipped
        self.made: Callable[[Any], Any] = self._compiled(version % part.version_modulus)
        """Returns the frame, of several the cells of this part; None when the message must not be sent."""

    def is_empty(self, row: list[Raw]) -> bool:
        found = ((slot.place.get(row), slot.convert.absent) for slot in self.part.slots)
        return all(raw == absent or (math.isnan(raw) and math.isnan(absent)) for raw, absent in found)

    def frame(self, row: list[Raw]) -> Frame:
        data = bytearray(self.part.packer.pack(*row))
        self.part.profile.protect(data, self.identifier)
        return Frame(self.identifier, bytes(data), self.part.fd)

    def _compiled(self, version: int) -> Any:
        part = self.part
        cells: dict[int, list[str]] = {}

        def put(place: Place, text: str) -> None:
            cells.setdefault(place.cell, []).append(f"({text}) << {place.shift}" if place.mask else text)

        put(part.version, str(version))
        put(part.counter, f"m.seq % {part.modulus}")
        if part.time is not None:
            put(part.time, f"m.stamp // {MICROSECOND} % {TIME_MODULUS}")
        lines: list[str] = ["def made(m):"]
        scope: dict[str, Any] = {"clip": self._clip, "row": make_row, "Frame": Frame}
        scope |= {"pack": part.packer.pack, "protect": part.profile.protect, "identifier": self.identifier}
        for i, slot in enumerate(part.slots):
            scope[f"w{i}"] = slot.convert.write
            lines += [f" v{i} = {slot.text}", f" r{i} = {slot.convert.writing(f'v{i}', f'w{i}')}"]
            put(slot.place, f"r{i}")
        raws, values = ("".join(f"{letter}{i}, " for i in range(len(part.slots))) for letter in "rv")
        lines += [f" if None in ({raws}):", f"  found = clip(({values}), ({raws}))", "  if None in found:"]
        lines += ["   return None", f"  {raws}= found"]
        row = ", ".join(" | ".join(cells.get(cell, ["0"])) for cell in range(part.cells))
        if part.last is not None:
            return compiled([*lines, f" return [{row}]"], scope)
        lines += [f" data = bytearray(pack({row}))", " protect(data, identifier)"]
        return compiled([*lines, f" return row(Frame, (identifier, bytes(data), {part.fd}, 0))"], scope)

    def _clip(self, values: Sequence[Any], raws: Sequence[Any]) -> list[Any]:
        slots = self.part.slots
        self._clipped.update(slot.name for slot, raw in zip(slots, raws, strict=True) if raw is None)
        return [
            slot.convert.clip(value) if raw is None else raw
            for slot, value, raw in zip(slots, values, raws, strict=True)
        ]
