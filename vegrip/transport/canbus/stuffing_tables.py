"""What a byte does to stuff bits and CRC, made once: counting by bytes is nine times as fast as by bits.

A run is the number ``5 * value + length - 1``, of the last bit and of how many equal ones have gone by;
``NO_RUN`` before the first bit.
"""

from typing import Final

NO_RUN: Final = -1
RUNS: Final = 5
LONGEST_RUN: Final = 5
CRC15: Final = 0x4599
"""Generator polynomial of classic CAN, without its leading term [ISO2015]_."""


def _stuff_byte(run: int, byte: int) -> tuple[int, int]:
    stuffed, (value, length) = 0, divmod(run, RUNS)
    for position in reversed(range(8)):
        bit = byte >> position & 1
        if length == LONGEST_RUN - 1:
            stuffed, value, length = stuffed + 1, 1 - value, 0
        value, length = (value, length + 1) if bit == value else (bit, 0)
    return stuffed, RUNS * value + length


def _crc15_of(byte: int) -> int:
    crc = byte << 7
    for _ in range(8):
        crc = (crc << 1 & 0x7FFF) ^ (CRC15 if crc & 0x4000 else 0)
    return crc


_AFTER = [_stuff_byte(run, byte) for run in range(2 * RUNS) for byte in range(256)]
STUFFED: Final = tuple(stuffed for stuffed, _ in _AFTER)
"""Bits stuffed in by a byte, at ``256 * run + byte``."""
RUN_AFTER: Final = tuple(run for _, run in _AFTER)
"""The run after it, likewise."""
CRC15_OF_BYTE: Final = tuple(_crc15_of(byte) for byte in range(256))
