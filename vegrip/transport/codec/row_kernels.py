"""Frames in rows of bytes <-> numbers: the compiled loops, in one file (:mod:`vegrip.compiled` says why)."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.transport.codec.convert import FLOAT32_MAX
from vegrip.transport.codec.encoder import MICROSECOND, TIME_MODULUS
from vegrip.types import Flags, Floats

Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]
CRC_BYTES: Final = 2
POLYNOMIAL: Final = 0x1021


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
def _get(row: Bytes, at: int, size: int) -> int:
    number = 0
    for i in range(size):
        number |= int(row[at + i]) << 8 * i
    return number


@njit
def _crc(row: Bytes, start: int, length: int, identifier: int, table: Integers) -> int:
    """Return the checksum of E2E profile 5 for the frame of ``length`` bytes that begins at ``start``."""
    crc = 0xFFFF
    for k in range(start + CRC_BYTES, start + length):
        crc = (crc << 8 & 0xFFFF) ^ table[crc >> 8 ^ row[k]]
    crc = (crc << 8 & 0xFFFF) ^ table[crc >> 8 ^ identifier & 255]
    return int((crc << 8 & 0xFFFF) ^ table[crc >> 8 ^ identifier >> 8])


@njit
def pack_states(
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
        _put(row, 0, _crc(row, 0, length, identifiers[i], table), CRC_BYTES)
    return clipped


@njit
def _single(row: Bytes, at: int) -> float:
    return float(np.uint32(_get(row, at, 4)).view(np.float32))


@njit
def _is_next(row: Bytes, head: Integers, i: int, wholes: Integers) -> bool:
    """Take number, end and busy of delivery ``i``; return whether it is a command's size, and the next."""
    wholes[i, 1], wholes[i, 2], wholes[i, 3] = (
        _get(row, head[0], 4),
        _get(row, head[1], 8),
        _get(row, head[2], 8),
    )
    follows = i == 0 or wholes[i, 1] == (wholes[i - 1, 1] + 1) & 0xFFFFFFFF
    return bool(follows and row[head[4]] & head[6] == head[7] and row[head[5]] == head[8])


@njit
def read_commands(
    rows: Bytes, head: Integers, length: int, identifiers: Integers, places: Integers, version: int,
    reasons: Flags, lifetimes: Integers, table: Integers, wholes: Integers, forces: Floats,
) -> bool:  # fmt: skip
    """Read commands from delivered frames; return whether every row is one, well, and next to the last.

    ``head`` says where a row has the number of the delivery, its end, the time the bus was busy, the
    identifier, the flags and the code of the length; which flags matter and what they must be, the code, and
    where the frame begins. ``places`` are the bytes of the frame with counter, version, time, force,
    adjustment, reason and lifetime; ``reasons`` the codes that are known, ``lifetimes`` the least and the
    greatest raw one. ``wholes`` (m, 8) takes which finger it is for, number, end [ns], busy [ns], counter,
    time [us], reason and raw lifetime; ``forces`` (m,) the force [N].
    """
    for i in range(len(rows)):
        row, out = rows[i], wholes[i]
        if not _is_next(row, head, i, wholes):
            return False
        identifier, start, out[0] = _get(row, head[3], 4), head[9], -1
        for k in range(len(identifiers)):
            if identifiers[k] == identifier:
                out[0] = k
        if out[0] < 0 or _get(row, start, CRC_BYTES) != _crc(row, start, length, identifier, table):
            return False
        out[4], out[5] = _get(row, start + places[0], 4), _get(row, start + places[2], 4)
        out[6], out[7] = row[start + places[5]], _get(row, start + places[6], 2)
        forces[i] = _single(row, start + places[3])
        is_whole = math.isfinite(forces[i]) and math.isfinite(_single(row, start + places[4]))
        is_known = row[start + places[1]] == version and reasons[out[6]]
        if not (is_whole and is_known and lifetimes[0] <= out[7] <= lifetimes[1]):
            return False
    return True


@njit
def find_frames(data: Bytes, head: Integers, sizes: Integers, found: Integers, last: Integers) -> int:
    """Find CAN FD data frames with 11 bits among deliveries that stand one behind the other.

    Return how many these are; -1 where one is something else or does not follow the one before.

    Args:
        data: the deliveries.
        head: as in :func:`read_commands`, without the code of the length.
        sizes: of frames by their code [bytes].
        found: (m, 4) takes identifier, end [ns], begin of the data and its length.
        last: takes number of the first, end and busy [ns] of the last.

    """
    at, count, start = 0, 0, head[9]
    while at < len(data):
        if len(data) - at < start or count == len(found):
            return -1
        row = data[at:]
        number, identifier, code = _get(row, head[0], 4), _get(row, head[3], 4), row[head[5]]
        if count == 0:
            last[0] = number
        follows = number == (last[0] + count) & 0xFFFFFFFF
        if not follows or row[head[4]] & head[6] != head[7] or code >= len(sizes) or identifier >> 11:
            return -1
        last[1], last[2] = _get(row, head[1], 8), _get(row, head[2], 8)
        found[count, 0], found[count, 1] = identifier, last[1]
        found[count, 2], found[count, 3] = at + start, sizes[code]
        at += start + sizes[code]
        count += 1
    return count if at == len(data) else -1
