"""Tables of :mod:`vegrip.transport.canbus.kernels.bit_stuffing` as kernels read them.

A run is the number ``5 * value + length - 1``; ``NO_RUN`` before the first bit.
"""

from typing import Final

from vegrip.transport.canbus.kernels.bit_stuffing import (
    CRC15,
    LONGEST_RUN,
    crc15_bit_by_bit,
    stuff_bit_by_bit,
)

NO_RUN: Final = -1
RUNS: Final = 5
GENERATOR: Final = CRC15
UNBROKEN: Final = LONGEST_RUN

_AFTER = [
    [stuff_bit_by_bit((value, length), byte, 8) for byte in range(256)]
    for value in (0, 1)
    for length in range(1, RUNS + 1)
]
STUFFED: Final = tuple(stuffed for row in _AFTER for stuffed, _ in row)
"""Bits stuffed in by a byte, at ``256 * run + byte``."""
RUN_AFTER: Final = tuple(RUNS * value + length - 1 for row in _AFTER for _, (value, length) in row)
"""The run after it, likewise."""
CRC15_OF_BYTE: Final = tuple(crc15_bit_by_bit(0, byte, 8) for byte in range(256))
