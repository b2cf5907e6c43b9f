"""Frames as rows of machine words: a compiled `struct` and the place of each signal in it.

``struct`` unpacks a whole frame in one call; a signal is then one item of the tuple (a cell), or a few bits
of a one-byte cell. This is what makes a frame cheap; `benchmarks/codec.py` measures it against cantools.
"""

import struct
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

from cantools.database.can import Message as DbcMessage
from cantools.database.can import Signal

from vegrip.errors import ConfigError

INTEGERS = {8: "b", 16: "h", 32: "i", 64: "q"}
FLOATS = {32: "f", 64: "d"}

Raw = int | float


@dataclass(frozen=True, slots=True)
class Place:
    """Where a signal stands: a whole cell (``mask`` = 0) or some bits of it."""

    cell: int
    shift: int = 0
    mask: int = 0

    @property
    def get(self) -> Callable[[tuple[Raw, ...]], Any]:
        """The function that takes the raw value out of an unpacked frame."""
        cell, shift, mask = self.cell, self.shift, self.mask
        if not mask:
            return itemgetter(cell)  # in C: half the time of a lambda
        return lambda cells: (int(cells[cell]) >> shift) & mask

    @property
    def bits(self) -> tuple[int, int, int]:
        """Cell, shift and mask with which a whole number is taken out of it."""
        return self.cell, self.shift, self.mask or -1

    def put(self, cells: list[Raw], raw: Raw) -> None:
        """Set the raw value in the row to be packed; bits must be clear before."""
        if self.mask:
            cells[self.cell] = int(cells[self.cell]) | int(raw) << self.shift
        else:
            cells[self.cell] = raw


def plan(message: DbcMessage) -> tuple[struct.Struct, Mapping[str, Place]]:
    """Lay out the cells of ``message``; reserved bytes become padding, sent as zero.

    Raises:
        ConfigError: big-endian, multiplexed or oddly placed signals, which the plan cannot express.

    """
    places: dict[str, Place] = {}
    codes: list[str] = []
    end = 0  # bytes laid out so far
    for cell, (start, signals) in enumerate(_bytewise(message)):
        codes.append("x" * (start - end))
        if signals[0].length >= 8:
            codes.append(_code(message, signals[0]))
            places[signals[0].name] = Place(cell)
            end = start + signals[0].length // 8
        else:
            codes.append("B")
            places |= {s.name: Place(cell, s.start % 8, (1 << s.length) - 1) for s in signals}
            end = start + 1
    return struct.Struct("<" + "".join(codes) + "x" * (message.length - end)), places


def _bytewise(message: DbcMessage) -> Iterable[tuple[int, list[Signal]]]:
    groups: dict[int, list[Signal]] = {}
    for signal in sorted(message.signals, key=lambda s: s.start):
        _check(message, signal)
        groups.setdefault(signal.start // 8, []).append(signal)
    return groups.items()


def _check(message: DbcMessage, signal: Signal) -> None:
    fits = signal.start % 8 == 0 if signal.length >= 8 else signal.start % 8 + signal.length <= 8
    multiplexed = signal.is_multiplexer or signal.multiplexer_ids
    if not fits or multiplexed or signal.byte_order != "little_endian":
        raise _unsupported(message, signal)
    if signal.offset != 0 or (signal.is_float and signal.scale != 1):
        raise ConfigError(
            f"fingertip.dbc: {message.name}.{signal.name} must have no offset, a float no scale"
        )


def _code(message: DbcMessage, signal: Signal) -> str:
    code = (FLOATS if signal.is_float else INTEGERS).get(signal.length)
    if code is None:
        raise _unsupported(message, signal)
    return code if signal.is_float or signal.is_signed else code.upper()


def _unsupported(message: DbcMessage, signal: Signal) -> ConfigError:
    return ConfigError(
        f"fingertip.dbc: {message.name}.{signal.name} must be little-endian, not multiplexed, and"
        " either inside one byte or of 8, 16, 32 or 64 bits on a byte boundary"
    )
