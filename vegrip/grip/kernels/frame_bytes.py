"""Bytes of a frame: whole numbers, the least significant byte first, and the checksum in front.

That is AUTOSAR E2E profile 5: CRC-16 of all bytes behind it and of the Data ID, low byte first.
"""

import numpy as np

from vegrip.grip.kernels.generated import *

CRC_OF_NIBBLE = np.array([
    0x0000, 0x1021, 0x2042, 0x3063, 0x4084, 0x50A5, 0x60C6, 0x70E7,
    0x8108, 0x9129, 0xA14A, 0xB16B, 0xC18C, 0xD1AD, 0xE1CE, 0xF1EF,
])  # fmt: skip
"""Remainders of the polynomial 0x1021 (CRC-16/CCITT-FALSE)."""


def with_byte(crc: int, byte: int) -> int:
    """Return the remainder after one more byte, half by half."""
    high = (crc << 4 & 0xFFFF) ^ int(CRC_OF_NIBBLE[crc >> 12 ^ byte >> 4])
    return (high << 4 & 0xFFFF) ^ int(CRC_OF_NIBBLE[high >> 12 ^ byte & 15])


def crc_of(data: Bytes, length: int, data_id: int) -> int:
    """Return the checksum of a frame of ``length`` bytes."""
    crc = with_byte(with_byte(0xFFFF, int(data[2])), int(data[3]))
    for i in range(4, length):
        crc = with_byte(crc, int(data[i]))
    return with_byte(with_byte(crc, data_id & 255), data_id >> 8)


def is_intact(data: Bytes, length: int, data_id: int) -> bool:
    """Return whether the checksum fits."""
    return half_word(data, 0) == crc_of(data, length, data_id)


def protect(data: Bytes, length: int, data_id: int) -> None:
    """Put the checksum into a frame that is complete."""
    put_half_word(data, 0, crc_of(data, length, data_id))


def word(data: Bytes, at: int) -> int:
    """Return the 32 bits at byte ``at``."""
    return int(data[at]) | int(data[at + 1]) << 8 | int(data[at + 2]) << 16 | int(data[at + 3]) << 24


def put_word(data: Bytes, at: int, bits: int) -> None:
    """Put 32 bits at byte ``at``."""
    data[at] = bits & 255
    data[at + 1] = (bits >> 8) & 255
    data[at + 2] = (bits >> 16) & 255
    data[at + 3] = (bits >> 24) & 255


def half_word(data: Bytes, at: int) -> int:
    """Return the 16 bits at byte ``at``."""
    return int(data[at]) | int(data[at + 1]) << 8


def put_half_word(data: Bytes, at: int, bits: int) -> None:
    """Put 16 bits at byte ``at``."""
    data[at] = bits & 255
    data[at + 1] = (bits >> 8) & 255
