"""The states of all fingers of a hand -> their FD frames, in one compiled call and without messages."""

import math
from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.errors import ConfigError
from vegrip.hand_sample import HandSample
from vegrip.transport.codec.convert import FLOAT32_MAX, Converter, Real
from vegrip.transport.codec.database import database
from vegrip.transport.codec.encoder import MICROSECOND, TIME_MODULUS
from vegrip.transport.codec.layout import Layout
from vegrip.types import Flags, Floats

Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]
CRC_BYTES: Final = 2
POLYNOMIAL: Final = 0x1021


class StateRows:
    """Frames of states, packed into the rows of an array; the bytes are those of the encoder.

    Args:
        layout: of states in FD frames.
        offsets: added to the base identifier, one for each finger.
        version: of the message set.
        clipped: where values that float32 cannot hold are counted, by field; they go out as "not measured".

    Raises:
        ConfigError: the layout is not one frame of float32 that all may be missing.

    """

    def __init__(self, layout: Layout, offsets: Sequence[int], version: int, clipped: Counter[str]) -> None:
        (part,) = layout.parts
        if part.time is None or not all(_may_be_missing(slot.convert) for slot in part.slots):
            raise ConfigError(f"fingertip.dbc: {part.name} must have a time and float32 that may be missing")
        signals = {s.name: s.start // 8 for s in database().get_message_by_name(part.name).signals}
        self.identifiers = tuple(part.base + offset for offset in offsets)
        self.length = part.length
        self._names = [slot.name for slot in part.slots]
        self._places = np.array([signals[name] for name in ("seq", "time", *self._names)])
        self._ids = np.array(self.identifiers)
        self._version_at, self._version = signals["version"], version % part.version_modulus
        self._modulus = part.modulus
        self._clipped = clipped
        self._clips = np.zeros(len(self._names), np.int64)

    def prepare(self, rows: Bytes) -> None:
        """Write what is the same in all frames into the first bytes of ``rows``, (n, ``length`` or more)."""
        rows[:, self._version_at] = self._version

    def pack(self, rows: Bytes, sample: HandSample) -> None:
        """Write the frames of ``sample`` into the first bytes of prepared ``rows``, but for what is lost."""
        counter = sample.seq % self._modulus
        found = _pack_states(
            rows, self.length, sample.values, sample.stamps, counter, sample.lost, self._ids, self._places,
            CRC_TABLE, self._clips,
        )  # fmt: skip
        if found:
            self._clipped.update(
                {name: int(n) for name, n in zip(self._names, self._clips, strict=True) if n}
            )
            self._clips[:] = 0


def _may_be_missing(convert: Converter) -> bool:
    real = isinstance(convert, Real) and not (convert.required or convert.infinite)
    return real and math.isnan(convert.absent)


def _crc_table() -> Integers:
    """Return the remainder of each byte with the polynomial of AUTOSAR E2E profile 5."""
    table = np.arange(256) << 8
    for _ in range(8):
        table = np.where(table & 0x8000, table << 1 ^ POLYNOMIAL, table << 1) & 0xFFFF
    return table


CRC_TABLE: Final = _crc_table()


@njit
def _put(row: Bytes, at: int, number: int, size: int) -> None:
    for i in range(size):
        row[at + i] = number >> 8 * i & 255


@njit
def _pack_states(
    rows: Bytes, length: int, values: Floats, stamps: Integers, counter: int, lost: Flags,
    identifiers: Integers, places: Integers, table: Integers, clips: Integers,
) -> int:  # fmt: skip
    """Write counter, time, values and checksum of each frame; return how many values were clipped.

    ``places`` are the bytes at which counter, time and the values begin. What float32 cannot hold becomes
    NaN and is counted in ``clips``, by column.
    """
    clipped = 0
    for i in range(len(rows)):
        if lost[i]:
            continue
        row = rows[i]
        _put(row, places[0], counter, 4)
        _put(row, places[1], stamps[i] // MICROSECOND % TIME_MODULUS, 4)
        for j in range(values.shape[1]):
            value = values[i, j]
            if abs(value) > FLOAT32_MAX:
                value = np.nan
                clips[j] += 1
                clipped += 1
            _put(row, places[2 + j], int(np.float32(value).view(np.uint32)), 4)
        crc = 0xFFFF
        for k in range(CRC_BYTES, length):
            crc = (crc << 8 & 0xFFFF) ^ table[crc >> 8 ^ row[k]]
        for byte in (identifiers[i] & 255, identifiers[i] >> 8):
            crc = (crc << 8 & 0xFFFF) ^ table[crc >> 8 ^ byte]
        _put(row, 0, crc, CRC_BYTES)
    return clipped
